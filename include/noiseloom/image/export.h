// Run files to images and arrays.
//
// Everything is checked before the first byte is written, files appear whole or not at all (output_files.h), and what
// is stored is described in encoding.h.
//
// With a threshold: the point set of the earliest pixels (pixel_order.h) as black and white images, and as a table of
// coordinates in the order of the sequence.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "noiseloom/files/file_ops.h"
#include "noiseloom/files/run_file.h"
#include "noiseloom/image/image_io.h"
#include "noiseloom/image/naming.h"

namespace noiseloom {

// As written on the command line; empty means "not given".
struct ExportOptions {
  std::string output;     // a file, a pattern of files or a folder
  std::string format;     // png, exr, tiff, hdr, npy, raw; from the extension of `output`, else png
  std::string layout;     // slices, strip, exr-multipart
  std::string depth;      // 8, 16, 32f
  std::string naming;     // plain, nvidia, ea, a pattern
  std::string slices;     // "a:b": a, a + 1, ..., b - 1
  std::string range;      // "lo:hi"
  std::string threshold;  // a fraction of all pixels: the points that come first, instead of the values
  bool with_density = false;
  bool overwrite = false;
};

enum class ExportLayout { slices, strip, parts, array };

struct ExportPlan {
  std::string format;                // the name, as in the options
  std::optional<ImageFormat> image;  // none: npy, raw
  ExportLayout layout = ExportLayout::slices;
  PixelType type = PixelType::uint8;
  SliceIndex begin = 0;
  SliceIndex end = 0;
  // Stored numbers are to_unit(range, value); none: the values themselves.
  std::optional<ValueRange> range;
  PixelLayout pixel;
  bool with_density = false;
  std::vector<std::string> targets;  // one file a slice, or one file
  // With a threshold: how many pixels of the whole texture are points, and where their coordinates go.
  std::optional<std::int64_t> num_points;
  std::string points_csv;
  std::string points_npy;  // with format npy alone
};

// What is to be written where. `name` is the run file's path. Throws UserError with every fault.
ExportPlan plan_export(const std::string& name, const RunFileContent& content, const ProblemSpec& problem,
                       const ExportOptions& options);

struct ExportResult {
  std::vector<std::string> files;   // images or arrays
  std::vector<std::string> tables;  // with a threshold: the coordinates,
  std::string points;               // and how many points there are, in words
};

// Throws UserError (nothing was written) or EnvironmentError (nothing is left behind).
ExportResult export_run_file(const std::string& path, const ExportOptions& options, FileOps& ops);

}  // namespace noiseloom
