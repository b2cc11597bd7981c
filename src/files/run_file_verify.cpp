// Reading the user block and checking a file against it, before anything else looks at the file.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <functional>
#include <numeric>
#include <optional>
#include <sstream>
#include <string_view>

#include "files/run_file_block.h"
#include "noiseloom/core/error.h"
#include "noiseloom/files/digest.h"
#include "noiseloom/files/run_file.h"

namespace noiseloom {
namespace {

static_assert(std::endian::native == std::endian::little, "checksums are read from the file as they lie there");

constexpr std::string_view first_line = "noiseloom run file\n";
constexpr std::uint64_t head_bytes = 512;  // the three fixed lines lie in here
constexpr std::uint64_t smallest_block = 4096;
constexpr std::uint64_t largest_block = std::uint64_t{1} << 20;
constexpr const char* advice = "take an earlier copy of it or make it again";

std::string read_text(FileOps& ops, int fd, std::uint64_t bytes) {
  std::string text(bytes, '\0');
  ops.read(fd, 0, std::as_writable_bytes(std::span(text)));
  return text;
}

template <class Number>
std::optional<Number> parse_number(std::string_view text, int base = 10) {
  Number value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value, base);
  if (error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return value;
}

// The number on the line "<word> <number>".
std::optional<std::uint64_t> number_after(std::string_view text, std::string_view word) {
  const std::string start = fmt::format("\n{} ", word);
  const std::size_t found = text.find(start);
  if (found == std::string_view::npos) return std::nullopt;
  const std::size_t begin = found + start.size();
  return parse_number<std::uint64_t>(text.substr(begin, text.find('\n', begin) - begin));
}

// What a file that is no run file seems to be.
std::string kind_of(std::string_view head) {
  using namespace std::string_view_literals;
  constexpr std::array<std::pair<std::string_view, const char*>, 5> signatures{{
      {"\x89PNG\r\n\x1a\n"sv, "a PNG image"},
      {"\x89HDF\r\n\x1a\n"sv, "an HDF5 file of another program"},
      {"\x76\x2f\x31\x01"sv, "an OpenEXR image"},
      {"\x93NUMPY"sv, "a NumPy array"},
      {"[texture]"sv, "a config"},
  }};
  for (const auto& [signature, name] : signatures) {
    if (head.starts_with(signature)) return std::string(name) + ", not a noiseloom run file";
  }
  return "not a noiseloom run file (it does not begin like one)";
}

[[noreturn]] void throw_damaged(const std::string& path, const std::string& text) {
  throw DamagedRunFile(path, fmt::format("{}; {}", text, advice));
}

// The first line, with at least half of its bytes.
bool has_first_line(std::string_view head) {
  const std::string_view expected = first_line.substr(0, head.size());
  const auto alike =
      std::inner_product(expected.begin(), expected.end(), head.begin(), std::size_t{0}, std::plus{}, std::equal_to{});
  return !head.empty() && 2 * alike >= expected.size();
}

// HDF5 behind a block of one of the sizes that run files have; other programs have smaller blocks, or none.
bool has_hdf5_behind_block(FileOps& ops, int fd, std::uint64_t size) {
  constexpr std::string_view signature = "\x89HDF\r\n\x1a\n";
  for (std::uint64_t at = smallest_block; at <= largest_block && at + signature.size() <= size; at *= 2) {
    std::string found(signature.size(), '\0');
    ops.read(fd, at, std::as_writable_bytes(std::span(found)));
    if (found == signature) return true;
  }
  return false;
}

Beginning beginning_of(FileOps& ops, int fd, std::string_view head, std::uint64_t size) {
  if (has_first_line(head) || has_hdf5_behind_block(ops, fd, size)) return Beginning::run_file;
  return std::ranges::all_of(head, [](char byte) { return byte == '\0'; }) ? Beginning::lost : Beginning::other;
}

// Throws unless the file begins like a run file, as far as it goes. One that nearly does is a damaged one.
void check_first_line(FileOps& ops, int fd, const std::string& path, std::string_view head, std::uint64_t size) {
  if (head.starts_with(first_line.substr(0, head.size()))) return;
  switch (beginning_of(ops, fd, head, size)) {
    case Beginning::run_file:
      throw_damaged(path, fmt::format("damaged: bytes 0..{}, its first line, are not what was written",
                                      std::min(head.size(), first_line.size())));
    case Beginning::lost:
      throw_damaged(path, fmt::format("damaged, if it ever was a run file: bytes 0..{} are zeros", head.size()));
    case Beginning::other:
      throw UserError(path, kind_of(head));
  }
}

std::string read_block_text(FileOps& ops, int fd, const std::string& path) {
  const std::uint64_t size = ops.size(fd);
  if (size == 0) throw_damaged(path, "empty (0 bytes)");
  const std::string head = read_text(ops, fd, std::min(size, head_bytes));
  check_first_line(ops, fd, path, head, size);
  if (size < head_bytes) throw_damaged(path, fmt::format("truncated: only {} bytes are left", size));
  const std::uint64_t bytes = number_after(head, "block").value_or(0);
  if (!std::has_single_bit(bytes) || bytes < head_bytes || bytes > largest_block) {
    throw_damaged(path, fmt::format("damaged: bytes 0..{}, in the text block, are not what was written", head_bytes));
  }
  if (size < bytes) {
    throw_damaged(path, fmt::format("truncated: {} bytes are left, not even the text block of {}", size, bytes));
  }
  std::string text = read_text(ops, fd, bytes);
  if (!text.ends_with(block_last_line(std::string_view(text).substr(0, bytes - block_last_line_bytes)))) {
    throw_damaged(path, fmt::format("damaged: bytes 0..{}, the text block, are not what was written", bytes));
  }
  return text;
}

// Slices and the ranges outside of them lie in the file side by side and without a gap. The lists of digests lie
// somewhere in those ranges.
bool is_possible(const RunFileBlock& block) {
  const auto fits = [&](std::uint64_t begin, std::uint64_t count, std::uint64_t size) {
    return begin >= block.block_bytes && begin <= block.length && size > 0 && count <= (block.length - begin) / size;
  };
  std::vector<std::pair<std::uint64_t, std::uint64_t>> ranges;
  for (const SlicePlace& place : block.slices) {
    if (!place.name.starts_with('/') || !fits(place.offset, place.num_slices, place.slice_bytes) ||
        !fits(place.checksums, place.num_slices, sizeof(std::uint64_t))) {
      return false;
    }
    ranges.emplace_back(place.offset, place.end());
  }
  for (const OutsideRange& place : block.outside_slices) ranges.emplace_back(place.begin, place.end);
  std::ranges::sort(ranges);
  std::uint64_t covered = block.block_bytes;
  for (const auto& [begin, end] : ranges) {
    if (begin != covered || end < begin) return false;
    covered = end;
  }
  return covered == block.length;
}

RunFileBlock parse_block(const std::string& text, const std::string& path) {
  RunFileBlock block;
  block.block_bytes = text.size();
  block.length = number_after(text, "length").value_or(0);
  bool good = block.length >= block.block_bytes;
  std::istringstream lines(text);
  for (std::string line; good && std::getline(lines, line);) {
    std::istringstream words(line);
    std::string kind;
    words >> kind;
    if (kind == "slices") {
      SlicePlace place;
      words >> place.offset >> place.num_slices >> place.slice_bytes >> place.checksums >> place.name;
      block.slices.push_back(place);
      good = !words.fail();
    } else if (kind == "rest") {
      OutsideRange place;
      std::string digest;
      words >> place.begin >> place.end >> digest;
      const auto value = parse_number<std::uint64_t>(digest, 16);
      place.digest = value.value_or(0);
      block.outside_slices.push_back(place);
      good = !words.fail() && value.has_value();
    }
  }
  if (!good || !is_possible(block))
    throw UserError(path, "its text block is sound but cannot be understood: not written by noiseloom");
  return block;
}

// Where a byte lies, for people.
std::string place_of(const RunFileBlock& block, std::uint64_t byte) {
  for (const SlicePlace& place : block.slices) {
    if (byte >= place.offset && byte < place.end()) {
      return fmt::format("inside {}, slice {} of {}", place.name, (byte - place.offset) / place.slice_bytes,
                         place.num_slices);
    }
  }
  return byte < block.block_bytes ? "inside the text block" : "inside the structure, config, history or checksums";
}

void check_length(const RunFileBlock& block, std::uint64_t size, const std::string& path) {
  if (size < block.length) {
    throw ResizedRunFile(path, fmt::format("truncated: {} of {} bytes are left; it ends {}; {}", size, block.length,
                                           place_of(block, size), advice));
  }
}

// Ranges of bytes that are not what was written.
class DamageList {
 public:
  DamageList(const RunFileBlock& block, std::string path) : block_(block), path_(std::move(path)) {}

  void add(std::uint64_t begin, std::uint64_t end) {
    if (!ranges_.empty() && ranges_.back().second == begin) {
      ranges_.back().second = end;
    } else {
      ranges_.emplace_back(begin, end);
    }
  }

  bool touches(std::uint64_t begin, std::uint64_t end) const {
    return std::ranges::any_of(ranges_, [&](const auto& range) { return range.first < end && begin < range.second; });
  }

  std::vector<Fault> faults() const {
    constexpr std::size_t most_lines = 10;
    std::vector<Fault> faults;
    for (std::size_t i = 0; i < std::min(ranges_.size(), most_lines); ++i) {
      const auto [begin, end] = ranges_[i];
      std::string place = place_of(block_, begin);
      if (const std::string last = place_of(block_, end - 1); last != place) place += " to " + last;
      faults.push_back({path_, fmt::format("damaged: bytes {}..{}, {}, are not what was written", begin, end, place)});
    }
    if (ranges_.size() > most_lines) {
      faults.push_back({path_, fmt::format("and {} more damaged ranges", ranges_.size() - most_lines)});
    }
    return faults;
  }

 private:
  const RunFileBlock& block_;
  std::string path_;
  std::vector<std::pair<std::uint64_t, std::uint64_t>> ranges_;
};

void check_slices(FileOps& ops, int fd, const SlicePlace& place, DamageList& damage) {
  std::vector<std::uint64_t> digests(place.num_slices);
  ops.read(fd, place.checksums, std::as_writable_bytes(std::span(digests)));
  for (std::uint64_t slice = 0; slice < place.num_slices; ++slice) {
    const std::uint64_t begin = place.offset + slice * place.slice_bytes;
    const std::uint64_t end = begin + place.slice_bytes;
    if (digest_of_range(ops, fd, begin, end) != digests[slice]) damage.add(begin, end);
  }
}

}  // namespace

Beginning beginning_of(FileOps& ops, int fd) {
  const std::uint64_t size = ops.size(fd);
  return beginning_of(ops, fd, read_text(ops, fd, std::min(size, head_bytes)), size);
}

RunFileBlock verify_run_file(FileOps& ops, int fd, const std::string& path) {
  const std::string text = read_block_text(ops, fd, path);
  const std::uint64_t format = number_after(text, "format").value_or(0);
  if (format != run_file_format) {
    throw UserError(path, fmt::format("format {}; this noiseloom knows format {} only, use {} one", format,
                                      run_file_format, format > run_file_format ? "a newer" : "an older"));
  }
  const RunFileBlock block = parse_block(text, path);
  check_length(block, ops.size(fd), path);
  DamageList damage(block, path);
  for (const OutsideRange& place : block.outside_slices) {
    if (digest_of_range(ops, fd, place.begin, place.end) != place.digest) damage.add(place.begin, place.end);
  }
  for (const SlicePlace& place : block.slices) {
    // Checksums that are damaged themselves say nothing about the slices.
    if (!damage.touches(place.checksums, place.checksums + 8 * place.num_slices)) check_slices(ops, fd, place, damage);
  }
  std::vector<Fault> faults = damage.faults();
  const std::uint64_t size = ops.size(fd);
  const bool changed_and_longer = size > block.length && !faults.empty();
  if (size > block.length) {
    faults.push_back({path, fmt::format("damaged: bytes {}..{} follow after its end", block.length, size)});
  }
  if (faults.empty()) return block;
  faults.back().text += fmt::format("; {}", advice);
  if (changed_and_longer) throw ResizedRunFile(faults);
  throw DamagedRunFile(faults);
}

}  // namespace noiseloom
