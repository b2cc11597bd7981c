#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "measure/verify_parts.h"
#include "noiseloom/image/encoding.h"
#include "noiseloom/image/sample_check.h"
#include "noiseloom/measure/distribution.h"
#include "noiseloom/samples/sample_space.h"

namespace noiseloom::verify {
namespace {

std::size_t cells_of(const Texture& texture) { return static_cast<std::size_t>(texture.extents.cells_per_slice()); }

// What people do to pictures, undone: the name of what was done, and the number it was done to.
struct Bend {
  const char* name;
  double (*undone)(double);
};
double linear_of_srgb(double v) { return v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4); }
double srgb_of_linear(double v) { return v <= 0.0031308 ? 12.92 * v : 1.055 * std::pow(v, 1 / 2.4) - 0.055; }
constexpr Bend bends[] = {
    {"encoded as sRGB, or raised to about 1/2.2", linear_of_srgb},
    {"decoded from sRGB, or raised to about 2.2", srgb_of_linear},
};

// The samples as numbers of 0 to 1 were bent, or stretched between the least and the largest.
std::string cause_of(const Subject& subject, double distance) {
  const ValueRange range = natural_range(subject.samples).value_or(ValueRange{});
  std::string cause;
  double best = distance / 4;  // what repairs little is no cause
  const auto consider = [&](const std::string& name, const auto& undone) {
    Texture texture = subject.texture;
    for (float& v : texture.values)
      v = static_cast<float>(from_unit(range, undone(std::clamp(to_unit(range, static_cast<double>(v)), 0.0, 1.0))));
    const double left = distribution_distance(texture, subject.samples);
    if (left >= best) return;
    best = left;
    cause = name;
  };
  for (const Bend& bend : bends) consider(std::string("the values were ") + bend.name, bend.undone);
  const auto [least, largest] = std::minmax_element(subject.texture.values.begin(), subject.texture.values.end());
  const double lo = to_unit(range, static_cast<double>(*least));
  const double hi = to_unit(range, static_cast<double>(*largest));
  if (hi > lo)
    consider(fmt::format("the contrast was changed: 0 to 1 became {:.3g} to {:.3g}", lo, hi),
             [lo, hi](double v) { return (v - lo) / (hi - lo); });
  return cause;
}

// Where few slices alone are unlike, these are named; else the whole is.
void check_distribution(const Subject& subject, Verification& found) {
  std::vector<SliceIndex> unlike;
  const std::int32_t slices = subject.texture.extents.num_slices();
  for (const SliceIndex s : first_indices<SliceIndex>(slices > 1 && !ends_along_slices(subject) ? slices : 0))
    if (distribution_distance(slice_of(subject.texture, s), subject.samples) > 1) unlike.push_back(s);
  const std::string warning = distribution_warning(subject.texture, subject.samples);
  if (!unlike.empty() && 2 * unlike.size() <= static_cast<std::size_t>(slices)) {
    found.findings.push_back(
        {"slice-distribution", true,
         fmt::format("the histogram of slice{} {} is not that of samples \"{}\", though that of most others is "
                     "(by chance: odds below one in a million a slice)",
                     unlike.size() == 1 ? "" : "s", list_text(unlike), subject.samples.space)});
  } else if (!warning.empty()) {
    const std::string cause = cause_of(subject, distribution_distance(subject.texture, subject.samples));
    found.findings.push_back(
        {cause.empty() ? "distribution" : "gamma", true, (cause.empty() ? "" : cause + "; ") + warning});
  }
}

void check_support(const Subject& subject, Verification& found) {
  const std::int64_t outside = count_outside(subject.texture, subject.samples, subject.step);
  if (outside == 0) return;
  const double share = static_cast<double>(outside) / static_cast<double>(subject.texture.extents.num_cells());
  const std::string words = support_text(subject.samples);
  found.findings.push_back({words.find("unit vectors") != std::string::npos ? "unit-length" : "support", true,
                            fmt::format("{} of {} samples ({:.3g} %) are not {}", outside,
                                        subject.texture.extents.num_cells(), 100 * share, words)});
}

LevelCounts count_levels(const Subject& subject, std::size_t channel) {
  LevelCounts counts;
  const Texture& stored = subject.stored.texture;
  counts.bits = static_cast<int>(std::lround(-std::log2(subject.stored.step)));
  const auto levels = static_cast<std::size_t>(1) << counts.bits;
  std::vector<std::int64_t> all(levels, 0);
  std::vector<std::int64_t> one(levels);
  const std::size_t cells = cells_of(stored);
  counts.least_in_a_slice = stored.extents.num_cells();
  for (const SliceIndex s : stored.extents.slices()) {
    std::fill(one.begin(), one.end(), 0);
    const float* const plane = stored.slice(s) + channel * cells;
    for (std::size_t i = 0; i < cells; ++i)
      ++one[std::min(levels - 1, static_cast<std::size_t>(
                                     std::max(0.0, static_cast<double>(plane[i]) * static_cast<double>(levels))))];
    const auto [least, most] = std::minmax_element(one.begin(), one.end());
    counts.least_in_a_slice = std::min(counts.least_in_a_slice, *least);
    counts.most_in_a_slice = std::max(counts.most_in_a_slice, *most);
    for (std::size_t l = 0; l < levels; ++l) all[l] += one[l];
  }
  const auto [least, most] = std::minmax_element(all.begin(), all.end());
  counts.least_in_all = *least;
  counts.most_in_all = *most;
  counts.levels_used = static_cast<std::int64_t>(levels) - std::count(all.begin(), all.end(), 0);
  return counts;
}

// Fewer levels than even white noise would use: numbers of 8 bits stored as 16, two tones.
void check_levels(const Subject& subject, Verification& found) {
  if (!subject.stored.codes || subject.stored.step < 1.0 / 65536) return;
  for (const std::size_t channel : subject.channels) found.levels.push_back(count_levels(subject, channel));
  const bool even = !subject.samples.is_file() && space_traits(subject.samples).has_constant_density &&
                    natural_range(subject.samples) == ValueRange{};
  const auto cells = static_cast<double>(subject.texture.extents.num_cells());
  for (std::size_t c = 0; c < found.levels.size() && even; ++c) {
    const LevelCounts& counts = found.levels[c];
    const double levels = std::exp2(counts.bits);
    const double expected = levels * (1 - std::exp(-cells / levels));
    // White noise comes that low with odds far below one in a million wherever there are a few dozen levels.
    if (static_cast<double>(counts.levels_used) >= expected / 2) continue;
    found.findings.push_back(
        {"levels", true,
         fmt::format("channel {} has {} of the {} levels of {} bits", subject.stored.channel_names[subject.channels[c]],
                     counts.levels_used, static_cast<std::int64_t>(levels), counts.bits)});
  }
}

// Colours that are nowhere above alpha were multiplied by it; alpha that equals a colour was made from it.
void check_alpha(const Subject& subject, Verification& found) {
  const Texture& stored = subject.stored.texture;
  const std::vector<std::string>& names = subject.stored.channel_names;
  const auto alpha = static_cast<std::size_t>(std::find(names.begin(), names.end(), "A") - names.begin());
  if (alpha == names.size() || alpha == 0) return;
  const std::size_t cells = cells_of(stored);
  std::vector<bool> equal(alpha, true);
  bool below = true;
  bool varies = false;
  double room = 0;  // mean of alpha: what colours of their own would exceed as often
  for (const SliceIndex s : stored.extents.slices()) {
    const float* const a = stored.slice(s) + alpha * cells;
    for (std::size_t i = 0; i < cells; ++i) {
      varies = varies || a[i] != a[0];
      room += static_cast<double>(a[i]);
      for (std::size_t c = 0; c < alpha; ++c) {
        const float colour = stored.slice(s)[c * cells + i];
        equal[c] = equal[c] && colour == a[i];
        below = below && colour <= a[i];
      }
    }
  }
  if (!varies) return;
  for (std::size_t c = 0; c < alpha; ++c)
    if (equal[c]) {
      found.findings.push_back({"alpha", true, fmt::format("alpha is a copy of channel {}", names[c])});
      return;
    }
  room /= static_cast<double>(stored.extents.num_cells());
  // Numbers that know nothing of alpha all stay below it with odds of `room` each.
  if (below && static_cast<double>(stored.extents.num_cells()) * std::log(room) < std::log(odds))
    found.findings.push_back({"alpha", true, "no colour exceeds alpha anywhere: colours were multiplied by alpha"});
}

}  // namespace

Texture slice_of(const Texture& texture, SliceIndex slice) {
  Texture one{Extents({texture.extents.width(), texture.extents.height()}), texture.channels, {}};
  one.values.assign(texture.slice(slice), texture.slice(slice) + texture.floats_per_slice());
  return one;
}

bool ends_along(const Subject& subject, int axis) {
  if (!subject.stored.config) return false;
  const std::vector<int>& bounded = subject.stored.config->order.bounded;
  return std::find(bounded.begin(), bounded.end(), axis) != bounded.end();
}

bool ends_along_slices(const Subject& subject) {
  for (int axis = 2; axis < subject.texture.extents.num_axes(); ++axis)
    if (ends_along(subject, axis)) return true;
  return false;
}

std::string list_text(const std::vector<SliceIndex>& numbers) {
  constexpr std::size_t most = 6;
  std::string text;
  for (std::size_t i = 0; i < std::min(numbers.size(), most); ++i)
    text += fmt::format("{}{}", i == 0 ? "" : i + 1 == numbers.size() ? " and " : ", ", numbers[i].value());
  return numbers.size() > most ? fmt::format("{} and {} more", text, numbers.size() - most) : text;
}

void check_values(const Subject& subject, Verification& found) {
  if (subject.stored.is_srgb)
    found.findings.push_back({"srgb", true, "the file is marked as sRGB: a sampler will bend every value"});
  check_support(subject, found);
  check_distribution(subject, found);
  check_levels(subject, found);
  check_alpha(subject, found);
}

}  // namespace noiseloom::verify
