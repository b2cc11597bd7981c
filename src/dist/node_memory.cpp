#include "noiseloom/dist/node_memory.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/mman.h>
#include <sys/random.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdint>
#include <string>

#include "dist/mpi_impl.h"
#include "noiseloom/dist/activity.h"

namespace noiseloom {
namespace {

// Of POSIX shared memory: a name that no other run has, and that stands in /dev/shm for an instant only.
std::string fresh_name() {
  std::array<std::uint64_t, 2> random{};
  if (getrandom(random.data(), sizeof random, 0) != static_cast<ssize_t>(sizeof random)) return "";
  return fmt::format("/noiseloom-node-{:016x}{:016x}", random[0], random[1]);
}

class Mapping {
 public:
  Mapping(int file, std::size_t bytes, int protection) : bytes_(bytes) {
    void* const at = mmap(nullptr, bytes, protection, MAP_SHARED, file, 0);
    at_ = at == MAP_FAILED ? nullptr : at;
  }
  ~Mapping() {
    if (at_ != nullptr) munmap(at_, bytes_);
  }
  Mapping(const Mapping&) = delete;
  Mapping& operator=(const Mapping&) = delete;

  std::byte* data() const { return static_cast<std::byte*>(at_); }

 private:
  void* at_ = nullptr;
  std::size_t bytes_;
};

// The block of that name; nullptr where it cannot be had. Its pages are taken now: a full /dev/shm would else end the
// process when they are written.
std::shared_ptr<Mapping> map_block(const std::string& name, std::size_t bytes, bool creates) {
  const int file = shm_open(name.c_str(), creates ? O_RDWR | O_CREAT | O_EXCL : O_RDONLY, 0600);
  if (file < 0) return nullptr;
  std::shared_ptr<Mapping> block;
  int refused = creates ? EINTR : 0;
  while (refused == EINTR) refused = posix_fallocate(file, 0, static_cast<off_t>(bytes));
  if (refused == 0) {
    block = std::make_shared<Mapping>(file, bytes, creates ? PROT_READ | PROT_WRITE : PROT_READ);
    if (block->data() == nullptr) block.reset();
  }
  close(file);
  return block;
}

class NodeRanks {
 public:
  explicit NodeRanks(MPI_Comm all) {
    check_mpi(MPI_Comm_split_type(all, MPI_COMM_TYPE_SHARED, 0, MPI_INFO_NULL, &comm_), "MPI_Comm_split_type");
    MPI_Comm_size(comm_, &size_);
    MPI_Comm_rank(comm_, &rank_);
  }
  ~NodeRanks() { MPI_Comm_free(&comm_); }
  NodeRanks(const NodeRanks&) = delete;
  NodeRanks& operator=(const NodeRanks&) = delete;

  bool is_alone() const { return size_ == 1; }
  bool is_first() const { return rank_ == 0; }
  void tell(std::string& name) const {
    std::array<char, 64> text{};
    name.copy(text.data(), text.size() - 1);
    check_mpi(MPI_Bcast(text.data(), static_cast<int>(text.size()), MPI_CHAR, 0, comm_), "MPI_Bcast");
    name = text.data();
  }
  bool all_have(bool own) const {
    int all = own ? 1 : 0;
    check_mpi(MPI_Allreduce(MPI_IN_PLACE, &all, 1, MPI_INT, MPI_MIN, comm_), "MPI_Allreduce");
    return all != 0;
  }
  void meet() const {
    const Activity waiting(Activity::Kind::waiting, "waits for the ranks of its node");
    check_mpi(MPI_Barrier(comm_), "MPI_Barrier");
  }

 private:
  MPI_Comm comm_ = MPI_COMM_NULL;
  int size_ = 1;
  int rank_ = 0;
};

}  // namespace

struct NodeMemory::Impl {
  explicit Impl(MPI_Comm all) : node(all) {}

  // Whether all ranks of the node see one block now.
  bool share() {
    std::string name = node.is_first() ? fresh_name() : "";
    if (node.is_first() && !name.empty()) mapping = map_block(name, bytes, true);
    if (!mapping) name.clear();
    node.tell(name);
    if (!node.is_first() && !name.empty()) mapping = map_block(name, bytes, false);
    const bool shared = node.all_have(mapping != nullptr);
    if (node.is_first() && !name.empty()) shm_unlink(name.c_str());
    if (!shared) mapping.reset();
    return shared;
  }

  NodeRanks node;
  std::size_t bytes = 0;
  std::shared_ptr<Mapping> mapping;  // where the ranks of the node share the block
  std::shared_ptr<std::byte[]> own;  // where this rank has its own
};

NodeMemory::NodeMemory(const Communicator& communicator, std::size_t bytes) {
  const Activity waiting(Activity::Kind::waiting, "waits for the ranks of its node");
  impl_ = std::make_unique<Impl>(communicator.impl().comm);
  impl_->bytes = bytes;
  const bool shared = bytes > 0 && !impl_->node.is_alone() && impl_->share();
  communicator.together([&] {
    if (!shared) impl_->own = std::make_shared_for_overwrite<std::byte[]>(bytes);
  });
}
NodeMemory::~NodeMemory() = default;

std::span<std::byte> NodeMemory::to_fill() const {
  if (impl_->own) return {impl_->own.get(), impl_->bytes};
  return impl_->node.is_first() ? std::span(impl_->mapping->data(), impl_->bytes) : std::span<std::byte>();
}

std::span<const std::byte> NodeMemory::wait_until_filled() const {
  impl_->node.meet();
  return {impl_->own ? impl_->own.get() : impl_->mapping->data(), impl_->bytes};
}

std::shared_ptr<const void> NodeMemory::owner() const {
  if (impl_->own) return impl_->own;
  return impl_->mapping;
}

}  // namespace noiseloom
