// The user block of a run file: text that says what lies where, and the digests that everything is checked against.
//
//   noiseloom run file
//   format 1
//   block 4096
//   length 1234567
//   (a sentence for people)
//   slices OFFSET SLICES BYTES CHECKSUMS /samples     SLICES blocks of BYTES bytes from OFFSET; their XXH64s as uint64
//                                                     from CHECKSUMS
//   rest BEGIN END DIGEST                             XXH64 of the bytes BEGIN..END, which no slice covers
//   (spaces)
//   digest DIGEST                                     XXH64 of all lines before; ends the block
//
// Offsets are bytes from the start of the file, ranges half-open, numbers decimal, digests 16 hexadecimal digits. The
// first three lines and the last have this form in every format, so that an old program can tell a newer format from
// damage.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "noiseloom/files/file_ops.h"
#include "noiseloom/files/run_file.h"

namespace noiseloom {

inline constexpr int run_file_format = 1;

// Where the digests of the slices of a dataset such as "/samples" lie.
inline std::string checksum_path(const std::string& dataset) { return "/checksum" + dataset; }

struct SlicePlace {
  std::string name;
  std::uint64_t offset = 0;
  std::uint64_t num_slices = 0;
  std::uint64_t slice_bytes = 0;
  std::uint64_t checksums = 0;  // where the list of digests lies
  std::uint64_t end() const { return offset + num_slices * slice_bytes; }

  friend bool operator==(const SlicePlace&, const SlicePlace&) = default;
};

// Bytes that no slice covers: headers of HDF5, attributes, small datasets.
struct OutsideRange {
  std::uint64_t begin = 0;
  std::uint64_t end = 0;
  std::uint64_t digest = 0;
};

struct RunFileBlock {
  std::uint64_t block_bytes = 0;
  std::uint64_t length = 0;
  std::vector<SlicePlace> slices;
  std::vector<OutsideRange> outside_slices;
};

// A size that holds the block of any file with datasets of these names: a power of two, as HDF5 asks.
std::uint64_t block_bytes_for(const std::vector<std::string>& dataset_names);

// What the slices leave of [block_bytes, length), without digests.
std::vector<OutsideRange> ranges_outside_slices(const RunFileBlock& block);

// The digest of the bytes [begin, end) of an open file.
std::uint64_t digest_of_range(FileOps& ops, int fd, std::uint64_t begin, std::uint64_t end);

// block_bytes bytes.
std::string to_text(const RunFileBlock& block);

// The last line of a block, of block_last_line_bytes bytes, for all that stands before it.
std::string block_last_line(std::string_view before);
inline constexpr std::size_t block_last_line_bytes = sizeof("digest 0123456789abcdef\n") - 1;

// Of another length than it was written with, and changed inside too: what a program leaves that writes into it with
// HDF5 or packs it anew, if it is not cut off.
class ResizedRunFile : public DamagedRunFile {
  using DamagedRunFile::DamagedRunFile;
};

// Reads the block and checks every byte of the file against it. Throws as RunFileReader does; `path` is for messages.
// What it returns is possible: its places lie in the file, do not overlap, and leave out no byte.
RunFileBlock verify_run_file(FileOps& ops, int fd, const std::string& path);

// What the first bytes of a file say, without verification.
enum class Beginning {
  run_file,  // or nearly: the first line with a few bytes changed, or HDF5 behind a block of which nothing is left
  lost,      // empty, or zeros: what a power cut leaves of any file
  other
};
Beginning beginning_of(FileOps& ops, int fd);

}  // namespace noiseloom
