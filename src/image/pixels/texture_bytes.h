// Little-endian numbers in the headers of KTX2 and DDS files, which are whole numbers of 32 and 64 bits.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <span>
#include <string>

namespace noiseloom {

// The bytes from `offset` on, as many as there are; what is past the end of the file reads as zero.
template <std::size_t N>
std::array<char, N> header_bytes(std::ifstream& file, std::int64_t offset) {
  std::array<char, N> bytes{};
  file.clear();
  file.seekg(offset);
  file.read(bytes.data(), N);
  return bytes;
}

template <class Number>
Number little_endian(std::span<const char> bytes, std::size_t at) {
  Number number = 0;
  for (std::size_t i = sizeof(Number); i-- > 0;)
    number = static_cast<Number>(number << 8 | static_cast<unsigned char>(bytes[at + i]));
  return number;
}
inline std::uint32_t u32_at(std::span<const char> bytes, std::size_t at) {
  return little_endian<std::uint32_t>(bytes, at);
}
inline std::uint64_t u64_at(std::span<const char> bytes, std::size_t at) {
  return little_endian<std::uint64_t>(bytes, at);
}

inline void append_u32(std::string& bytes, std::uint64_t number) {
  for (int i = 0; i < 4; ++i) bytes += static_cast<char>(number >> (8 * i) & 255);
}
inline void append_u64(std::string& bytes, std::uint64_t number) {
  append_u32(bytes, number & 0xFFFFFFFF);
  append_u32(bytes, number >> 32);
}
inline void append_u16(std::string& bytes, std::uint32_t number) {
  bytes += static_cast<char>(number & 255);
  bytes += static_cast<char>(number >> 8 & 255);
}
inline void pad_to(std::string& bytes, std::size_t multiple) {
  while (bytes.size() % multiple != 0) bytes += '\0';
}

// Sizes of a header as those of a slice; false where they are none that are read.
inline bool fits_a_slice(std::uint32_t width, std::uint32_t height) {
  constexpr std::uint32_t most = 1U << 24;
  return width >= 1 && width <= most && height >= 1 && height <= most;
}

}  // namespace noiseloom
