// Run files to images and arrays.
//
// Everything is checked before the first byte is written, files appear whole or not at all (output_files.h), and what
// is stored is described in encoding.h. The containers that can be written stand in one table (container.h).
//
// With a threshold: the point set of the earliest pixels (pixel_order.h) as black and white images, and as a table of
// coordinates in the order of the sequence.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "noiseloom/config/config.h"
#include "noiseloom/files/file_ops.h"
#include "noiseloom/files/run_file.h"
#include "noiseloom/image/container.h"
#include "noiseloom/image/texture_read.h"

namespace noiseloom {

// As written on the command line; empty means "not given". What is accepted stands in the table of containers.
struct ExportOptions {
  std::string output;     // a file, a pattern of files or a folder
  std::string format;     // name of a container; from the ending of `output`, else png
  std::string layout;     // slices, strip, row, atlas, atlas:CxR, exr-multipart, array, volume, function
  std::string depth;      // 8, 16, 32, 16f, 32f
  std::string consumer;   // a program that decides most of these (consumers.h)
  std::string channels;   // R, RG, RGB, RGBA: of a pixel, where the container would take others
  std::string naming;     // plain, nvidia, ea, a pattern
  std::string slices;     // "a:b": a, a + 1, ..., b - 1
  std::string range;      // "lo:hi"
  std::string frames;     // N: the frames 0 to N - 1 as a shader reads them (texture_read.h), instead of the slices
  std::string values;     // how many values a pixel reads in a frame; else 1
  std::string read;       // offsets, slices: where the values of a frame are read
  std::string threshold;  // a fraction of all pixels: the points that come first, instead of the values
  std::string density;    // where the density goes: alpha, separate (images beside, of one channel) or none
  bool overwrite = false;
};

// One container that an export writes, and the files of it.
struct ExportOutput {
  const Container* container = nullptr;
  ExportLayout layout = ExportLayout::slices;
  PixelType type = PixelType::uint8;
  PixelLayout pixel;
  int columns = 1;                   // layouts `row` and `atlas`: slices beside each other
  std::vector<std::string> targets;  // layout `slices`: one file a slice, else one file

  // Whether a channel holds the density of the samples.
  bool has_density() const;
  // Says in `job`, whose extents are known, what this output decides when `num_slices` are exported: the layout, how
  // many slices a file holds, and their pixels.
  void describe(ContainerJob& job, std::int32_t num_slices) const;
};

struct ExportPlan {
  std::vector<ExportOutput> outputs;  // the one that was asked for, then images of the density or tables of points
  std::int32_t begin = 0;             // the slices begin, ..., end - 1
  std::int32_t end = 0;
  std::optional<ValueRange> range;  // stored numbers are to_unit(range, value); none: the values themselves
  bool with_density = false;        // in the channel A
  // The frames that are written in place of the slices: output f * values + v is value v of frame f.
  std::optional<TextureRead> reads;
  Extents extents;                         // of what is written: the texture, or [frames][values] of it
  std::optional<std::int64_t> num_points;  // with a threshold: how many pixels of the whole texture are points

  IndexRange<SliceIndex> slices() const { return {SliceIndex(begin), SliceIndex(end)}; }
  std::int32_t num_slices() const { return end - begin; }
};

// What is to be written where. `name` is the run file's path. Throws UserError with every fault.
ExportPlan plan_export(const std::string& name, const RunFileContent& content, const ProblemSpec& problem,
                       const ExportOptions& options);

// How far a run came that is not finished, in words; "" for one that is.
std::string unfinished_run(const RunFileContent& content, const RunConfig& config);

struct ExportResult {
  std::string change;               // as RunFileReader::change
  std::vector<std::string> files;   // images or arrays
  std::vector<std::string> tables;  // with a threshold: the coordinates,
  std::string points;               // and how many points there are, in words
  std::string unfinished;           // as unfinished_run
};

// Throws UserError (nothing was written) or EnvironmentError (nothing is left behind).
ExportResult export_run_file(const std::string& path, const ExportOptions& options, FileOps& ops);

}  // namespace noiseloom
