#include <algorithm>
#include <cmath>

#include "noiseloom/core/error.h"
#include "noiseloom/core/random.h"
#include "noiseloom/render/noise.h"
#include "noiseloom/samples/sobol.h"
#include "render/noises/sampler_tables.h"

namespace noiseloom::render {
namespace {

// The fraction of the golden ratio, times 2^32.
constexpr std::uint32_t golden_step = 2654435769U;
constexpr float largest_below_one = 0x1.fffffep-1F;
constexpr int dimensions_of_point = max_sobol_dimensions;

float fraction(double value) { return std::min(static_cast<float>(value - std::floor(value)), largest_below_one); }

// Of the pixel, which lies anywhere on the plane.
std::uint64_t index_of(std::int64_t x, std::int64_t y) {
  return (static_cast<std::uint64_t>(y) << 28) | static_cast<std::uint64_t>(x);
}

// What noises without a size are read as: the offsets of further values are those of a texture of this size.
constexpr std::int64_t plain_size = 128;

}  // namespace

NoiseReader::NoiseReader(const Noise& noise, const Move& move, int numbers, int width,
                         const std::vector<std::uint32_t>* seeds, int repeat)
    : noise_(noise), move_(move), numbers_of_pixel_(numbers), width_(width), seeds_(seeds), repeat_(repeat) {
  if (const Texture* const texture = noise.texture.get()) {
    channels_ = texture->channels;
    read_ = {.width = texture->extents.width(),
             .height = texture->extents.height(),
             .num_slices = texture->extents.num_slices()};
  } else {
    read_ = {.width = plain_size, .height = plain_size, .num_slices = 1};
  }
  values_ = (numbers + channels_ - 1) / channels_;
  read_.values = values_;
  read_.from = noise.spec.values_from;
  numbers_.resize(static_cast<std::size_t>(values_ * channels_) * static_cast<std::size_t>(width));
}

void NoiseReader::read(int y, std::int64_t frame) {
  switch (noise_.spec.kind) {
    case NoiseKind::file:
    case NoiseKind::config:
    case NoiseKind::blue_2d:
    case NoiseKind::blue_3d:
      return read_texture(y, frame);
    case NoiseKind::golden_ratio:
      return read_golden_ratio(y, frame);
    case NoiseKind::ign:
      return read_ign(y, frame);
    case NoiseKind::white:
      return read_white(y, frame);
    case NoiseKind::sobol_owen:
    case NoiseKind::sobol_rotated:
      return read_sobol(y, frame);
    case NoiseKind::heitz_belcour:
      return read_seeds(y);
    case NoiseKind::tables:
    case NoiseKind::sobol_blue:
      return read_tables(y, frame);
  }
}

// A seed gives the same numbers in every frame: that is what its place is chosen by.
void NoiseReader::read_seeds(int y) {
  NOISELOOM_CHECK(seeds_ != nullptr);
  const std::size_t row = static_cast<std::size_t>(y) * static_cast<std::size_t>(width_);
  for (int first = 0; first < numbers_of_pixel_; first += 4) {
    const int count = std::min(4, numbers_of_pixel_ - first);
    for (int x = 0; x < width_; ++x) {
      const RandomBlock block =
          random_block(noise_.spec.seed, purpose_of_seed, static_cast<std::uint32_t>(repeat_),
                       static_cast<std::uint32_t>(first / 4), (*seeds_)[row + static_cast<std::size_t>(x)]);
      for (int i = 0; i < count; ++i) plane(first + i)[x] = to_unit_float(block[static_cast<std::size_t>(i)]);
    }
  }
}

// A point a frame. As with the other sequences, no repeat begins elsewhere in time.
void NoiseReader::read_tables(int y, std::int64_t frame) {
  const SamplerTables& tables = *noise_.tables;
  for (int i = 0; i < numbers_of_pixel_; ++i)
    for (int x = 0; x < width_; ++x)
      plane(i)[x] = tables.value(static_cast<std::size_t>(x + move_.x), static_cast<std::size_t>(y + move_.y),
                                 static_cast<std::size_t>(frame), static_cast<std::size_t>(i));
}

void NoiseReader::read_texture(int y, std::int64_t frame) {
  const Texture& texture = *noise_.texture;
  const std::size_t cells = static_cast<std::size_t>(texture.extents.cells_per_slice());
  for (int value = 0; value < values_; ++value) {
    const TextureRead::Place place = read_.place(frame, value);
    const auto slice = SliceIndex((place.slice.value() + move_.t) % read_.num_slices);
    const std::int64_t row = (y + move_.y + place.dy) % read_.height;
    const std::int64_t column = (move_.x + place.dx) % read_.width;
    for (int c = 0; c < channels_; ++c) {
      const float* const from = texture.slice(slice) + static_cast<std::size_t>(c) * cells + row * read_.width;
      float* const to = plane(value * channels_ + c);
      std::int64_t x = 0;
      for (std::int64_t begin = column; x < width_; begin = 0) {
        const std::int64_t count = std::min<std::int64_t>(read_.width - begin, width_ - x);
        std::copy_n(from + begin, count, to + x);
        x += count;
      }
    }
  }
}

// The slice moves on in value, not in place; whole numbers of 2^-32, so that it is the same in every frame however
// late.
void NoiseReader::read_golden_ratio(int y, std::int64_t frame) {
  const std::int64_t step = (frame + move_.t) % noise_.spec.slices;
  const double phase = 0x1p-32 * (static_cast<std::uint32_t>(step) * golden_step);
  read_texture(y, 0);
  for (float& number : numbers_) number = fraction(static_cast<double>(number) + phase);
}

void NoiseReader::read_ign(int y, std::int64_t frame) {
  const double step = 5.588238 * static_cast<double>((frame + move_.t) % noise_.spec.slices);
  for (int i = 0; i < numbers_of_pixel_; ++i) {
    const TextureRead::Place place = read_.place(0, i);
    float* const to = plane(i);
    const double down = 0.00583715 * (static_cast<double>(y + move_.y % plain_size + place.dy) + 0.5 + step);
    for (int x = 0; x < width_; ++x) {
      const double across = static_cast<double>(x + move_.x % plain_size + place.dx) + 0.5 + step;
      const double inner = 0.06711056 * across + down;
      to[x] = fraction(52.9829189 * (inner - std::floor(inner)));
    }
  }
}

void NoiseReader::read_white(int y, std::int64_t frame) {
  const auto time = static_cast<std::uint32_t>(frame + move_.t);
  for (int first = 0; first < numbers_of_pixel_; first += 4) {
    const int count = std::min(4, numbers_of_pixel_ - first);
    for (int x = 0; x < width_; ++x) {
      const RandomBlock block = random_block(noise_.spec.seed, purpose_of_white, time,
                                             static_cast<std::uint32_t>(first / 4), index_of(x + move_.x, y + move_.y));
      for (int i = 0; i < count; ++i) plane(first + i)[x] = to_unit_float(block[static_cast<std::size_t>(i)]);
    }
  }
}

// Four numbers are a point. Further points of a pixel are of the same sequence in another order, each under a scramble
// of its own; that a repeat begins elsewhere in time would break the nets of the first frames, so it does not.
void NoiseReader::read_sobol(int y, std::int64_t frame) {
  constexpr std::uint32_t most = (1U << sobol_bits) - 1;
  const bool owen = noise_.spec.kind == NoiseKind::sobol_owen;
  for (int first = 0; first < numbers_of_pixel_; first += dimensions_of_point) {
    const int count = std::min(dimensions_of_point, numbers_of_pixel_ - first);
    for (int x = 0; x < width_; ++x) {
      const RandomBlock block = random_block(noise_.spec.seed, purpose_of_scramble, 0,
                                             static_cast<std::uint32_t>(first), index_of(x + move_.x, y + move_.y));
      const std::uint32_t order = first == 0 ? 0 : block[2] ^ block[3];
      const std::uint32_t index = (static_cast<std::uint32_t>(frame) ^ order) & most;
      const auto point = sobol_point(index);
      const std::uint64_t seed = (std::uint64_t{block[0]} << 32) | block[1];
      for (int i = 0; i < count; ++i) {
        const std::uint32_t code = point[static_cast<std::size_t>(i)];
        plane(first + i)[x] =
            owen ? sobol_value(owen_scrambled(code, i, seed))
                 : sobol_value((code + (block[static_cast<std::size_t>(i)] >> (32 - sobol_bits))) & most);
      }
    }
  }
}

}  // namespace noiseloom::render
