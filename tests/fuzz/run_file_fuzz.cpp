// Run files that are anything: the reader throws, or gives what the file says; it never crashes and takes no memory
// that the file does not account for. The digests are made to fit first: they are against damage, and would stop nearly
// every input at once.
//
// With libFuzzer (see CMakeLists.txt here) this is a target; without, a program that tries files:
//   run_file_fuzz --seeds FOLDER     writes small sound files to begin with
//   run_file_fuzz FILE...            tries each
#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "noiseloom/files/generations.h"
#include "noiseloom/files/run_file.h"
#include "support/run_file_digests.h"

namespace {

using namespace noiseloom;

// The file that is tried, in memory.
class MemoryFile {
 public:
  explicit MemoryFile(const std::string& bytes) : fd_(::memfd_create("run_file", 0)) {
    posix_file_ops().write(fd_, 0, std::as_bytes(std::span(bytes)));
  }
  ~MemoryFile() { ::close(fd_); }
  MemoryFile(const MemoryFile&) = delete;
  MemoryFile& operator=(const MemoryFile&) = delete;
  std::string path() const { return "/proc/self/fd/" + std::to_string(fd_); }

 private:
  int fd_;
};

void try_file(const std::string& bytes) {
  const MemoryFile file(bytes);
  for (const Changed changed : {Changed::refused, Changed::accepted}) {
    try {
      const RunFileReader reader(file.path(), changed);
      const RunFileContent& content = reader.content();
      std::vector<std::byte> slice;
      for (std::size_t dataset = 0; dataset < content.datasets.size(); ++dataset) {
        slice.resize(bytes_per_slice(content.datasets[dataset], content.extents));
        for (SliceIndex index = 0; index < std::min(content.extents.num_slices(), 100); ++index) {
          reader.read_slice(static_cast<int>(dataset), index, slice);
        }
      }
    } catch (const UserError&) {
    } catch (const EnvironmentError&) {
    }
  }
  looks_like_run_file(file.path());
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string bytes(reinterpret_cast<const char*>(data), size);
  try_file(with_fitting_digests(bytes));
  if (size % 8 == 0) try_file(bytes);
  return 0;
}

// HDF5 1.10 loses some hundred bytes of its own where it gives a damaged file up.
extern "C" const char* __lsan_default_suppressions() { return "leak:libhdf5"; }

#ifndef NOISELOOM_LIBFUZZER
namespace {

void write_seed(const std::string& path, const Extents& extents, const std::vector<SliceDataset>& datasets) {
  RunFileContent content;
  content.extents = extents;
  content.config = "[texture]\nsize = { x = 3, y = 2 }\n";
  content.datasets = datasets;
  content.state = {{"sweep", std::int64_t{1}}, {"temperature", 0.5}, {"finished", std::string("iterations")}};
  content.history = {{"sweep", {1, 2}}, {"seconds", {0.5, 1.5}}};
  content.provenance = {{"version", std::string("0.1.0")}};
  RunFileWriter writer(posix_file_ops(), path, content);
  for (std::size_t dataset = 0; dataset < datasets.size(); ++dataset) {
    const std::vector<std::byte> bytes(bytes_per_slice(datasets[dataset], extents));
    for (SliceIndex slice = 0; slice < extents.num_slices(); ++slice) {
      writer.write_slice(static_cast<int>(dataset), slice, bytes);
    }
  }
  writer.publish();
}

void write_seeds(const std::string& folder) {
  const SliceDataset samples{"/samples", ElementType::float32, 2, true};
  write_seed(folder + "/swaps", Extents({3, 2, 2}), {samples, {"/state/permutation", ElementType::uint32, 1, false}});
  write_seed(folder + "/order", Extents({3, 2, 2, 2}), {samples, {"/order", ElementType::uint64, 1, false}});
  write_seed(folder + "/plain", Extents({1, 1}), {samples, {"/pdf", ElementType::float32, 1, false}});
}

}  // namespace

int main(int argc, char** argv) {
  if (argc == 3 && std::string(argv[1]) == "--seeds") {
    write_seeds(argv[2]);
    return 0;
  }
  for (int i = 1; i < argc; ++i) {
    std::ifstream in(argv[i], std::ios::binary);
    const std::string bytes{std::istreambuf_iterator<char>(in), {}};
    LLVMFuzzerTestOneInput(reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size());
  }
  std::printf("%d files tried\n", argc - 1);
  return 0;
}
#endif
