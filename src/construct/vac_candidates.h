// The next candidates of a texture: all pixels with a key up to some limit, a few thousandths of the pixels at a time.
// Every part of every rank looks through its own slices and keeps what it finds.
#pragma once

#include "construct/vac_exchange.h"
#include "construct/vac_fields.h"

namespace noiseloom {

class VacSearch {
 public:
  // Fields and exchange must outlive the search. At most `max_found` >= 1 candidates of a part of a rank at a time;
  // 0: chosen by the number of pixels.
  VacSearch(VacFields& fields, VacExchange& exchange, const VacTieHash& hash, std::size_t max_found = 0);

  // Finds all pixels of the texture with a key up to the limit that is returned, the same on every rank; at least one
  // unless none is left, where the limit is 0. The limit is such that a share of about `fraction` of the leaves may
  // reach it, going by their bounds. Bounds must be right for `view`. *Collective*
  std::uint64_t find(VacView view, double fraction);
  // After find: those of a part of this rank, ascending in position; and how many all ranks have found.
  std::span<const VacCandidate> found(std::size_t part) const { return parts_[part].found; }
  std::uint64_t num_found() const { return num_found_; }

 private:
  struct Part {
    std::vector<VacCandidate> found;
    bool fits = true;
  };
  std::uint64_t propose(double fraction);
  std::uint64_t lower_limit();

  VacFields& fields_;
  VacExchange& exchange_;
  VacTieHash hash_;
  std::size_t max_found_;
  std::vector<Part> parts_;
  std::uint64_t num_found_ = 0;
};

}  // namespace noiseloom
