// KTX2 and DDS files that are anything: the first byte chooses the config, the second the ending, the rest is the file.
// (Their marks send files of any ending to their readers; image_fuzz.cpp seldom finds these.)
#include <fmt/format.h>

#include "fuzz/fuzz_configs.h"
#include "fuzz/reader_fuzz.h"
#include "noiseloom/image/image_reader.h"
#include "noiseloom/image/texture_file.h"

namespace noiseloom::fuzz::texture {

void try_input(const std::uint8_t* data, std::size_t size) {
  if (size < 2) return;
  const std::string path = folder().write(data[1] % 2 == 0 ? "a.ktx2" : "a.dds", text_of(data + 2, size - 2));
  expect_reason([&] { load_texture(path, config_number(data[0]), {}); });
  expect_reason([&] { load_texture(path, std::nullopt, {}); });
}

namespace {

void append(std::string& bytes, std::initializer_list<std::uint32_t> numbers) {
  for (const std::uint32_t number : numbers)
    for (int i = 0; i < 4; ++i) bytes += static_cast<char>(number >> (8 * i) & 255);
}

std::string pixels(std::size_t size) {
  std::string bytes;
  for (std::size_t i = 0; i < size; ++i) bytes += static_cast<char>(i * 5 % 61);
  return bytes;
}

// 4 x 3 texels; volumes have a depth, arrays layers.
std::string ktx2(int config, std::uint32_t format, std::uint32_t texel, std::uint32_t depth, std::uint32_t layers) {
  const std::uint32_t size = 12 * texel * std::max({depth, layers, 1U});
  const std::string keys("\22\0\0\0KTXorientation\0rd\0\0\0", 24);
  std::string bytes("\xABKTX 20\xBB\r\n\x1A\n", 12);
  append(bytes, {format, 1, 4, 3, depth, layers, 1, 1, 0, 0, 0, 104, 24, 0, 0, 0, 0, 128, 0, size, 0, size, 0});
  return std::string{static_cast<char>(config), '\0'} + bytes + keys + pixels(size);
}

std::string dds(int config, std::uint32_t format, std::uint32_t texel, std::uint32_t layers) {
  std::string bytes = "DDS ";
  append(bytes, {124, 0x100F, 3, 4, 4 * texel, 0, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 32});
  if (format == 0) {
    append(bytes, {0x20001, 0, 16, 0xff, 0, 0, 0xff00, 0x1000, 0, 0, 0, 0});
  } else {
    append(bytes, {4, 0x30315844, 0, 0, 0, 0, 0, 0x1000, 0, 0, 0, 0, format, 3, 0, layers, 0});
  }
  return std::string{static_cast<char>(config), '\1'} + bytes + pixels(12 * texel * layers);
}

}  // namespace

std::vector<std::string> seeds() {
  return {ktx2(0, 9, 1, 0, 0),    ktx2(4, 16, 2, 0, 2), ktx2(4, 83, 4, 2, 0), ktx2(1, 109, 16, 0, 2),
          ktx2(0, 145, 16, 0, 0), dds(0, 61, 1, 1),     dds(4, 34, 4, 2),     dds(4, 0, 2, 1)};
}

}  // namespace noiseloom::fuzz::texture
