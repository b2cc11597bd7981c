// A texture in memory, and loading one from a run file or from files that anybody made: images (numbered, one under the
// other in a strip, or parts of an OpenEXR file), .npy, raw.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "noiseloom/config/config.h"
#include "noiseloom/core/extents.h"

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

// Space for the values.
Texture make_texture(const Extents& extents, int channels);

inline constexpr SliceIndex ranked_slices = 16;

struct TextureFile {
  Texture texture;
  std::string source;                                                // "run file", "64 images, 8 bit", ...
  std::optional<RunConfig> config;                                   // stored in the file, or the one given
  std::vector<std::string> notes;                                    // what had to be assumed, one sentence each
  std::vector<std::pair<std::string, std::vector<double>>> history;  // run files
  std::string checksum;                                              // run files: of /samples
  // Run files with /order: the places in the sequence of all pixels of the first slices, at most ranked_slices.
  std::vector<std::uint64_t> ranks;
};

// Loads `path`: a run file; an image, a folder of numbered images, the first of them, or a pattern (noise_{}.png,
// noise_%d.png); .npy; raw (with its .json beside it, or with `config`). Integers are decoded as encoding.h says,
// directions then normalised.
// `config` says what the values mean and how large the texture is; for a run file, which knows that, only the filter of
// `config` is taken. Without a config the size comes from the images (an image whose height is a multiple of its width
// is a strip of squares) and the values are taken as 0..1.
// Throws UserError, with what was found and what was expected, when they do not fit together or a value is not finite.
TextureFile load_texture(const std::string& path, const std::optional<RunConfig>& config);

// Copies interleaved [cell][channel] values to planes [channel][cell].
void interleaved_to_planar(std::span<const float> interleaved, int channels, float* planes);
// The slice as interleaved [cell][channel] values.
std::vector<float> interleaved_slice(const Texture& texture, SliceIndex slice);

// Scales every vector to length one. Throws UserError for one of length zero or not finite, naming its place.
void normalise_directions(Texture& texture, const std::string& name);
// Throws UserError naming the place of the first value that is not finite.
void check_finite(const Texture& texture, const std::string& name);

}  // namespace noiseloom
