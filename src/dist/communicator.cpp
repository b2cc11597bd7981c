#include "noiseloom/dist/communicator.h"

#include <algorithm>
#include <array>
#include <cstdlib>
#include <exception>
#include <new>
#include <numeric>
#include <optional>
#include <utility>

#include "dist/mpi_impl.h"
#include "noiseloom/core/error.h"
#include "noiseloom/dist/activity.h"
#include "noiseloom/dist/launcher.h"

namespace noiseloom {
namespace {

constexpr int stream_tag = 1;
// MPI counts are ints: larger blocks travel in pieces.
constexpr std::size_t piece_bytes = std::size_t{1} << 30;

// Stands in the place of a block's size where there is no block, as its producer failed.
constexpr std::uint64_t no_block = ~std::uint64_t{0};

Activity waiting_for_all() { return Activity(Activity::Kind::waiting, "waits for all ranks"); }

void send_size(const Communicator::Impl& impl, Rank to, std::uint64_t size) {
  check_mpi(MPI_Send(&size, 1, MPI_UINT64_T, to.value(), stream_tag, impl.comm), "MPI_Send");
}

void send_block(const Communicator::Impl& impl, Rank to, std::span<const std::byte> block) {
  const Activity sending(Activity::Kind::waiting, "sends a slice to", to);
  send_size(impl, to, block.size());
  for (std::size_t at = 0; at < block.size(); at += piece_bytes) {
    const int count = static_cast<int>(std::min(piece_bytes, block.size() - at));
    check_mpi(MPI_Send(block.data() + at, count, MPI_BYTE, to.value(), stream_tag, impl.comm), "MPI_Send");
  }
}

// False where there is no block.
bool receive_block(const Communicator::Impl& impl, Rank from, std::vector<std::byte>& block) {
  const Activity receiving(Activity::Kind::waiting, "waits for a slice of", from);
  std::uint64_t size = 0;
  check_mpi(MPI_Recv(&size, 1, MPI_UINT64_T, from.value(), stream_tag, impl.comm, MPI_STATUS_IGNORE), "MPI_Recv");
  if (size == no_block) return false;
  block.resize(size);
  for (std::size_t at = 0; at < block.size(); at += piece_bytes) {
    const int count = static_cast<int>(std::min(piece_bytes, block.size() - at));
    check_mpi(MPI_Recv(block.data() + at, count, MPI_BYTE, from.value(), stream_tag, impl.comm, MPI_STATUS_IGNORE),
              "MPI_Recv");
  }
  return true;
}

// Runs `call` unless an earlier one failed; keeps the first failure.
template <class Call>
void guarded(std::exception_ptr& failure, const Call& call) {
  if (failure) return;
  try {
    call();
  } catch (...) {
    failure = std::current_exception();
  }
}

// A failure as bytes: 'u' for a UserError, 'e' for anything else, then its words.
std::string packed_failure(const std::exception_ptr& failure) {
  try {
    std::rethrow_exception(failure);
  } catch (const UserError& error) {
    return std::string("u") + error.what();
  } catch (const std::bad_alloc&) {
    return "eout of memory";
  } catch (const std::exception& error) {
    return std::string("e") + error.what();
  }
}

}  // namespace

void check_mpi(int code, const char* what) {
  if (code == MPI_SUCCESS) return;
  std::array<char, MPI_MAX_ERROR_STRING> text{};
  int length = 0;
  MPI_Error_string(code, text.data(), &length);
  throw EnvironmentError(std::string(what) + ": " + std::string(text.data(), static_cast<std::size_t>(length)));
}

MpiSession::MpiSession(int& argc, char**& argv) {
  // Without a launcher Open MPI starts a daemon for spawning, which nothing here does: it takes half a second, and
  // files and signals of its own. Looking for networks and graphics cards takes another quarter of one.
  if (!has_launcher()) {
    setenv("OMPI_MCA_ess_singleton_isolated", "1", 0);
    // All that run alone share one folder of the machine, which each removes when it ends: under another's hands, who
    // then fails. One rank has nothing to put there.
    setenv("OMPI_MCA_orte_create_session_dirs", "0", 0);
    setenv("OMPI_MCA_pml", "ob1", 0);
    setenv("OMPI_MCA_btl", "self", 0);
    setenv("HWLOC_PLUGINS_PATH", "/dev/null", 0);
  }
  int provided = 0;
  check_mpi(MPI_Init_thread(&argc, &argv, MPI_THREAD_FUNNELED, &provided), "MPI_Init_thread");
}
MpiSession::~MpiSession() { MPI_Finalize(); }

Communicator::Communicator(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {
  check_mpi(MPI_Comm_set_errhandler(impl_->comm, MPI_ERRORS_RETURN), "MPI_Comm_set_errhandler");
  check_mpi(MPI_Comm_rank(impl_->comm, &impl_->rank), "MPI_Comm_rank");
  check_mpi(MPI_Comm_size(impl_->comm, &impl_->size), "MPI_Comm_size");
}
Communicator::Communicator(Communicator&&) noexcept = default;
Communicator::~Communicator() {
  if (impl_ && impl_->comm != MPI_COMM_NULL) MPI_Comm_free(&impl_->comm);
}

Communicator Communicator::world() {
  auto impl = std::make_unique<Impl>();
  check_mpi(MPI_Comm_dup(MPI_COMM_WORLD, &impl->comm), "MPI_Comm_dup");
  return Communicator(std::move(impl));
}

Communicator Communicator::self() {
  auto impl = std::make_unique<Impl>();
  check_mpi(MPI_Comm_dup(MPI_COMM_SELF, &impl->comm), "MPI_Comm_dup");
  return Communicator(std::move(impl));
}

Communicator Communicator::group_of(int size) const {
  auto impl = std::make_unique<Impl>();
  check_mpi(MPI_Comm_split(impl_->comm, impl_->rank / size, impl_->rank, &impl->comm), "MPI_Comm_split");
  return Communicator(std::move(impl));
}

Rank Communicator::rank() const { return Rank(impl_->rank); }
int Communicator::size() const { return impl_->size; }

int Communicator::ranks_on_node() const {
  MPI_Comm node = MPI_COMM_NULL;
  check_mpi(MPI_Comm_split_type(impl_->comm, MPI_COMM_TYPE_SHARED, 0, MPI_INFO_NULL, &node), "MPI_Comm_split_type");
  int count = 1;
  MPI_Comm_size(node, &count);
  MPI_Comm_free(&node);
  return count;
}

void Communicator::abort(int status) const {
  MPI_Abort(impl_->comm, status);
  std::abort();
}

void Communicator::barrier() const {
  const Activity waiting = waiting_for_all();
  check_mpi(MPI_Barrier(impl_->comm), "MPI_Barrier");
}

std::uint32_t Communicator::any_bits(std::uint32_t bits) const {
  if (size() == 1) return bits;
  const Activity waiting = waiting_for_all();
  std::uint32_t all = 0;
  check_mpi(MPI_Allreduce(&bits, &all, 1, MPI_UINT32_T, MPI_BOR, impl_->comm), "MPI_Allreduce");
  return all;
}

void Communicator::sum(std::span<std::int64_t> values) const {
  if (size() == 1) return;
  const Activity waiting = waiting_for_all();
  check_mpi(
      MPI_Allreduce(MPI_IN_PLACE, values.data(), static_cast<int>(values.size()), MPI_INT64_T, MPI_SUM, impl_->comm),
      "MPI_Allreduce");
}

// Gathered, not reduced: quicker on few ranks than an operation of our own, and 16 bytes a rank are little on many.
std::array<std::uint64_t, 2> Communicator::least(std::array<std::uint64_t, 2> pair) const {
  const auto all = gather_all(std::span<const std::uint64_t>(pair));
  for (std::size_t i = 0; i < all.size(); i += 2) pair = std::min(pair, {all[i], all[i + 1]});
  return pair;
}

void Communicator::broadcast(std::string& bytes) const {
  const Activity waiting = waiting_for_all();
  std::uint64_t length = bytes.size();
  check_mpi(MPI_Bcast(&length, 1, MPI_UINT64_T, 0, impl_->comm), "MPI_Bcast");
  bytes.resize(length);
  check_mpi(MPI_Bcast(bytes.data(), narrow<int>(length), MPI_BYTE, 0, impl_->comm), "MPI_Bcast");
}

double Communicator::broadcast(double value) const {
  const Activity waiting = waiting_for_all();
  check_mpi(MPI_Bcast(&value, 1, MPI_DOUBLE, 0, impl_->comm), "MPI_Bcast");
  return value;
}

std::vector<double> Communicator::gather_all(const Partition& partition, std::span<const double> own) const {
  NOISELOOM_CHECK_EQ(partition.num_ranks(), size());
  NOISELOOM_CHECK_EQ(narrow<std::int32_t>(own.size()), partition.count(rank()));
  IndexedVector<Rank, int> counts(static_cast<std::size_t>(size()));
  IndexedVector<Rank, int> starts(static_cast<std::size_t>(size()));
  for (const Rank r : ranks()) {
    counts[r] = partition.count(r);
    starts[r] = partition.begin(r);
  }
  std::vector<double> all(static_cast<std::size_t>(partition.num_slices()));
  const Activity waiting = waiting_for_all();
  check_mpi(MPI_Allgatherv(own.data(), static_cast<int>(own.size()), MPI_DOUBLE, all.data(), counts.data(),
                           starts.data(), MPI_DOUBLE, impl_->comm),
            "MPI_Allgatherv");
  return all;
}

std::vector<std::uint64_t> Communicator::gather_all(std::span<const std::uint64_t> own) const {
  std::vector<std::uint64_t> all(own.size() * static_cast<std::size_t>(size()));
  const int count = narrow<int>(own.size());
  const Activity waiting = waiting_for_all();
  check_mpi(MPI_Allgather(own.data(), count, MPI_UINT64_T, all.data(), count, MPI_UINT64_T, impl_->comm),
            "MPI_Allgather");
  return all;
}

std::vector<std::byte> Communicator::gather_all(std::span<const std::byte> own) const {
  if (size() == 1) return {own.begin(), own.end()};
  const int count = narrow<int>(own.size());
  std::vector<int> counts(static_cast<std::size_t>(size()));
  {
    const Activity waiting = waiting_for_all();
    check_mpi(MPI_Allgather(&count, 1, MPI_INT, counts.data(), 1, MPI_INT, impl_->comm), "MPI_Allgather");
  }
  return gather_all(own, counts);
}

std::vector<std::byte> Communicator::gather_all(std::span<const std::byte> own, std::span<const int> counts) const {
  NOISELOOM_CHECK_EQ(narrow<int>(counts.size()), size());
  std::vector<int> starts;
  std::int64_t total = 0;
  for (const int part : counts) {
    starts.push_back(narrow<int>(total));
    total += part;
  }
  std::vector<std::byte> all(static_cast<std::size_t>(total));
  const Activity waiting = waiting_for_all();
  check_mpi(MPI_Allgatherv(own.data(), narrow<int>(own.size()), MPI_BYTE, all.data(), counts.data(), starts.data(),
                           MPI_BYTE, impl_->comm),
            "MPI_Allgatherv");
  return all;
}

void Communicator::agree(std::exception_ptr own) const {
  const int none = size();
  int first = own ? impl_->rank : none;
  const Activity waiting = waiting_for_all();
  check_mpi(MPI_Allreduce(MPI_IN_PLACE, &first, 1, MPI_INT, MPI_MIN, impl_->comm), "MPI_Allreduce");
  if (first == none) return;
  std::string message = first == impl_->rank ? packed_failure(own) : "";
  std::uint64_t length = message.size();
  check_mpi(MPI_Bcast(&length, 1, MPI_UINT64_T, first, impl_->comm), "MPI_Bcast");
  message.resize(length);
  check_mpi(MPI_Bcast(message.data(), narrow<int>(length), MPI_BYTE, first, impl_->comm), "MPI_Bcast");
  if (message.front() == 'u') throw SharedUserError("", message.substr(1));
  throw SharedEnvironmentError(message.substr(1));
}

void Communicator::together(const std::function<void()>& body) const {
  std::exception_ptr failure;
  guarded(failure, body);
  agree(failure);
}

void Communicator::on_root(const std::function<void()>& body) const {
  together([&] {
    if (is_root()) body();
  });
}

void Communicator::stream_to_root(const Distribution& distribution,
                                  const std::function<void(SliceIndex, std::vector<std::byte>&)>& produce,
                                  const std::function<void(SliceIndex, std::span<const std::byte>)>& consume) const {
  std::exception_ptr failure;
  std::vector<std::byte> block;
  bool complete = true;  // on rank 0: nobody's producer has failed
  for (const SliceIndex slice : first_indices<SliceIndex>(distribution.num_slices())) {
    const Rank owner = distribution.owner(slice);
    if (owner == rank()) {
      guarded(failure, [&] { produce(slice, block); });
      if (failure) {
        complete = false;
        if (!is_root()) send_size(*impl_, root, no_block);
      } else if (!is_root()) {
        send_block(*impl_, root, block);
      }
    } else if (is_root()) {
      complete = receive_block(*impl_, owner, block) && complete;
    }
    if (is_root() && complete) guarded(failure, [&] { consume(slice, block); });
  }
  agree(failure);
}

void Communicator::stream_from_root(std::span<const SliceIndex> wanted,
                                    const std::function<void(SliceIndex, std::vector<std::byte>&)>& produce,
                                    const std::function<void(SliceIndex, std::span<const std::byte>)>& consume) const {
  const std::vector<std::pair<SliceIndex, Rank>> requests = requests_at_root(wanted);
  std::exception_ptr failure;
  std::vector<std::byte> block;
  if (!is_root()) {
    for (const SliceIndex slice : wanted) {
      if (!receive_block(*impl_, root, block)) break;
      guarded(failure, [&] { consume(slice, block); });
    }
    return agree(failure);
  }
  IndexedVector<Rank, bool> told(static_cast<std::size_t>(size()));  // that there is no more
  std::optional<SliceIndex> produced;
  bool complete = true;
  for (const auto& request : requests) {
    const SliceIndex slice = request.first;
    const Rank to = request.second;
    if (complete && produced != slice) {
      std::exception_ptr own;
      guarded(own, [&] { produce(slice, block); });
      produced = slice;
      complete = !own;
      if (own && !failure) failure = own;
    }
    if (to == root) {
      if (complete) guarded(failure, [&] { consume(slice, block); });
    } else if (complete) {
      send_block(*impl_, to, block);
    } else if (!told[to]) {
      send_size(*impl_, to, no_block);
      told[to] = true;
    }
  }
  agree(failure);
}

std::vector<std::pair<SliceIndex, Rank>> Communicator::requests_at_root(std::span<const SliceIndex> wanted) const {
  const Activity waiting = waiting_for_all();
  const int own_count = narrow<int>(wanted.size());
  IndexedVector<Rank, int> counts(static_cast<std::size_t>(size()));
  check_mpi(MPI_Gather(&own_count, 1, MPI_INT, counts.data(), 1, MPI_INT, 0, impl_->comm), "MPI_Gather");
  IndexedVector<Rank, int> starts(counts.size());
  std::exclusive_scan(counts.begin(), counts.end(), starts.begin(), 0);
  std::vector<SliceIndex> all(is_root() ? std::accumulate(counts.begin(), counts.end(), std::size_t{0}) : 0);
  static_assert(sizeof(SliceIndex) == sizeof(std::int32_t));
  check_mpi(MPI_Gatherv(wanted.data(), own_count, MPI_INT32_T, all.data(), counts.data(), starts.data(), MPI_INT32_T, 0,
                        impl_->comm),
            "MPI_Gatherv");
  std::vector<std::pair<SliceIndex, Rank>> requests;
  if (!is_root()) return requests;
  for (const Rank r : ranks()) {
    const auto begin = all.begin() + starts[r];
    for (auto slice = begin; slice != begin + counts[r]; ++slice) requests.emplace_back(*slice, r);
  }
  std::sort(requests.begin(), requests.end());
  return requests;
}

}  // namespace noiseloom
