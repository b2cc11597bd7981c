#include "noiseloom/measure/distribution.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "noiseloom/samples/space.h"

namespace noiseloom {
namespace {

constexpr double odds = 1e-6;  // of a false alarm
constexpr int num_bins = 4096;
constexpr double coding_slack = 1.0 / 256;  // of the range

constexpr ValueRange histogram_of_unbounded = {-6, 6};

template <class Action>
void for_each_value(const Texture& texture, int channel, Action action) {
  const std::size_t cells = static_cast<std::size_t>(texture.extents.cells_per_slice());
  for (const SliceIndex s : texture.extents.slices()) {
    const float* const values = texture.slice(s) + static_cast<std::size_t>(channel) * cells;
    for (std::size_t i = 0; i < cells; ++i) action(static_cast<double>(values[i]));
  }
}

struct Moments {
  double least = INFINITY;
  double largest = -INFINITY;
  double mean = 0;
  double deviation = 0;
};

Moments moments_of(const Texture& texture, int channel) {
  Moments moments;
  double sum = 0;
  double squares = 0;
  for_each_value(texture, channel, [&](double v) {
    moments.least = std::min(moments.least, v);
    moments.largest = std::max(moments.largest, v);
    sum += v;
    squares += v * v;
  });
  const double n = static_cast<double>(texture.extents.num_cells());
  moments.mean = sum / n;
  moments.deviation = std::sqrt(std::max(0.0, squares / n - moments.mean * moments.mean));
  return moments;
}

// Of a channel of an unbounded space, over the range of the histogram: integrals of its distribution function by parts.
Moments moments_of(const SampleSpace& space, int channel) {
  const auto [lo, hi] = histogram_of_unbounded;
  const double width = (hi - lo) / num_bins;
  double mean = hi;
  double squares = hi * hi;
  for (int bin = 0; bin < num_bins; ++bin) {
    const double x = lo + (bin + 0.5) * width;
    mean -= space.share_below(channel, x) * width;
    squares -= 2 * x * space.share_below(channel, x) * width;
  }
  return {.least = lo, .largest = hi, .mean = mean, .deviation = std::sqrt(squares - mean * mean)};
}

struct Deviation {
  double distance = 0;  // beyond what coding explains
  double at = 0;        // the value where it is largest
  double found = 0;     // share of values below it
  double expected = 0;
  int tones = 0;  // bins that hold any value
};

Deviation largest_deviation(const Texture& texture, int channel, const SampleSpace& space, double shift, double scale) {
  std::vector<std::int64_t> bins(num_bins, 0);
  const ValueRange range = space.traits().range.value_or(histogram_of_unbounded);
  const double width = (range.hi - range.lo) / num_bins;
  for_each_value(texture, channel, [&](double v) {
    const double bin = std::floor(((v - shift) / scale - range.lo) / width);
    ++bins[static_cast<std::size_t>(std::clamp(bin, 0.0, num_bins - 1.0))];
  });
  const auto below = [&](double v) { return space.share_below(channel, std::clamp(v, range.lo, range.hi)); };
  const double slack = coding_slack * (range.hi - range.lo);
  const double n = static_cast<double>(texture.extents.num_cells());
  Deviation worst;
  std::int64_t count = 0;
  for (int bin = 0; bin < num_bins; ++bin) {
    const double edge = range.lo + bin * width;
    const double found = static_cast<double>(count) / n;
    const double distance = std::max(found - below(edge + slack), below(edge - slack) - found);
    if (distance > worst.distance) worst = {distance, shift + scale * edge, found, below(edge), worst.tones};
    worst.tones += bins[static_cast<std::size_t>(bin)] > 0 ? 1 : 0;
    count += bins[static_cast<std::size_t>(bin)];
  }
  return worst;
}

double bound_of(const Texture& texture) {
  return std::sqrt(std::log(2 * texture.channels / odds) / (2 * static_cast<double>(texture.extents.num_cells())));
}

Deviation deviation_of(const Texture& texture, int channel, const SampleSpace& space, const Moments& moments) {
  // An image holds numbers of an unbounded space as 0 to 1, over a range that nobody knows.
  const bool coded = !space.traits().range && moments.least >= 0 && moments.largest <= 1 && moments.deviation > 0;
  const Moments expected = coded ? moments_of(space, channel) : Moments{};
  const double scale = coded ? moments.deviation / expected.deviation : 1;
  return largest_deviation(texture, channel, space, coded ? moments.mean - scale * expected.mean : 0, scale);
}

}  // namespace

double distribution_distance(const Texture& texture, const SampleSpec& samples) {
  if (samples.is_file()) return 0;
  const std::shared_ptr<const SampleSpace> space = space_of(samples);
  double worst = 0;
  for (int c = 0; c < texture.channels; ++c)
    worst = std::max(worst, deviation_of(texture, c, *space, moments_of(texture, c)).distance);
  return worst / bound_of(texture);
}

std::string distribution_warning(const Texture& texture, const SampleSpec& samples) {
  if (samples.is_file()) return "";
  const std::shared_ptr<const SampleSpace> space = space_of(samples);
  const double bound = bound_of(texture);
  for (int c = 0; c < texture.channels; ++c) {
    const Moments moments = moments_of(texture, c);
    const Deviation worst = deviation_of(texture, c, *space, moments);
    if (worst.distance <= bound) continue;
    return fmt::format(
        "the values{} are not distributed as samples \"{}\" are: {:.3g} of them lie below {:.3g}, where {:.3g} belong; "
        "they reach from {:.3g} to {:.3g}{}. (gamma, contrast, another range? By chance: odds below one in a million.)",
        texture.channels > 1 ? fmt::format(" of channel {}", c) : "", samples.space, worst.found, worst.at,
        worst.expected, moments.least, moments.largest,
        worst.tones <= 16 ? fmt::format(", in {} tone{}", worst.tones, worst.tones == 1 ? "" : "s") : "");
  }
  return "";
}

}  // namespace noiseloom
