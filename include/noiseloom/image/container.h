// The containers that textures are exported to: image formats, arrays, tables of points.
//
// A container is one writer behind one interface and one row of one table. Everything that depends on the container is
// read from its row: which file endings belong to it, which number types, layouts and channels it holds, what the help
// says and what an error message lists as accepted. To add one, write a ContainerWriter in a file of its own, name the
// function that makes it in src/image/containers/container_writers.h, and add a row in
// src/image/containers/containers.cpp.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "noiseloom/core/extents.h"
#include "noiseloom/files/output_files.h"
#include "noiseloom/image/encoding.h"
#include "noiseloom/image/image_io.h"

namespace noiseloom {

// How the slices of a texture are spread over files.
enum class ExportLayout {
  slices,    // a file each
  strip,     // one image, each slice under the one before it
  row,       // one image, each slice to the right of the one before it
  atlas,     // one image, slices in rows from left to right
  parts,     // one file, an image of its own for each slice
  array,     // one file, slice after slice
  volume,    // one file, slice after slice, as a texture of three dimensions
  function,  // the text of a function that reads a texture, without its numbers
  table,     // one file of rows that are no pixels
};
std::string to_string(ExportLayout layout);  // as --layout takes it

// What a writer is given for each slice.
enum class ContainerContent {
  pixels,  // finished numbers, [y][x][channel], native byte order, of the type that was chosen
  places,  // the place of each pixel in the sequence of a mask, uint64 [y][x]
};

// Which numbers a container stores for the values of a texture.
enum class StoredNumbers {
  by_type,     // integers stand for a range; floats are the values themselves unless a range is given
  unit,        // every number stands for a range, floats too, as the container holds nothing below 0
  the_values,  // the values themselves, never a range
};

// What a writer must know before the first slice. Lives until end() has returned.
struct ContainerJob {
  std::string source;           // path of the run file, for messages
  Extents extents;              // of the whole texture
  SliceIndex first_slice;       // the first of the slices that go into this file,
  std::int32_t num_slices = 1;  // and how many there are
  ExportLayout layout = ExportLayout::slices;
  ImageShape slice;                 // of one slice; content `pixels` alone
  int columns = 1;                  // of slices beside each other; layouts `row` and `atlas`
  std::string description;          // what the file holds, a line for people
  std::string decoding;             // how a stored number becomes a value: "-1 + 2 * (b + 0.5) / 256"
  std::optional<ValueRange> range;  // stored numbers are to_unit(range, value); none: the values themselves
  std::string samples;              // name of the sample space
  bool directions = false;          // samples are unit vectors
  std::string config;               // of the run, TOML; "" where several are packed
  bool holds_samples = true;        // of the run's slices: not points, densities, frames, or several runs
  std::vector<std::pair<std::string, std::string>> facts;  // where the numbers come from, for files with room for that
  std::string unfinished;                                  // how far the run came, in words; "" where it is finished
  std::optional<std::int64_t> num_points;  // of the point set in the whole texture, where one is exported

  IndexRange<SliceIndex> slices() const { return {first_slice, SliceIndex(first_slice.value() + num_slices)}; }
  bool holds_all_slices() const { return num_slices == extents.num_slices(); }
};

// Writes one file at a time: begin, then every slice in ascending order, then end. Files go through OutputFiles, so
// that nothing appears before all of an export is written. Each function throws EnvironmentError when the disk or a
// library fails, and UserError when what it is given cannot be written.
class ContainerWriter {
 public:
  virtual ~ContainerWriter() = default;
  virtual void begin(const std::string& target, const ContainerJob& job) = 0;
  virtual void slice(SliceIndex slice, std::span<const std::byte> bytes) = 0;
  virtual void end() = 0;
};

struct Container {
  std::string name;  // as --format takes it; one name may have a row for each content
  ContainerContent content = ContainerContent::pixels;
  std::vector<std::string> endings;   // of file names; the first is what files get. With two dots: chosen by name alone
  std::vector<PixelType> types;       // the first is the default; empty where numbers have no choice of type
  std::vector<ExportLayout> layouts;  // the first is the default
  StoredNumbers numbers = StoredNumbers::by_type;
  int most_channels = 0;   // 0: as many as there are
  bool has_alpha = false;  // a density can go into a channel of its own
  // Which pixel channels hold the channels of a sample. Requires channels that fit and, with density, alpha.
  PixelLayout (*pixel)(int channels, bool with_density) = nullptr;
  std::vector<int> pixel_sizes;  // how many channels --channels may ask for
  std::unique_ptr<ContainerWriter> (*make)(OutputFiles& files) = nullptr;
};

// The table.
const std::vector<Container>& containers();

// nullptr where no row has that name and content.
const Container* find_container(const std::string& name, ContainerContent content);
// By the ending of the file name, in upper or lower case; rows for pixels come first. nullptr where none has it.
const Container* container_of_file(const std::string& path);

// Whether the container can hold samples of so many channels; `why` then says what stands in the way.
bool holds_channels(const Container& container, int channels, bool with_density, std::string& why);

// "8", "16", "32f": a type as --depth takes it.
std::string depth_name(PixelType type);

// For help texts and messages: "png, exr, tiff"; "png: 8, 16; exr: 32f"; "png: slices, strip; exr: slices, ...". In the
// last two the first word after each name is the default.
std::string container_names();
std::string container_depths();
std::string container_layouts();

}  // namespace noiseloom
