#include "noiseloom/image/sample_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "noiseloom/core/error.h"
#include "noiseloom/samples/space.h"

namespace noiseloom {
namespace {

constexpr double length_slack = 1e-3;   // as for the lists that generate is given
constexpr double largest_value = 1e18;  // distances are squared in float32

// What a sample of the space must be.
struct Rule {
  double least = -largest_value;  // of every value
  double most = largest_value;    // 1 itself, of [0, 1), comes from rounding
  bool unit_interval = false;
  bool unit_length = false;
  bool upper_half = false;  // z >= 0
  bool unit_disk = false;
  std::string text;  // "values in [0, 1)"
};

Support support_of(const SampleSpec& samples) {
  if (!samples.is_file()) return space_traits(samples).support;
  if (is_between_unit_vectors(samples.distance)) return Support::unit_vectors;
  return samples.distance == DistanceKind::circle ? Support::unit_interval : Support::line;
}

Rule rule_of(const SampleSpec& samples) {
  switch (support_of(samples)) {
    case Support::unit_interval:
      return {.least = 0, .most = 1, .unit_interval = true, .text = "values in [0, 1)"};
    case Support::signed_unit_interval:
      return {.least = -1, .most = 1, .text = "values in (-1, 1)"};
    case Support::half_line:
      return {.least = 0, .text = "values from 0 to 1e18"};
    case Support::unit_disk:
      return {.unit_disk = true, .text = "points within a distance of 1 from 0"};
    case Support::unit_vectors:
      return {.unit_length = true, .text = "unit vectors"};
    case Support::upper_unit_vectors:
      return {.unit_length = true, .upper_half = true, .text = "unit vectors with z >= 0"};
    case Support::line:
      break;
  }
  return {.text = "values within 1e18"};
}

double length_of(std::span<const float> sample) {
  double squares = 0;
  for (const float v : sample) squares += static_cast<double>(v) * static_cast<double>(v);
  return std::sqrt(squares);
}

// The farthest that rounding to `step` moves a point.
double rounding(double step, std::size_t channels) { return step / 2 * std::sqrt(static_cast<double>(channels)); }

bool obeys(const Rule& rule, std::span<const float> sample, double step) {
  for (const float v : sample) {
    if (!(static_cast<double>(v) >= rule.least && static_cast<double>(v) <= rule.most)) return false;
  }
  // Twice: some round to the nearest code where others take the floor.
  const double slack = length_slack + 2 * rounding(step, sample.size());
  if (rule.unit_length && std::fabs(length_of(sample) - 1) > slack) return false;
  if (rule.unit_disk && length_of(sample) > 1 + slack) return false;
  return !rule.upper_half || static_cast<double>(sample.back()) >= -slack;
}

// What numbers beyond [0, 1) are in other programs.
std::string guess(const SampleSpec& samples, double least, double largest) {
  constexpr double turn = 6.2831854;  // 2 pi as a float, and rounded up
  const bool circle = samples.space == "circle" || (samples.is_file() && samples.distance == DistanceKind::circle);
  if (circle && least >= 0 && largest > turn && largest <= 360) return "; degrees? divide them by 360";
  if (circle && least >= -180 && largest <= 180 && largest > turn) return "; degrees? divide them by 360 and add 0.5";
  if (circle && least >= 0 && largest <= turn) return "; radians? divide them by 2 pi";
  if (circle && least >= -turn / 2 && largest <= turn / 2 && largest > 1)
    return "; radians? divide them by 2 pi and add 0.5";
  if (least >= -1 && least < 0 && largest <= 1) return "; -1 to 1? halve them and add 0.5";
  if (least >= 0 && largest > 2 && largest <= 255) return "; codes of 8 bits? store them as such (uint8)";
  if (least >= 0 && largest > 255 && largest <= 65535) return "; codes of 16 bits? store them as such (uint16)";
  return "";
}

struct Outside {
  std::int64_t count = 0;
  std::size_t first = 0;  // index of its first value
  std::vector<float> first_sample;
};

Outside outside_of(const Rule& rule, const Texture& texture, double step) {
  const std::size_t cells = static_cast<std::size_t>(texture.extents.cells_per_slice());
  const std::size_t channels = static_cast<std::size_t>(texture.channels);
  std::vector<float> sample(channels);
  Outside outside;
  for (const SliceIndex s : texture.extents.slices()) {
    const float* const slice = texture.slice(s);
    for (std::size_t cell = 0; cell < cells; ++cell) {
      for (std::size_t c = 0; c < channels; ++c) sample[c] = slice[c * cells + cell];
      if (obeys(rule, sample, step)) continue;
      if (++outside.count > 1) continue;
      outside.first = static_cast<std::size_t>(s) * channels * cells + cell;
      outside.first_sample = sample;
    }
  }
  return outside;
}

}  // namespace

std::int64_t count_outside(const Texture& texture, const SampleSpec& samples, double step) {
  return outside_of(rule_of(samples), texture, step).count;
}

std::string support_text(const SampleSpec& samples) { return rule_of(samples).text; }

void check_in_space(const Texture& texture, const SampleSpec& samples, double step, const std::string& name) {
  const Rule rule = rule_of(samples);
  const auto [count, first, first_sample] = outside_of(rule, texture, step);
  if (count == 0) return;
  std::string found;
  for (const float v : first_sample) found += fmt::format("{}{}", found.empty() ? "" : ", ", v);
  if (rule.unit_length || rule.unit_disk) found += fmt::format(" of length {:.6g}", length_of(first_sample));
  const auto [least, largest] = std::minmax_element(texture.values.begin(), texture.values.end());
  throw UserError(
      name, fmt::format(
                "the sample at {} is {}, but samples \"{}\" are {}; {} of {} lie outside, values are from {} to "
                "{}{}",
                place_of(texture, first).substr(0, place_of(texture, first).find(", channel")), found, samples.space,
                rule.text, count, texture.extents.num_cells(), *least, *largest,
                rule.unit_interval ? guess(samples, static_cast<double>(*least), static_cast<double>(*largest)) : ""));
}

bool may_be_sample(const SampleSpec& samples, std::span<const float> sample) {
  constexpr double smallest = 1e-18;           // of numbers that are not zero: what is not a float seldom lies near 1
  constexpr double largest_of_unbounded = 50;  // of the built-in spaces
  const bool unbounded = !samples.is_file() && !space_traits(samples).range;
  for (const float v : sample) {
    const double size = std::fabs(static_cast<double>(v));
    if (!(size == 0 || (size > smallest && size < largest_value))) return false;
    if (unbounded && size > largest_of_unbounded) return false;
  }
  const Rule rule = rule_of(samples);
  if (obeys(rule, sample, 0)) return true;
  if (!rule.unit_length && !rule.unit_disk) return false;
  std::vector<float> decoded(sample.size());
  std::transform(sample.begin(), sample.end(), decoded.begin(), [](float u) { return 2 * u - 1; });
  return std::all_of(sample.begin(), sample.end(), [](float u) { return u >= 0 && u <= 1; }) && obeys(rule, decoded, 0);
}

}  // namespace noiseloom
