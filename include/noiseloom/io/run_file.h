// The run file: an HDF5 file that holds a texture, the config that made it, its history and the state to go on from.
//
//   /samples     float32 [slice axes..., y, x, channel]     /pdf     float32 [slice axes..., y, x], where density
//   varies /order       uint32 or uint64 [slice axes..., y, x]     (void and cluster) /config      text
//   /history/<column>  float64 [rows]     /state   attributes, and datasets per slice /checksum/<dataset>  uint64
//   [slices]: XXH64 of each slice's bytes       /provenance   attributes; may differ between equal runs
//
// All data contiguous. A user block before the HDF5 signature (a multiple of 512 bytes) holds text: "noiseloom run
// file", format version, length of the file, where each dataset's bytes lie, and digests of the rest, so that damage is
// found and named before HDF5 parses a byte. One writer, the serial HDF5 driver, all bytes through FileOps (a virtual
// file driver). Published whole or not at all: unique temporary name, close, digest, fsync, rename the old generation
// to PATH.prev, rename, fsync of the directory.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "noiseloom/core/extents.h"
#include "noiseloom/io/file_ops.h"

namespace noiseloom {

enum class ElementType { float32, uint32, uint64 };

// A dataset with one block of cells per slice: [slice axes..., y, x] and, with `channel_axis`, [..., channel].
struct SliceDataset {
  std::string name;  // "/samples", "/state/permutation"
  ElementType type = ElementType::float32;
  int channels = 1;
  bool channel_axis = false;
};

using Attribute = std::variant<std::int64_t, double, std::string>;

struct RunFileContent {
  Extents extents;
  std::string config;  // effective, TOML
  std::vector<SliceDataset> datasets;
  std::map<std::string, Attribute> state;  // /state attributes
  std::vector<std::pair<std::string, std::vector<double>>>
      history;  // columns of equal length; "seconds" is stored under
                // /provenance and linked from /history, as it may differ
  std::map<std::string, Attribute> provenance;
};

class RunFileWriter {
 public:
  // Creates the temporary file beside `path`. Throws EnvironmentError.
  RunFileWriter(FileOps& ops, std::string path, const RunFileContent& content);
  ~RunFileWriter();  // removes the temporary file unless published
  // The bytes of one slice of one dataset (file layout). Each slice of each dataset exactly once, in any order.
  void write_slice(int dataset, SliceIndex slice, std::span<const std::byte> bytes);
  // Closes, digests, syncs, keeps the old generation as PATH.prev, renames, syncs the directory.
  void publish();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

class RunFileReader {
 public:
  // Verifies digests first. Throws UserError when the file is missing, not a run file, of a newer format, truncated or
  // damaged (saying what and where); EnvironmentError when it cannot be read.
  explicit RunFileReader(const std::string& path);
  ~RunFileReader();
  RunFileReader(RunFileReader&&) noexcept;
  const RunFileContent& content() const;
  // Index into content().datasets, or -1.
  int dataset(const std::string& name) const;
  void read_slice(int dataset, SliceIndex slice, std::span<std::byte> bytes) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

// True where the file begins like a run file (cheap; no verification).
bool looks_like_run_file(const std::string& path);

// Holds an output for one run: PATH.lock, locked for the life of the object and freed by the system if the process
// dies.
class RunLock {
 public:
  // Throws UserError saying who holds it (host, process, since when), EnvironmentError if the folder cannot be written.
  explicit RunLock(const std::string& path);
  ~RunLock();
  RunLock(const RunLock&) = delete;
  RunLock& operator=(const RunLock&) = delete;

 private:
  int fd_ = -1;
  std::string lock_path_;
};

// Removes temporary files that killed runs left beside `path`. Call with the lock held.
void remove_stale_temporaries(FileOps& ops, const std::string& path);

}  // namespace noiseloom
