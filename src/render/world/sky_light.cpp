#include "render/world/sky_light.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "noiseloom/core/error.h"
#include "noiseloom/core/math.h"
#include "noiseloom/files/image_decoder.h"
#include "noiseloom/files/input_array.h"

namespace noiseloom::render {
namespace {

constexpr int width_of_sun_sky = 64;
constexpr double brightness_of_plane = 0.8;

struct SkyPixels {
  int width = 0;
  int height = 0;  // of the whole image
  std::vector<std::array<double, 3>> radiance;
};

SkyPixels sky_of_sun() {
  SkyPixels pixels{width_of_sun_sky, width_of_sun_sky / 2, {}};
  for (int y = 0; y < pixels.height; ++y)
    for (int x = 0; x < pixels.width; ++x) {
      const double height = std::max(0.0, 1 - 2 * (y + 0.5) / pixels.height);
      const bool is_sun = y >= 6 && y <= 7 && x >= 43 && x <= 44;
      if (is_sun) {
        pixels.radiance.push_back({220, 190, 140});
      } else {
        pixels.radiance.push_back({0.9 - 0.6 * height, 0.95 - 0.45 * height, 1.0 - 0.1 * height});
      }
    }
  return pixels;
}

SkyPixels sky_of_image(const std::string& file) {
  const InputArrayPtr image = decode_image(file);
  const std::vector<std::int64_t>& shape = image->shape;
  const std::int64_t channels = shape.size() == 3 ? shape[2] : 1;
  if (shape[0] < 2) throw UserError(file, "has one row: the upper half of a sky needs rows of its own");
  SkyPixels pixels{static_cast<int>(shape[1]), static_cast<int>(shape[0]), {}};
  const auto& values = std::get<SharedValues<float>>(image->values);
  for (std::int64_t i = 0; i < shape[0] * shape[1]; ++i) {
    std::array<double, 3> radiance{};
    for (std::size_t c = 0; c < 3; ++c) {
      const float value = values[static_cast<std::size_t>(i * channels) + (channels >= 3 ? c : 0)];
      if (!(value >= 0) || !std::isfinite(value))
        throw UserError(file, fmt::format("holds {} at x {}, y {}: light is finite and at least 0", value, i % shape[1],
                                          i / shape[1]));
      radiance[c] = static_cast<double>(value);
    }
    pixels.radiance.push_back(radiance);
  }
  return pixels;
}

double brightness(const std::array<double, 3>& light) {
  return 0.2126 * light[0] + 0.7152 * light[1] + 0.0722 * light[2];
}

}  // namespace

Texel SkyLight::cell_of(Vector direction) const {
  const double a = math::acos(std::clamp(direction.y, -1.0, 1.0)) / math::pi;
  const double around = std::sqrt(direction.x * direction.x + direction.z * direction.z);
  const double turn = around > 0 ? math::acos(direction.x / around) / math::two_pi : 0;
  const double b = direction.z < 0 ? 1 - turn : turn;
  const int x = std::clamp(static_cast<int>(b * fine_width), 0, fine_width - 1);
  const int y = std::clamp(static_cast<int>(a * image_height), 0, fine_height - 1);
  return {static_cast<int>(std::int64_t{x} * cells.width() / fine_width),
          static_cast<int>(std::int64_t{y} * cells.height() / fine_height)};
}

Texel SkyLight::turned(Texel cell, std::int64_t columns) const {
  const std::int64_t width = cells.width();
  return {static_cast<int>(((cell.x + columns) % width + width) % width), cell.y};
}

std::int64_t most_columns(const SkySpec& spec) {
  return spec.file.empty() ? std::min(spec.columns, width_of_sun_sky) : spec.columns;
}

std::int64_t most_cells(const SkySpec& spec) { return most_columns(spec) * (most_columns(spec) / 4); }

SkyLight make_sky(const SkySpec& spec) {
  const SkyPixels pixels = spec.file.empty() ? sky_of_sun() : sky_of_image(spec.file);
  SkyLight sky;
  sky.fine_width = pixels.width;
  sky.fine_height = (pixels.height + 1) / 2;
  sky.image_height = pixels.height;
  const int columns = std::min(spec.columns, sky.fine_width);
  const int rows = std::min(spec.columns / 4, sky.fine_height);
  const std::size_t count = static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows);
  sky.light.resize(count);
  sky.solid_angles.resize(count);
  std::vector<Vector> middles(count);
  for (int y = 0; y < sky.fine_height; ++y) {
    const double above = math::cos_2pi(0.5 * y / pixels.height);
    // The middle row of an odd number ends at the horizon.
    const double below = std::max(0.0, math::cos_2pi(0.5 * (y + 1) / pixels.height));
    const double solid = math::two_pi * (above - below) / pixels.width;
    const double cosine = 0.5 * (above + below);
    const double sine = std::sqrt(std::max(0.0, 1 - cosine * cosine));
    for (int x = 0; x < pixels.width; ++x) {
      const std::size_t cell =
          static_cast<std::size_t>(std::int64_t{y} * rows / sky.fine_height) * static_cast<std::size_t>(columns) +
          static_cast<std::size_t>(std::int64_t{x} * columns / pixels.width);
      const double turn = (x + 0.5) / pixels.width;
      middles[cell] = middles[cell] + solid * Vector{sine * math::cos_2pi(turn), cosine, sine * math::sin_2pi(turn)};
      sky.solid_angles[cell] += solid;
      for (std::size_t c = 0; c < 3; ++c)
        sky.light[cell][c] += solid / math::pi *
                              pixels.radiance[static_cast<std::size_t>(y) * static_cast<std::size_t>(pixels.width) +
                                              static_cast<std::size_t>(x)][c];
    }
  }
  double on_plane = 0;
  std::vector<double> masses;
  for (std::size_t cell = 0; cell < count; ++cell) {
    sky.directions.push_back((1 / std::sqrt(dot(middles[cell], middles[cell]))) * middles[cell]);
    masses.push_back(brightness(sky.light[cell]));
    on_plane += masses.back() * sky.directions.back().y;
  }
  if (!(on_plane > 0)) throw UserError(spec.file, "is black above the horizon: a sky needs some light");
  for (auto& light : sky.light)
    for (double& value : light) value *= brightness_of_plane / on_plane;
  sky.cells = MassTable(columns, rows, masses);
  return sky;
}

void check_directions(const Noise& noise, const SkyLight& sky) {
  const Texture& texture = *noise.texture;
  const auto pixels = static_cast<std::size_t>(texture.extents.cells_per_slice());
  const double samples = static_cast<double>(texture.extents.num_cells());
  std::vector<double> shares(sky.directions.size());
  for (const SliceIndex s : texture.extents.slices()) {
    const float* const slice = texture.slice(s);
    for (std::size_t i = 0; i < pixels; ++i) {
      const Vector direction{static_cast<double>(slice[i]), static_cast<double>(slice[pixels + i]),
                             static_cast<double>(slice[2 * pixels + i])};
      shares[sky.index(sky.cell_of(direction))] += 1 / samples;
    }
  }
  // Squares of what is off, over the variance of a count and 1: a cell of which nothing is expected weighs little, as
  // rounding may carry a direction over its edge. Directions of strata are off by less than independent ones.
  double off = 0;
  double by_chance = 0;
  double worst = 0;
  Texel place;
  for (int y = 0; y < sky.cells.height(); ++y)
    for (int x = 0; x < sky.cells.width(); ++x) {
      const double mass = sky.cells.mass({x, y});
      const double missed = shares[sky.index({x, y})] - mass;
      const double square = samples * missed * missed / (mass + 1 / samples);
      off += square;
      by_chance += mass / (mass + 1 / samples);
      if (square <= worst) continue;
      worst = square;
      place = {x, y};
    }
  if (off <= by_chance + 6 * std::sqrt(2 * by_chance)) return;
  throw UserError(
      "noise \"" + noise.spec.name + "\"",
      fmt::format(
          "has {:.3g} % of its directions in the cell in column {}, row {} (of {} x {}) of the sky, which holds "
          "{:.3g} % of the light: it was made for another image than effects.sky.file, or for the same image "
          "in another encoding",
          100 * shares[sky.index(place)], place.x, place.y, sky.cells.width(), sky.cells.height(),
          100 * sky.cells.mass(place)));
}

}  // namespace noiseloom::render
