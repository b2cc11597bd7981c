// HDF5 files of others that are anything: the first byte chooses the config, the rest is the file.
#include "noiseloom/files/hdf5_array.h"

#include "fuzz/fuzz_configs.h"
#include "fuzz/reader_fuzz.h"
#include "noiseloom/files/run_file.h"
#include "noiseloom/image/texture_file.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace noiseloom;
  if (size < 1) return 0;
  const std::string path = fuzz::folder().write("a.h5", fuzz::text_of(data + 1, size - 1));
  for (const std::string& name : {path, path + ":/samples"})
    fuzz::expect_reason([&] { load_texture(name, fuzz::config_number(data[0]), {}); });
  return 0;
}

namespace {

// A run file is HDF5 behind a user block; without its mark it is anybody's.
std::string seed(int config, const noiseloom::Extents& extents, int channels) {
  using namespace noiseloom;
  RunFileContent content;
  content.extents = extents;
  content.config = "[texture]\n";
  content.datasets = {{"/samples", ElementType::float32, channels, true}};
  const std::string path = fuzz::folder().path() + "/seed.h5";
  {
    RunFileWriter writer(posix_file_ops(), path, content);
    std::vector<std::byte> slice(bytes_per_slice(content.datasets[0], extents));
    for (const SliceIndex s : extents.slices()) writer.write_slice(0, s, slice);
    writer.publish();
  }
  std::string file = fuzz::bytes_of(path);
  std::filesystem::remove(path);
  file[0] = 'x';
  return static_cast<char>(config) + file;
}

}  // namespace

std::vector<std::string> noiseloom::fuzz::seeds() {
  return {seed(0, Extents({4, 3}), 1), seed(1, Extents({4, 3, 2}), 2)};
}
