// Run files that are anything: the reader throws, or gives what the file says; it never crashes and takes no memory
// that the file does not account for. The digests are made to fit first: they are against damage, and would stop nearly
// every input at once.
#include <algorithm>
#include <cstddef>

#include "fuzz/reader_fuzz.h"
#include "noiseloom/files/generations.h"
#include "noiseloom/files/run_file.h"
#include "support/run_file_digests.h"

namespace noiseloom::fuzz::run_file {

namespace {

void try_file(const std::string& bytes) {
  const std::string path = folder().write("run.h5", bytes);
  for (const Changed changed : {Changed::refused, Changed::accepted}) {
    expect_reason([&] {
      const RunFileReader reader(path, changed);
      const RunFileContent& content = reader.content();
      std::vector<std::byte> slice;
      for (std::size_t dataset = 0; dataset < content.datasets.size(); ++dataset) {
        slice.resize(bytes_per_slice(content.datasets[dataset], content.extents));
        for (const SliceIndex index : first_indices<SliceIndex>(std::min(content.extents.num_slices(), 100))) {
          reader.read_slice(static_cast<int>(dataset), index, slice);
        }
      }
    });
  }
  looks_like_run_file(path);
}

}  // namespace

void try_input(const std::uint8_t* data, std::size_t size) {
  const std::string bytes = text_of(data, size);
  try_file(with_fitting_digests(bytes));
  if (size % 8 == 0) try_file(bytes);
}

namespace {

std::string seed(const Extents& extents, const std::vector<SliceDataset>& datasets) {
  RunFileContent content;
  content.extents = extents;
  content.config = "[texture]\nsize = { x = 3, y = 2 }\n";
  content.datasets = datasets;
  content.state = {{"sweep", std::int64_t{1}}, {"temperature", 0.5}, {"finished", std::string("iterations")}};
  content.history = {{"sweep", {1, 2}}, {"seconds", {0.5, 1.5}}};
  content.provenance = {{"version", std::string("0.1.0")}};
  const std::string path = folder().path() + "/seed.h5";
  RunFileWriter writer(posix_file_ops(), path, content);
  for (std::size_t dataset = 0; dataset < datasets.size(); ++dataset) {
    const std::vector<std::byte> bytes(bytes_per_slice(datasets[dataset], extents));
    for (const SliceIndex slice : extents.slices()) {
      writer.write_slice(static_cast<int>(dataset), slice, bytes);
    }
  }
  writer.publish();
  return bytes_of(path);
}

}  // namespace

std::vector<std::string> seeds() {
  const SliceDataset samples{"/samples", ElementType::float32, 2, true};
  return {seed(Extents({3, 2, 2}), {samples, {"/state/permutation", ElementType::uint32, 1, false}}),
          seed(Extents({3, 2, 2, 2}), {samples, {"/order", ElementType::uint64, 1, false}}),
          seed(Extents({1, 1}), {samples, {"/pdf", ElementType::float32, 1, false}})};
}

}  // namespace noiseloom::fuzz::run_file
