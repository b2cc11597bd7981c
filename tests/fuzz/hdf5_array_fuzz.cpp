// HDF5 files of others that are anything: the first byte chooses the config, the rest is the file.
#include "noiseloom/files/hdf5_array.h"

#include "fuzz/fuzz_configs.h"
#include "fuzz/reader_fuzz.h"
#include "noiseloom/files/run_file.h"
#include "noiseloom/image/texture_file.h"

namespace noiseloom::fuzz::hdf5_array {

void try_input(const std::uint8_t* data, std::size_t size) {
  if (size < 1) return;
  const std::string path = folder().write("a.h5", text_of(data + 1, size - 1));
  for (const std::string& name : {path, path + ":/samples"})
    expect_reason([&] { load_texture(name, config_number(data[0]), {}); });
}

namespace {

// A run file is HDF5 behind a user block; without its mark it is anybody's.
std::string seed(int config, const Extents& extents, int channels) {
  RunFileContent content;
  content.extents = extents;
  content.config = "[texture]\n";
  content.datasets = {{"/samples", ElementType::float32, channels, true}};
  const std::string path = folder().path() + "/seed.h5";
  {
    RunFileWriter writer(posix_file_ops(), path, content);
    std::vector<std::byte> slice(bytes_per_slice(content.datasets[0], extents));
    for (const SliceIndex s : extents.slices()) writer.write_slice(0, s, slice);
    writer.publish();
  }
  std::string file = bytes_of(path);
  std::filesystem::remove(path);
  file[0] = 'x';
  return static_cast<char>(config) + file;
}

}  // namespace

std::vector<std::string> seeds() { return {seed(0, Extents({4, 3}), 1), seed(1, Extents({4, 3, 2}), 2)}; }

}  // namespace noiseloom::fuzz::hdf5_array
