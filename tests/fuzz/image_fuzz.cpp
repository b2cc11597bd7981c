// Image files that are anything: the first byte chooses the config, the second the layout, the rest is the file.
#include "fuzz/fuzz_configs.h"
#include "fuzz/reader_fuzz.h"
#include "noiseloom/image/image_io.h"
#include "noiseloom/image/texture_file.h"

namespace noiseloom::fuzz::image {

void try_input(const std::uint8_t* data, std::size_t size) {
  if (size < 2) return;
  const char* const layouts[] = {"", "strip", "row", "atlas:2x1", "image"};
  TextureReading reading;
  reading.layout = layouts[data[1] % 5];
  const std::string path = folder().write(data[1] >= 128 ? "a.tga" : "a.png", text_of(data + 2, size - 2));
  expect_reason([&] { load_texture(path, config_number(data[0]), reading); });
}

namespace {

std::string seed(int config, const std::string& name, ImageFormat format, PixelType type, int channels, int blocks) {
  ImageJob job;
  job.format = format;
  job.block = {4, 3, channels, type, {}, -1};
  job.num_blocks = blocks;
  job.stacking = blocks > 1 && format == ImageFormat::exr ? Stacking::parts : Stacking::down;
  for (int b = 0; b < blocks; ++b) job.part_names.push_back(std::to_string(b));
  std::vector<std::byte> bytes(job.block.num_bytes());
  for (std::size_t i = 0; i < bytes.size(); ++i) bytes[i] = std::byte(static_cast<unsigned char>(i * 5 % 61));
  const std::string path = folder().path() + "/" + name;
  write_image(path, job, [&](int) { return std::span<const std::byte>(bytes); });
  const std::string file = bytes_of(path);
  std::filesystem::remove(path);
  return std::string{static_cast<char>(config), '\0'} + file;
}

std::string text_seed(int config, unsigned char layout, const std::string& text) {
  return std::string{static_cast<char>(config), static_cast<char>(layout)} + text;
}

}  // namespace

std::vector<std::string> seeds() {
  return {
      seed(0, "s.png", ImageFormat::png, PixelType::uint8, 1, 1),
      seed(1, "s.png", ImageFormat::png, PixelType::uint16, 3, 2),
      seed(3, "s.tif", ImageFormat::tiff, PixelType::uint8, 1, 2),
      seed(4, "s.tif", ImageFormat::tiff, PixelType::float32, 2, 1),
      seed(1, "s.exr", ImageFormat::exr, PixelType::float32, 2, 2),
      seed(0, "s.exr", ImageFormat::exr, PixelType::float32, 1, 1),
      seed(4, "s.hdr", ImageFormat::hdr, PixelType::float32, 3, 1),
      text_seed(0, 0,
                std::string("\x89PNG\r\n\x1a\n\0\0\0\rIHDR\0\0\0\4\0\0\0\3\10\0\0\0\0\0\0\0\0\x56wei", 37) + "tEXtno"),
      text_seed(0, 0, "P5 4 3 255\n" + std::string(12, 'x')),
      text_seed(0, 0, "P2\n# two\n4 3\n9\n1 2 3 4 5 6 7 8 9 1 2 3\n"),
      text_seed(0, 128, std::string("\0\0\3\0\0\0\0\0\0\0\0\0\4\0\3\0\10\0", 18) + std::string(12, 'x')),
      text_seed(0, 0,
                "BM" + std::string("\x42\0\0\0\0\0\0\0\x36\0\0\0\x28\0\0\0\4\0\0\0\3\0\0\0\1\0\x18\0", 28) +
                    std::string(24 + 36, '\1'))};
}

}  // namespace noiseloom::fuzz::image
