// Makes the digests of a run file fit whatever its bytes are now, so that a test gets past them.
#pragma once

#include <algorithm>
#include <cstring>
#include <sstream>
#include <string>

#include "noiseloom/files/digest.h"

namespace noiseloom {

// Recomputes, as far as the text block can be read: the digest of each slice, of the rest, and of the block itself.
// Everything else stays as it is.
inline std::string with_fitting_digests(std::string file) {
  const auto digest = [&](std::size_t begin, std::size_t end) {
    return digest_of(std::as_bytes(std::span(file).subspan(begin, end - begin)));
  };
  std::size_t block_bytes = 4096;
  if (const std::size_t at = file.substr(0, 512).find("\nblock "); at != std::string::npos) {
    block_bytes = static_cast<std::size_t>(std::strtoull(file.c_str() + at + 7, nullptr, 10));
  }
  constexpr std::size_t last_line = 24;  // "digest ...\n"
  if (block_bytes < 512 || block_bytes > file.size()) return file;
  std::size_t begin = 0;
  const auto each_line = [&](auto use) {
    for (begin = 0; begin < block_bytes - last_line;) {
      const std::size_t end = std::min(file.find('\n', begin), block_bytes - last_line);
      std::istringstream words(file.substr(begin, end - begin));
      std::string kind;
      words >> kind;
      use(kind, words, end);
      begin = end + 1;
    }
  };
  each_line([&](const std::string& kind, std::istringstream& words, std::size_t) {
    std::size_t offset = 0, count = 0, bytes = 0, checksums = 0;
    if (kind != "slices" || !(words >> offset >> count >> bytes >> checksums)) return;
    for (std::size_t slice = 0; slice < std::min<std::size_t>(count, 4096); ++slice) {
      if (bytes > file.size() || offset > file.size() - bytes || checksums > file.size() - 8) return;
      const std::uint64_t value = digest(offset, offset + bytes);
      std::memcpy(file.data() + checksums, &value, 8);
      offset += bytes;
      checksums += 8;
    }
  });
  each_line([&](const std::string& kind, std::istringstream& words, std::size_t end) {
    std::size_t from = 0, to = 0;
    if (kind != "rest" || !(words >> from >> to) || from > to || to > file.size() || end < begin + 16) return;
    file.replace(end - 16, 16, to_hex(digest(from, to)));
  });
  file.replace(block_bytes - last_line, last_line, "digest " + to_hex(digest(0, block_bytes - last_line)) + "\n");
  return file;
}

}  // namespace noiseloom
