#include "render/world/kernel.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "noiseloom/core/error.h"
#include "noiseloom/core/math.h"
#include "noiseloom/core/random.h"
#include "noiseloom/samples/luminance.h"

namespace noiseloom::render {
namespace {

constexpr int most_across_kernel = 255;
constexpr int finer = 48;  // places along each side of a texel at which a shape is asked for

// A shape whose corners lie at equal angles around the middle, the first to the right, in turns at the distances 1 and
// `inner`; without corners the unit disk. The shapes are those of the sample spaces of their names.
struct LensShape {
  int corners = 0;
  double inner = 1;

  bool contains(double x, double y) const {
    if (corners == 0) return x * x + y * y <= 1;
    for (int i = 0; i < corners; ++i) {
      const auto [from_x, from_y] = corner(i);
      const auto [to_x, to_y] = corner(i + 1);
      if (from_x * y - from_y * x >= 0 && x * to_y - y * to_x >= 0)
        return (to_x - from_x) * (y - from_y) - (to_y - from_y) * (x - from_x) >= 0;
    }
    return false;
  }

 private:
  std::pair<double, double> corner(int i) const {
    const double radius = i % 2 == 0 ? 1 : inner;
    const double turn = static_cast<double>(i) / corners;
    return {radius * math::cos_2pi(turn), radius * math::sin_2pi(turn)};
  }
};

LensShape shape_of(BlurKernel kernel) {
  if (kernel == BlurKernel::hexagon) return {6, 1};
  return kernel == BlurKernel::star ? LensShape{10, 0.4} : LensShape{};
}

// The part of each texel that lies in a shape that fills the unit disk or a part of it.
std::vector<double> masses_of_shape(const LensShape& shape, int size) {
  std::vector<double> masses;
  for (int y = 0; y < size; ++y)
    for (int x = 0; x < size; ++x) {
      int inside = 0;
      for (int j = 0; j < finer; ++j)
        for (int i = 0; i < finer; ++i)
          inside +=
              shape.contains(2 * (x + (i + 0.5) / finer) / size - 1, 2 * (y + (j + 0.5) / finer) / size - 1) ? 1 : 0;
      masses.push_back(inside);
    }
  return masses;
}

std::vector<double> masses_of_gauss(int size) {
  const double deviation = size / 6.0;
  std::vector<double> masses;
  for (int y = 0; y < size; ++y)
    for (int x = 0; x < size; ++x) {
      const double dx = x - size / 2;
      const double dy = y - size / 2;
      masses.push_back(math::exp(-(dx * dx + dy * dy) / (2 * deviation * deviation)));
    }
  return masses;
}

MassTable kernel_of_image(const ConvolutionSpec& spec) {
  SampleSpec samples;
  samples.space = "image";
  samples.file = spec.file;
  samples.encoding = spec.srgb ? ImageEncoding::srgb : ImageEncoding::linear;
  const InputArrayPtr luminance = read_luminance(samples);
  const auto height = luminance->shape[0];
  const auto width = luminance->shape[1];
  if (width > most_across_kernel || height > most_across_kernel)
    throw UserError(spec.file, fmt::format("is {} x {} pixels: a kernel has at most {} along an axis", width, height,
                                           most_across_kernel));
  std::vector<double> masses;
  double sum = 0;
  for (const float value : std::get<SharedValues<float>>(luminance->values)) {
    if (!(value >= 0) || !std::isfinite(value))
      throw UserError(spec.file, fmt::format("holds {}: the masses of a kernel are finite and at least 0", value));
    masses.push_back(static_cast<double>(value));
    sum += masses.back();
  }
  if (!(sum > 0)) throw UserError(spec.file, "is black: a kernel needs some light");
  return {static_cast<int>(width), static_cast<int>(height), masses};
}

// The first element of sums that is above `share` of the last of them.
int place_in(const double* sums, int count, double share) {
  const double* const end = sums + count;
  const double* found = std::upper_bound(sums, end, share * sums[count - 1]);
  if (found == end) {  // by rounding: the last that holds anything
    --found;
    while (found != sums && !(found[0] > found[-1])) --found;
  }
  return static_cast<int>(found - sums);
}

}  // namespace

MassTable::MassTable(int width, int height, const std::vector<double>& masses) : width_(width), height_(height) {
  double whole = 0;
  for (const double mass : masses) whole += mass;
  double up_to_row = 0;
  for (int y = 0; y < height; ++y) {
    double in_row = 0;
    for (int x = 0; x < width; ++x) {
      in_row +=
          masses[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x)] / whole;
      cells_.push_back(in_row);
    }
    up_to_row += in_row;
    rows_.push_back(up_to_row);
  }
}

double MassTable::mass(Texel texel) const {
  const std::size_t place =
      static_cast<std::size_t>(texel.y) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(texel.x);
  return texel.x == 0 ? cells_[place] : cells_[place] - cells_[place - 1];
}

Texel MassTable::at(double u, double v) const {
  const int y = place_in(rows_.data(), height_, v);
  return {place_in(cells_.data() + std::ptrdiff_t{y} * width_, width_, u), y};
}

Weights weights_of(const MassTable& masses, const std::vector<double>& chances) {
  Weights weights;
  std::size_t i = 0;
  for (int y = 0; y < masses.height(); ++y)
    for (int x = 0; x < masses.width(); ++x, ++i) {
      const double mass = masses.mass({x, y});
      if (!(mass > 0) || !(chances[i] > 0)) continue;
      weights.largest = std::max(weights.largest, mass / chances[i]);
      weights.above_clamp += std::max(0.0, mass - weight_clamp * chances[i]);
    }
  return weights;
}

std::string note_of_weights(const std::string& noise, const std::string& effect, const Weights& weights) {
  return fmt::format(
      "noise \"{}\": it is spread evenly, so that a sample of {} weighs up to {:.3g} times the mean; {}", noise, effect,
      weights.largest,
      weights.above_clamp > 0
          ? fmt::format("a clamp of weights at {:g} would take {:.2g} % of the mean (nothing is clamped)", weight_clamp,
                        100 * weights.above_clamp)
          : fmt::format("a clamp of weights at {:g} would change nothing", weight_clamp));
}

const char* space_of_kernel(BlurKernel kernel) {
  switch (kernel) {
    case BlurKernel::disk:
      return "disk";
    case BlurKernel::hexagon:
      return "hexagon";
    case BlurKernel::star:
      return "star";
    case BlurKernel::gauss:
    case BlurKernel::image:
      break;
  }
  return "";
}

MassTable make_kernel(const ConvolutionSpec& spec) {
  if (spec.kernel == BlurKernel::image) return kernel_of_image(spec);
  return {spec.size, spec.size,
          spec.kernel == BlurKernel::gauss ? masses_of_gauss(spec.size)
                                           : masses_of_shape(shape_of(spec.kernel), spec.size)};
}

Texel texel_of(double x, double y, bool of_disk, int width, int height) {
  const auto place = [&](double at, int size) {
    return std::clamp(static_cast<int>(std::floor((of_disk ? (at + 1) / 2 : at) * size)), 0, size - 1);
  };
  return {place(x, width), place(y, height)};
}

Image picture_of_lights(int width, int height) {
  Image image = make_image(width, height, 3);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const double u = (x + 0.5) / width;
      const double v = (y + 0.5) / height;
      const double stripe = math::sin_2pi(8 * u + 4 * v) > 0 ? 1.0 : 0.4;
      const double colours[] = {0.10 + 0.15 * v, 0.12, 0.25 - 0.12 * v};
      for (int c = 0; c < 3; ++c) image.row(c, y)[x] = static_cast<float>(stripe * colours[c]);
    }
  // One lamp in each cell of a grid, of a colour and a brightness of its own.
  constexpr int across = 5;
  for (int cell = 0; cell < across * across; ++cell) {
    const RandomBlock block = random_block(7, purpose_of_lamp, 0, 0, static_cast<std::uint64_t>(cell));
    const auto number = [&](int i) { return static_cast<double>(to_unit_float(block[static_cast<std::size_t>(i)])); };
    const int left = static_cast<int>((cell % across + 0.2 + 0.6 * number(0)) * width / across);
    const int top = static_cast<int>((cell / across + 0.2 + 0.6 * number(1)) * height / across);
    const double brightness = 20 + 60 * number(2);
    const double hue = number(3);
    for (int dy = 0; dy < 3; ++dy)
      for (int dx = 0; dx < 3; ++dx)
        for (int c = 0; c < 3; ++c)
          image.row(c, inside(top + dy, height, Border::wrap))[inside(left + dx, width, Border::wrap)] =
              static_cast<float>(brightness * (0.35 + 0.65 * (0.5 + 0.5 * math::cos_2pi(hue + c / 3.0))));
  }
  return image;
}

}  // namespace noiseloom::render
