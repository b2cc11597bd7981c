// The run file: an HDF5 file that holds a texture, the config that made it, its history and the state to go on from.
//
//   /                     attributes format, axes ("x y t"), extents (int64, in that order)
//   /samples              float32 [slice axes..., y, x, channel]
//   /pdf                  float32 [slice axes..., y, x], where the density varies
//   /order                uint32 or uint64 [slice axes..., y, x] (void and cluster)
//   /config               text
//   /inputs/<key>         float32 or float64, with attribute file: what the file that the config names under <key>
//                         ("texture.samples.file", "filter.groups[1].file") held when the run began, in that file's
//                         shape; samples rounded to float32. There is no such group where the config names no file.
//   /history/<column>     float64 [rows]
//   /state                attributes, and datasets per slice
//   /checksum/<dataset>   uint64 [slices]: XXH64 of each slice's bytes; /checksum's attribute <dataset> is the XXH64 of
//                         that list, as 16 hexadecimal digits
//   /provenance           attributes, and seconds (linked from /history); may differ between equal runs
//
// All data contiguous and little-endian. The same content gives the same bytes except /provenance and what counts or
// digests its bytes.
//
// A user block before the HDF5 signature holds text: "noiseloom run file", format, length of the file, where each
// dataset's bytes lie, digests of everything that no slice checksum covers, and a digest of the block itself. Damage is
// so found and named before HDF5 parses a byte. Its lines are described in src/files/run_file_block.h.
//
// One writer, the serial HDF5 driver, all bytes through FileOps (a virtual file driver). Published whole or not at all
// (files/generations.h).
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "noiseloom/core/error.h"
#include "noiseloom/core/extents.h"
#include "noiseloom/files/file_ops.h"
#include "noiseloom/files/input_array.h"

namespace noiseloom {

enum class ElementType { float32, uint32, uint64 };

std::size_t bytes_per_element(ElementType type);

// A dataset with one block of cells per slice: [slice axes..., y, x] and, with `channel_axis`, [..., channel].
struct SliceDataset {
  std::string name;  // "/samples", "/state/permutation"
  ElementType type = ElementType::float32;
  int channels = 1;  // more than 1 only with channel_axis
  bool channel_axis = false;

  friend bool operator==(const SliceDataset&, const SliceDataset&) = default;
};

std::size_t bytes_per_slice(const SliceDataset& dataset, const Extents& extents);

using Attribute = std::variant<std::int64_t, double, std::string>;  // text without trailing zero bytes

struct RunFileInput {
  std::string key;   // of the config
  std::string file;  // as the config spells it
  InputArrayPtr array;
};

struct RunFileContent {
  Extents extents;
  std::string config;  // effective, TOML
  std::vector<SliceDataset> datasets;
  std::vector<RunFileInput> inputs;
  std::map<std::string, Attribute> state;  // /state attributes
  std::vector<std::pair<std::string, std::vector<double>>>
      history;  // columns of equal length; "seconds" is stored under
                // /provenance and linked from /history, as it may differ
  std::map<std::string, Attribute> provenance;
  // Dataset name to its combined checksum (16 hexadecimal digits). Filled by the reader, ignored by the writer.
  std::map<std::string, std::string> checksums;
};

class RunFileWriter {
 public:
  // Creates the temporary file beside `path`, or beside its target if that is a symbolic link. Throws EnvironmentError.
  RunFileWriter(FileOps& ops, const std::string& path, const RunFileContent& content);
  ~RunFileWriter();  // removes the temporary file unless published
  // The bytes of one slice of one dataset (file layout). Each slice of each dataset exactly once, in any order.
  void write_slice(int dataset, SliceIndex slice, std::span<const std::byte> bytes);
  // Closes, digests and syncs: the temporary file is then all that publish() will give its name to.
  void complete();
  // complete() unless that was done, and puts the file in the place of the newest generation. Where it throws, the
  // generation that was at PATH is still there (or, if only the last sync failed, the new one). Throws OutputLost where
  // this process has a RunLock on `path` and the output is no longer its own.
  void publish();
  // The combined checksum of a dataset, 16 hexadecimal digits. Requires that all its slices have been written.
  std::string checksum(int dataset) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

// A run file that was good once and is no more: empty, truncated or with changed bytes. The previous generation may
// help.
class DamagedRunFile : public UserError {
  using UserError::UserError;
};

// Another program has written to the file since: h5repack, h5py, an editor of attributes. It can be read, but nothing
// says that a run may go on from it.
class ChangedRunFile : public UserError {
  using UserError::UserError;
};

enum class Changed { refused, accepted };

// What is not checked by its digest is checked for being possible: nothing in a file, damaged or made up, leads to more
// than an exception.
class RunFileReader {
 public:
  // Verifies digests first. Throws DamagedRunFile, saying what and where; ChangedRunFile, unless that is accepted;
  // UserError when the file is missing, not a run file or of a newer format; EnvironmentError when it cannot be read.
  //
  // With Changed::accepted the digests of the block need not fit, if HDF5 can read the file and every slice has the
  // digest that /checksum gives it; change() then says what to tell the user.
  explicit RunFileReader(const std::string& path, Changed changed = Changed::refused, FileOps& ops = posix_file_ops());
  ~RunFileReader();
  RunFileReader(RunFileReader&&) noexcept;
  const std::string& path() const;
  const RunFileContent& content() const;
  // "" for a file as it was written, else a sentence about what is no longer certain.
  const std::string& change() const;
  // Index into content().datasets, or -1.
  int dataset(const std::string& name) const;
  void read_slice(int dataset, SliceIndex slice, std::span<std::byte> bytes) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

// True where the file begins like a run file, though perhaps a damaged one, or was one before another program rewrote
// it (cheap; no verification).
bool looks_like_run_file(const std::string& path);
// For a file of which one knows that it should be one: also true where its beginning is gone (empty, zeros) or cannot
// be read.
bool may_be_run_file(const std::string& path);

}  // namespace noiseloom
