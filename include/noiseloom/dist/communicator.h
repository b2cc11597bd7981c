// The ranks of a run. Wraps one MPI communicator; only src/dist sees mpi.h. Every function marked *Collective* must be
// called by all ranks in the same order.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "noiseloom/core/distribution.h"
#include "noiseloom/core/error.h"

namespace noiseloom {

// MPI_Init and MPI_Finalize. When the process was not started by a launcher, MPI is still initialised (one rank).
class MpiSession {
 public:
  MpiSession(int& argc, char**& argv);
  ~MpiSession();
  MpiSession(const MpiSession&) = delete;
  MpiSession& operator=(const MpiSession&) = delete;
};

// Failures that every rank has been told of and throws: nobody is left waiting. What is thrown otherwise on one rank of
// several must end in Communicator::abort.
class SharedUserError : public UserError {
  using UserError::UserError;
};
class SharedEnvironmentError : public EnvironmentError {
  using EnvironmentError::EnvironmentError;
};

class Communicator {
 public:
  static constexpr Rank root{0};

  // Duplicates MPI_COMM_WORLD. *Collective*
  static Communicator world();
  // This process alone.
  static Communicator self();
  // The ranks in groups of `size` that follow each other, the last one of what is left: that of this rank. *Collective*
  Communicator group_of(int size) const;
  ~Communicator();
  Communicator(Communicator&&) noexcept;

  Rank rank() const;
  int size() const;
  IndexRange<Rank> ranks() const { return first_indices<Rank>(size()); }
  bool is_root() const { return rank() == root; }
  // Ranks that share this rank's memory (its node). *Collective*
  int ranks_on_node() const;

  // Ends all ranks at once, wherever they are.
  [[noreturn]] void abort(int status) const;
  void barrier() const;                              // *Collective*
  std::uint32_t any_bits(std::uint32_t bits) const;  // bitwise or over ranks. *Collective*
  void sum(std::span<std::int64_t> values) const;    // integers: exact in any order. *Collective*
  // The least of all ranks' pairs, compared by their first words, then by their second. *Collective*
  std::array<std::uint64_t, 2> least(std::array<std::uint64_t, 2> pair) const;
  void broadcast(std::string& bytes) const;  // from rank 0. *Collective*
  double broadcast(double value) const;      // from rank 0. *Collective*
  // Values of all ranks, each giving those of its own block of `partition`, in the order of the partition, on every
  // rank. *Collective*
  std::vector<double> gather_all(const Partition& partition, std::span<const double> own) const;

  // What all ranks give, one rank's after the other's, on every rank: the same number of words of each, or bytes: those
  // numbers of them that every rank knows, or any (two of MPI's collectives, as the numbers travel first). *Collective*
  std::vector<std::uint64_t> gather_all(std::span<const std::uint64_t> own) const;
  std::vector<std::byte> gather_all(std::span<const std::byte> own) const;
  std::vector<std::byte> gather_all(std::span<const std::byte> own, std::span<const int> counts) const;

  // If any rank has an exception, all throw that of the lowest such rank: UserError as SharedUserError, anything else
  // as SharedEnvironmentError with its words. *Collective*
  void agree(std::exception_ptr own) const;
  // Calls `body` on every rank, or on rank 0 alone, then agrees; so that no rank throws alone before a collective.
  // *Collective*
  void together(const std::function<void()>& body) const;
  void on_root(const std::function<void()>& body) const;

  // Streams the block of bytes of every slice, in slice order, from its owner to rank 0. `produce` is called on the
  // owner, `consume` on rank 0; memory for one slice at a time. Where a `produce` throws, nothing more is consumed;
  // where one or `consume` throws, the rest is drained, then every rank throws as agree() does. *Collective*
  void stream_to_root(const Distribution& distribution,
                      const std::function<void(SliceIndex, std::vector<std::byte>&)>& produce,
                      const std::function<void(SliceIndex, std::span<const std::byte>)>& consume) const;
  // The other way: every rank names the slices that it wants (ascending, each once), and those alone are sent to it.
  // `produce` is called on rank 0, once for each slice that any rank wants, in slice order; `consume` on the ranks that
  // want it. Memory for one slice at a time. The same rule for errors. *Collective*
  void stream_from_root(std::span<const SliceIndex> wanted,
                        const std::function<void(SliceIndex, std::vector<std::byte>&)>& produce,
                        const std::function<void(SliceIndex, std::span<const std::byte>)>& consume) const;

  struct Impl;
  const Impl& impl() const { return *impl_; }

 private:
  explicit Communicator(std::unique_ptr<Impl> impl);
  // On rank 0 what all ranks want, as (slice, rank), sorted; nothing elsewhere. *Collective*
  std::vector<std::pair<SliceIndex, Rank>> requests_at_root(std::span<const SliceIndex> wanted) const;
  std::unique_ptr<Impl> impl_;
};

}  // namespace noiseloom
