// A texture in memory, and loading one from a run file or from files that anybody made: images (numbered, in a strip or
// an atlas, or parts of an OpenEXR file), .npy, raw numbers, a dataset of an HDF5 file.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "noiseloom/config/config.h"
#include "noiseloom/core/extents.h"
#include "noiseloom/files/pixel_order.h"

namespace noiseloom {

// Values as float32, planar: [slice][channel][y][x].
struct Texture {
  Extents extents;
  int channels = 1;
  std::vector<float> values;

  std::size_t floats_per_slice() const {
    return static_cast<std::size_t>(extents.cells_per_slice()) * static_cast<std::size_t>(channels);
  }
  const float* slice(SliceIndex s) const { return values.data() + static_cast<std::size_t>(s) * floats_per_slice(); }
  float* slice(SliceIndex s) { return values.data() + static_cast<std::size_t>(s) * floats_per_slice(); }
};

// Space for the values. Throws EnvironmentError, naming the bytes, where memory does not suffice.
Texture make_texture(const Extents& extents, int channels);

// What the caller knows of a file that says too little of itself. Whatever is empty is found out; where the file leaves
// a choice, load_texture names the possible values.
struct TextureReading {
  // Of headerless numbers: uint8, uint16, float16, float32 or float64, "be" behind it for big-endian, and how many of
  // them a pixel has: "uint16be", "uint8x4". Of integers in .npy and HDF5: uint8 or uint16, the codes that they are.
  std::string type = {};
  // Which channels hold the sample, in its order: letters of an image ("RG", "A"), or numbers from 0 ("0,2").
  std::string channels = {};
  // Where the slices lie in one image: image (it is one slice), strip (downward), row (to the right), atlas:CxR (C
  // columns and R rows, from left to right, then down), atlas-down:CxR (down, then to the right).
  std::string layout = {};
  // What the dimensions of an array are, slowest first: a letter each, c for the channel ("tyx", "yxtc"), or names with
  // commas between them ("time,y,x,channel").
  std::string axes = {};
};

// Of so many slices at most the places are kept.
inline constexpr std::int32_t most_slices_with_places = 16;

struct TextureFile {
  Texture texture;
  std::string source;                                                // "run file", "64 images, 8 bit", ...
  std::optional<RunConfig> config;                                   // stored in the file, or the one given
  std::vector<std::string> notes;                                    // what had to be assumed, one sentence each
  std::vector<std::pair<std::string, std::vector<double>>> history;  // run files
  std::string checksum;                                              // run files: of /samples
  // Run files with /order: the places in the sequence of all pixels of the first slices, [slice][y][x], at most
  // most_slices_with_places.
  std::vector<OrderPlace> places;
  // Channels of the file that hold values of their own but are no part of the sample, by their names.
  std::vector<std::string> further_channels;
  double step = 0;  // between neighbouring values that the file could hold; 0: floats
};

// Loads `path`: a run file; an image, a folder of numbered images, the first of them, or a pattern (noise_{}.png,
// noise_%d.png, noise_####.png, noise_*.png); .npy; raw (with its .json beside it, or with `config`); FILE.h5:/DATASET.
// Integers are decoded as encoding.h says, directions then normalised.
// Images and textures that were exported here say themselves what they hold, unless `config` does.
// `config` says what the values mean and how large the texture is; for a run file, which knows that, only the filter of
// `config` is taken, its axes by their names. Without a config the size comes from the file (an image whose height is a
// multiple of its width is a strip of squares) and the values are taken as 0..1.
// Throws UserError, with what was found and what was expected, when they do not fit together, when a value is not
// finite or lies outside the space of the samples, and where several readings fit.
TextureFile load_texture(const std::string& path, const std::optional<RunConfig>& config,
                         const TextureReading& reading = {});

// All that a file holds, before channels are chosen and numbers decoded: what `verify` looks at.
struct StoredTexture {
  Texture texture;  // every channel; integers as 0 to 1, (b + 0.5) / 2^n
  std::vector<std::string> channel_names;
  bool codes = false;               // integers
  bool values = false;              // the values themselves: run files and arrays of floats
  double step = 0;                  // between neighbouring numbers; 0: floats
  bool is_srgb = false;             // marked as colours that samplers decode
  std::optional<RunConfig> config;  // stored in the file, or the one given
  std::string source;
  std::vector<std::string> notes;
};
// As load_texture, without looking at what the numbers are.
StoredTexture load_stored_texture(const std::string& path, const std::optional<RunConfig>& config,
                                  const TextureReading& reading = {});

// The config of the run that an image or texture was exported from, where the file holds it (PNG, OpenEXR, TIFF and
// KTX2 do), with `overrides` applied; its slice axis is as long as the file has slices. Throws UserError as
// load_texture does.
std::optional<RunConfig> config_in_images(const std::string& path, const std::vector<std::string>& overrides);

// The size that a file that is no run file suggests, for a config that leaves it open. `channels`: those of a sample, 0
// where that is open too. Throws UserError as load_texture does.
Extents suggested_extents(const std::string& path, int channels, const TextureReading& reading);

// Copies interleaved [cell][channel] values to planes [channel][cell].
void interleaved_to_planar(std::span<const float> interleaved, int channels, float* planes);
// The slice as interleaved [cell][channel] values.
std::vector<float> interleaved_slice(const Texture& texture, SliceIndex slice);

// Scales every vector to length one. Throws UserError for one of length zero or not finite, naming its place.
void normalise_directions(Texture& texture, const std::string& name);
// Throws UserError naming the place of the first value that is not finite.
void check_finite(const Texture& texture, const std::string& name);

// "x 5, y 7, slice 3, channel 1": the place of values[index].
std::string place_of(const Texture& texture, std::size_t index);

}  // namespace noiseloom
