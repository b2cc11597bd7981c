#include "files/run_file_block.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <string_view>

#include "noiseloom/core/error.h"
#include "noiseloom/files/digest.h"

namespace noiseloom {
namespace {

constexpr std::size_t read_piece = std::size_t{1} << 20;

}  // namespace

std::uint64_t block_bytes_for(const std::vector<std::string>& dataset_names) {
  constexpr std::uint64_t longest_number = 20;
  std::uint64_t needed = 512;  // the fixed lines
  for (const std::string& name : dataset_names) {
    needed += name.size() + 5 * (longest_number + 1) + 16;  // its line
    needed += 2 * (longest_number + 1) + 32;                // the range before it
  }
  return std::bit_ceil(std::max<std::uint64_t>(needed, 4096));
}

std::vector<OutsideRange> ranges_outside_slices(const RunFileBlock& block) {
  std::vector<SlicePlace> slices = block.slices;
  std::ranges::sort(slices, {}, &SlicePlace::offset);
  std::vector<OutsideRange> ranges;
  std::uint64_t begin = block.block_bytes;
  for (const SlicePlace& place : slices) {
    NOISELOOM_CHECK_LE(begin, place.offset);
    if (begin < place.offset) ranges.push_back({begin, place.offset, 0});
    begin = place.end();
  }
  NOISELOOM_CHECK_LE(begin, block.length);
  if (begin < block.length) ranges.push_back({begin, block.length, 0});
  return ranges;
}

std::uint64_t digest_of_range(FileOps& ops, int fd, std::uint64_t begin, std::uint64_t end) {
  std::vector<std::byte> piece(std::min<std::uint64_t>(read_piece, end - begin));
  Digest digest;
  while (begin < end) {
    const auto bytes = std::span(piece).first(std::min<std::uint64_t>(piece.size(), end - begin));
    ops.read(fd, begin, bytes);
    digest.update(bytes);
    begin += bytes.size();
  }
  return digest.value();
}

std::string to_text(const RunFileBlock& block) {
  std::string text = fmt::format("noiseloom run file\nformat {}\nblock {}\nlength {}\n", run_file_format,
                                 block.block_bytes, block.length);
  text += "HDF5 begins after this block. Open the file with h5py, HDFView, h5dump or: noiseloom info\n";
  for (const SlicePlace& place : block.slices) {
    text += fmt::format("slices {} {} {} {} {}\n", place.offset, place.num_slices, place.slice_bytes, place.checksums,
                        place.name);
  }
  for (const OutsideRange& place : block.outside_slices) {
    text += fmt::format("rest {} {} {}\n", place.begin, place.end, to_hex(place.digest));
  }
  NOISELOOM_CHECK_LT(text.size() + block_last_line_bytes, block.block_bytes);
  text.resize(block.block_bytes - block_last_line_bytes - 1, ' ');
  text += '\n';
  return text + block_last_line(text);
}

std::string block_last_line(std::string_view before) {
  return "digest " + to_hex(digest_of(std::as_bytes(std::span(before)))) + "\n";
}

}  // namespace noiseloom
