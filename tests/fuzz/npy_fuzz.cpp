// .npy files that are anything: the first byte chooses the config, the second how the axes are named, the rest is the
// file.
#include "noiseloom/files/npy.h"

#include "fuzz/fuzz_configs.h"
#include "fuzz/reader_fuzz.h"
#include "noiseloom/image/texture_file.h"

namespace noiseloom::fuzz::npy {

void try_input(const std::uint8_t* data, std::size_t size) {
  if (size < 2) return;
  const std::string path = folder().write("a.npy", text_of(data + 2, size - 2));
  const char* const axes[] = {"", "", "tyx", "yxc", "y,x,time"};
  TextureReading reading;
  reading.axes = axes[data[1] % 5];
  expect_reason([&] { read_npy(path); });
  expect_reason([&] { suggested_extents(path, data[0] % 4, reading); });
  expect_reason([&] { load_texture(path, config_number(data[0]), reading); });
}

namespace {

std::string seed(int config, const std::string& type, const std::string& order, const std::string& shape,
                 std::size_t bytes) {
  std::string dict = "{'descr': '" + type + "', 'fortran_order': " + order + ", 'shape': " + shape + ", }\n";
  std::string file("\x93NUMPY\x01\x00", 8);
  file += static_cast<char>(dict.size());
  file += '\0';
  file += dict;
  for (std::size_t i = 0; i < bytes; ++i) file += static_cast<char>(i * 7 % 64);
  return std::string(1, static_cast<char>(config)) + '\0' + file;
}

}  // namespace

std::vector<std::string> seeds() {
  return {seed(0, "<f4", "False", "(3, 4)", 48),         seed(1, ">f2", "True", "(2, 3, 4, 2)", 96),
          seed(2, "<f8", "False", "(4, 4, 4, 3)", 1536), seed(3, "|u1", "False", "(2, 3, 4)", 24),
          seed(4, "<i8", "True", "(3, 4)", 96),          seed(0, "<u2", "False", "(1, 3, 4, 1)", 24)};
}

}  // namespace noiseloom::fuzz::npy
