// What tests of files that can be read in more than one way write and ask.
#pragma once

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <vector>

#include "noiseloom/image/image_io.h"
#include "noiseloom/image/texture_file.h"
#include "support/run_files.h"

namespace noiseloom {

// A number in [0, 1) for each index, as noise has them.
inline double noise(std::size_t i) {
  std::uint64_t z = (static_cast<std::uint64_t>(i) + 1) * 0x9e3779b97f4a7c15ULL;
  z = (z ^ z >> 30) * 0xbf58476d1ce4e5b9ULL;
  z = (z ^ z >> 27) * 0x94d049bb133111ebULL;
  return static_cast<double>((z ^ z >> 31) >> 11) * 0x1p-53;
}

template <class T>
std::string raw(const std::vector<T>& values, bool big_endian = false) {
  std::string bytes(values.size() * sizeof(T), '\0');
  std::memcpy(bytes.data(), values.data(), bytes.size());
  for (std::size_t at = 0; big_endian && at < bytes.size(); at += sizeof(T))
    std::reverse(bytes.begin() + static_cast<std::ptrdiff_t>(at),
                 bytes.begin() + static_cast<std::ptrdiff_t>(at + sizeof(T)));
  return bytes;
}

inline std::vector<float> noise_floats(std::size_t count) {
  std::vector<float> values;
  for (std::size_t i = 0; i < count; ++i) values.push_back(static_cast<float>(noise(i)));
  return values;
}

// An image of 8 bits; code(x, y, channel).
template <class Code>
void write_codes(const std::string& path, int width, int height, int channels, Code code) {
  std::vector<std::byte> bytes;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      for (int c = 0; c < channels; ++c) bytes.push_back(std::byte(static_cast<std::uint8_t>(code(x, y, c))));
  ImageJob job;
  job.block = {width, height, channels, PixelType::uint8, {}, channels == 4 ? 3 : -1};
  write_image(path, job, [&](int) { return std::span<const std::byte>(bytes); });
}

inline std::string error_of(const std::string& path, const RunConfig& config, const TextureReading& reading = {}) {
  return user_error_of([&] { load_texture(path, config, reading); });
}

}  // namespace noiseloom
