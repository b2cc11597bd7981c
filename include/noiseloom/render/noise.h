// Noises as an effect reads them: numbers of a pixel in a frame, whatever they come from.
//
// A texture is read as image/texture_read.h says: at the pixel, in the slice of the frame, further values at the R2
// offsets. A repeat moves every noise to another place and time of its own torus; noises without one (white, ign,
// sobol-*) are moved on the plane of pixels. The moves are the same for all noises, so that their errors can be
// compared pair by pair.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "noiseloom/core/random.h"
#include "noiseloom/image/texture_file.h"
#include "noiseloom/image/texture_read.h"
#include "noiseloom/render/scene.h"

namespace noiseloom::render {

// Purposes of random numbers that are in no texture: beyond those of core/random.h.
inline constexpr auto purpose_of_white = static_cast<Purpose>(101);
inline constexpr auto purpose_of_scramble = static_cast<Purpose>(102);
inline constexpr auto purpose_of_move = static_cast<Purpose>(103);
inline constexpr auto purpose_of_threshold = static_cast<Purpose>(104);
inline constexpr auto purpose_of_density = static_cast<Purpose>(105);
inline constexpr auto purpose_of_rejection = static_cast<Purpose>(106);
inline constexpr auto purpose_of_lamp = static_cast<Purpose>(107);
inline constexpr auto purpose_of_seed = static_cast<Purpose>(108);
inline constexpr auto purpose_of_truth = static_cast<Purpose>(109);
inline constexpr auto purpose_of_keys = static_cast<Purpose>(110);
inline constexpr auto purpose_of_carrying = static_cast<Purpose>(111);

// What a texture of unit vectors holds.
enum class Directions { none, cosine, hemisphere, sphere };

struct SamplerTables;

struct Noise {
  NoiseSpec spec;
  std::shared_ptr<const Texture> texture = nullptr;       // null where numbers are computed, or it was only described
  SampleSpec samples = {};                                // of the texture
  Extents extents = {};                                   // of the texture, whether it is at hand or not
  int channels = 1;                                       // of a value
  std::int64_t num_values = 0;                            // numbers in the texture, whether it is at hand or not
  std::shared_ptr<const SamplerTables> tables = nullptr;  // of the kind tables
  std::vector<std::string> notes = {};                    // what had to be assumed of its file

  // Numbers of [0, 1) that one value holds: a scalar 1, vector2 2, ...; 0 for directions and the like.
  int numbers_in_value() const;
  Directions directions() const;
};

// Makes the texture of a config and puts the run file at `output`; what is there already may be taken or gone on with.
using MakeTexture =
    std::function<void(const std::string& config, const std::vector<std::string>& changes, const std::string& output)>;

// Is called again and again while another command makes what is to be at `path`, and returns after a while. May throw
// to wait no longer.
using WaitForOther = std::function<void(const std::string& path)>;
void wait_a_moment(const std::string& path);

// Opens the noise: reads its file, or has its texture made in `folder` unless it is there from an earlier run of the
// same config; one that was damaged since is made anew, and a note says so. Commands that share the folder make what is
// kept there one at a time. Throws UserError, naming the noise.
Noise open_noise(const NoiseSpec& spec, const std::string& folder, const MakeTexture& make,
                 const WaitForOther& wait = wait_a_moment);
// The same without making anything: of a texture that is made, what its config says of it.
Noise describe_noise(const NoiseSpec& spec);
// The config of the textures that blue-2d, blue-3d and golden-ratio are made with.
std::string built_in_config(const NoiseSpec& spec);
bool has_texture(NoiseKind kind);
// Where in `folder` the texture of such a noise is kept; the name changes with the effective config.
std::string cached_texture(const NoiseSpec& spec, const std::string& folder);
// The same of the tables of a noise of kind sobol-blue.
std::string cached_tables(const NoiseSpec& spec, const std::string& folder);

// How far a repeat moves the noise: 0 <= x, y, t.
struct Move {
  std::int64_t x = 0;
  std::int64_t y = 0;
  std::int64_t t = 0;
};
// Repeat 0 moves nothing.
Move move_of_repeat(std::uint64_t seed, int repeat);

// Which pixel and slice of a texture, or step of golden-ratio, the pixel (0, 0) reads its first value of in a frame.
struct MaskPlace {
  std::int64_t x = 0;
  std::int64_t y = 0;
  std::int64_t slice = 0;
};
MaskPlace mask_place(const Noise& noise, const Move& move, std::int64_t frame);

// The numbers of one pixel in one frame.
struct Draw {
  const float* first;
  std::size_t stride;
  float operator()(int i) const { return first[static_cast<std::size_t>(i) * stride]; }
};

// Numbers of one noise for rows of a picture.
class NoiseReader {
 public:
  // `numbers` of each pixel. The noise must outlive the reader. `seeds`: of heitz-belcour, those of all pixels, which
  // in every repeat give other numbers.
  NoiseReader(const Noise& noise, const Move& move, int numbers, int width,
              const std::vector<std::uint32_t>* seeds = nullptr, int repeat = 0);

  // Values that a pixel reads in a frame.
  int values() const { return values_; }
  // Reads a row in a frame >= 0; valid until the next call.
  void read(int y, std::int64_t frame);
  Draw at(int x) const { return {numbers_.data() + x, static_cast<std::size_t>(width_)}; }

 private:
  void read_texture(int y, std::int64_t frame);
  void read_golden_ratio(int y, std::int64_t frame);
  void read_ign(int y, std::int64_t frame);
  void read_white(int y, std::int64_t frame);
  void read_sobol(int y, std::int64_t frame);
  void read_seeds(int y);
  void read_tables(int y, std::int64_t frame);
  float* plane(int number) {
    return numbers_.data() + static_cast<std::size_t>(number) * static_cast<std::size_t>(width_);
  }

  const Noise& noise_;
  Move move_;
  int numbers_of_pixel_;
  int width_;
  const std::vector<std::uint32_t>* seeds_;
  int repeat_;
  int channels_ = 1;
  int values_ = 1;
  TextureRead read_;
  std::vector<float> numbers_;  // [number][x]
};

}  // namespace noiseloom::render
