#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "measure/verify_parts.h"
#include "noiseloom/files/digest.h"

namespace noiseloom::verify {
namespace {

std::size_t size_of(std::int64_t n) { return static_cast<std::size_t>(n); }

// The digest of a slice, its columns and rows taken backwards where asked.
std::uint64_t digest(const Texture& texture, SliceIndex slice, bool flip_x, bool flip_y) {
  const std::size_t width = size_of(texture.extents.width());
  const std::size_t height = size_of(texture.extents.height());
  std::vector<float> values(texture.slice(slice), texture.slice(slice) + texture.floats_per_slice());
  for (std::size_t c = 0; c < size_of(texture.channels); ++c) {
    const auto plane = values.begin() + static_cast<std::ptrdiff_t>(c * width * height);
    for (std::size_t y = 0; y < height && flip_x; ++y)
      std::reverse(plane + static_cast<std::ptrdiff_t>(y * width),
                   plane + static_cast<std::ptrdiff_t>((y + 1) * width));
    for (std::size_t y = 0; y < height / 2 && flip_y; ++y)
      std::swap_ranges(plane + static_cast<std::ptrdiff_t>(y * width),
                       plane + static_cast<std::ptrdiff_t>((y + 1) * width),
                       plane + static_cast<std::ptrdiff_t>((height - 1 - y) * width));
  }
  return digest_of(std::as_bytes(std::span(values)));
}

// Slices of some thousands of values are never equal by chance.
void check_repeats(const Subject& subject, Verification& found) {
  const Texture& texture = subject.texture;
  std::map<std::uint64_t, SliceIndex> seen;
  std::vector<SliceIndex> repeated;
  std::vector<SliceIndex> mirrored;
  std::string first_repeat;
  std::string first_mirror;
  for (const SliceIndex s : texture.extents.slices()) {
    const std::uint64_t own = digest(texture, s, false, false);
    if (const auto earlier = seen.find(own); earlier != seen.end()) {
      if (repeated.empty())
        first_repeat = fmt::format("slice {} is slice {} again", s.value(), earlier->second.value());
      repeated.push_back(s);
      continue;
    }
    for (const auto& [flip_x, flip_y] : {std::pair(true, false), std::pair(false, true), std::pair(true, true)}) {
      const auto earlier = seen.find(digest(texture, s, flip_x, flip_y));
      if (earlier == seen.end()) continue;
      if (mirrored.empty())
        first_mirror = fmt::format("slice {} is slice {} mirrored", s.value(), earlier->second.value());
      mirrored.push_back(s);
    }
    seen.emplace(own, s);
  }
  if (!repeated.empty())
    found.findings.push_back({"repeated-slices", true,
                              fmt::format("{}; {} of {} slices repeat others: {}", first_repeat, repeated.size(),
                                          texture.extents.num_slices(), list_text(repeated))});
  if (!mirrored.empty())
    found.findings.push_back(
        {"mirrored-slices", true, fmt::format("{}; in all: {}", first_mirror, list_text(mirrored))});
}

// Correlation of pairs of values.
class Correlation {
 public:
  void add(double a, double b) {
    ++n_;
    a_ += a;
    b_ += b;
    ab_ += a * b;
    aa_ += a * a;
    bb_ += b * b;
  }
  double value() const {
    const double variance = (aa_ - a_ * a_ / n_) * (bb_ - b_ * b_ / n_);
    return variance > 0 ? (ab_ - a_ * b_ / n_) / std::sqrt(variance) : 0;
  }

 private:
  double n_ = 0, a_ = 0, b_ = 0, ab_ = 0, aa_ = 0, bb_ = 0;
};

double slices_correlation(const Texture& texture, SliceIndex a, SliceIndex b) {
  const std::size_t cells = size_of(texture.extents.cells_per_slice());
  double sum = 0;
  for (std::size_t c = 0; c < size_of(texture.channels); ++c) {
    Correlation channel;
    for (std::size_t i = 0; i < cells; ++i)
      channel.add(static_cast<double>(texture.slice(a)[c * cells + i]),
                  static_cast<double>(texture.slice(b)[c * cells + i]));
    sum += channel.value();
  }
  return sum / texture.channels;
}

// Which values stand out of their company: farther from the median than `least` and than nine times what the median
// deviation tells of normal numbers (of which one in 10^18 is).
std::vector<std::size_t> outliers(const std::vector<double>& values, double least) {
  const double middle = median_of(values);
  std::vector<double> deviations;
  for (const double v : values) deviations.push_back(std::abs(v - middle));
  const double bound = std::max(least, 9 * 1.4826 * median_of(deviations));
  std::vector<std::size_t> far;
  for (std::size_t i = 0; i < values.size(); ++i)
    if (std::abs(values[i] - middle) > bound) far.push_back(i);
  return far;
}

// Where neighbours in time push each other off, they do so everywhere: a pair that does not was no pair when the
// texture was made.
void check_order(const Subject& subject, Verification& found) {
  const Texture& texture = subject.texture;
  const std::int32_t slices = texture.extents.num_slices();
  constexpr std::int32_t fewest = 8;
  if (texture.extents.num_axes() != 3 || slices < fewest) return;
  std::vector<double> pairs;
  for (const SliceIndex s : texture.extents.slices())
    pairs.push_back(slices_correlation(texture, s, texture.extents.slice_at(s, {1})));
  // A correlation of n random pairs has the deviation 1 / sqrt(n).
  const double chance = 1 / std::sqrt(static_cast<double>(texture.extents.cells_per_slice()) * texture.channels);
  constexpr double certain = 6;
  if (std::abs(median_of(pairs)) < 2 * certain * chance) return;
  std::vector<SliceIndex> breaks;
  for (const std::size_t pair : outliers(pairs, certain * chance)) breaks.emplace_back(pair);
  const bool ends = !breaks.empty() && breaks.back() == SliceIndex(slices - 1);
  if (ends) breaks.pop_back();
  if (ends && breaks.empty()) {
    found.findings.push_back(
        {"slice-loop", true,
         fmt::format("the last slice and the first do not fit each other as all other neighbours do "
                     "(correlation {:.3f}, others {:.3f}): slices are missing at an end, or the texture "
                     "was not made to repeat",
                     pairs.back(), median_of(pairs))});
  }
  if (breaks.empty()) return;
  found.findings.push_back(
      {"slice-order", true,
       fmt::format(
           "the series of slices breaks after slice{} {} (correlation with the next {:.3f}, others {:.3f}): slices "
           "are missing, swapped or changed there",
           breaks.size() == 1 ? "" : "s", list_text(breaks), pairs[size_of(breaks.front().value())],
           median_of(pairs))});
}

// What the correlation of values does not show.
void check_gaps(const Subject& subject, Verification& found) {
  std::vector<SliceIndex> gaps = gaps_behind(subject.texture);
  if (gaps.empty()) return;
  const SliceIndex last(subject.texture.extents.num_slices() - 1);
  const bool at_end = gaps.back() == last;
  if (at_end) gaps.pop_back();
  if (at_end && gaps.empty()) {
    found.findings.push_back({"slice-loop", true,
                              "the spectra of the last slices and the first are related as those of slices further "
                              "apart are elsewhere: slices are missing at an end"});
    return;
  }
  found.findings.push_back({"slice-order", true,
                            fmt::format("slices are missing after slice{} {}: the spectra on its two sides are "
                                        "related as those of slices further apart are elsewhere",
                                        gaps.size() == 1 ? "" : "s", list_text(gaps))});
}

// A filter over x and y whose error is looked at along borders: the middle tap, and those on one side of it.
struct BorderFilter {
  const char* name;
  std::vector<double> taps;
};

// What textures of single slices are made for leaves little of them inside, and all of them where they were cut.
const std::vector<BorderFilter>& border_filters() {
  static const std::vector<BorderFilter> filters = {{"Gauss of sigma 1", {0.39905, 0.24204, 0.05401, 0.00443}},
                                                    {"box of 3", {1.0 / 3, 1.0 / 3}},
                                                    {"box of 5", {0.2, 0.2, 0.2}},
                                                    {"box of 7", {1.0 / 7, 1.0 / 7, 1.0 / 7, 1.0 / 7}}};
  return filters;
}

// Lines of a plane after another as the filter leaves them, around the edges, along x and then along y.
std::vector<double> filtered(const float* plane, std::size_t width, std::size_t height,
                             const std::vector<double>& half) {
  std::vector<double> values(plane, plane + width * height);
  double mean = 0;
  for (const double v : values) mean += v / static_cast<double>(values.size());
  for (double& v : values) v -= mean;
  const auto pass = [&](std::size_t lines, std::size_t line_step, std::size_t size, std::size_t step) {
    std::vector<double> line(size);
    for (std::size_t l = 0; l < lines; ++l) {
      double* const first = values.data() + l * line_step;
      for (std::size_t i = 0; i < size; ++i) {
        line[i] = half[0] * first[i * step];
        for (std::size_t d = 1; d < half.size(); ++d)
          line[i] += half[d] * (first[(i + d) % size * step] + first[(i + size - d) % size * step]);
      }
      for (std::size_t i = 0; i < size; ++i) first[i * step] = line[i];
    }
  };
  pass(height, width, width, 1);
  pass(width, 1, height, width);
  return values;
}

// What the filter leaves, squared, beside each line between two columns (or rows), the last one between the edges.
std::vector<double> error_beside_lines(const Texture& texture, const BorderFilter& filter, bool columns) {
  const std::size_t width = size_of(texture.extents.width());
  const std::size_t height = size_of(texture.extents.height());
  const std::size_t lines = columns ? width : height;
  std::vector<double> squares(lines, 0);
  const std::size_t planes = size_of(texture.extents.num_slices()) * size_of(texture.channels);
  for (std::size_t p = 0; p < planes; ++p) {
    const std::vector<double> left = filtered(texture.values.data() + p * width * height, width, height, filter.taps);
    for (std::size_t i = 0; i < left.size(); ++i) squares[columns ? i % width : i / width] += left[i] * left[i];
  }
  std::vector<double> beside(lines);
  for (std::size_t l = 0; l < lines; ++l) beside[l] = squares[l] + squares[(l + 1) % lines];
  return beside;
}

// A texture that tiles has the same error at its edges as inside. One that does not has several times as much there:
// so many times; 1 where it tiles, or nothing can be told.
double error_of_border(const std::vector<double>& errors) {
  constexpr std::size_t fewest = 16;
  if (errors.size() < fewest) return 1;
  const double inside = median_of(errors);
  const std::vector<std::size_t> far = outliers(errors, inside / 4);
  if (errors.back() < inside || far.empty() || far.back() + 1 != errors.size()) return 1;
  constexpr std::size_t reach = 4;  // of the filter: what lies nearer to the edges may be far, too
  const auto inner =
      std::count_if(far.begin(), far.end(), [&](std::size_t l) { return l >= reach && l + reach + 1 < errors.size(); });
  return inner > 1 ? 1 : errors.back() / inside;  // else it is uneven everywhere
}

void check_border(const Subject& subject, bool columns, Verification& found) {
  double most = 1;
  std::string by;
  for (const BorderFilter& filter : border_filters()) {
    const double times = error_of_border(error_beside_lines(subject.texture, filter, columns));
    if (times <= most) continue;
    most = times;
    by = filter.name;
  }
  if (by.empty()) return;
  found.findings.push_back({"border", true,
                            fmt::format("at the {} edges a {} leaves {:.1f} times the error that it leaves inside: the "
                                        "texture does not tile",
                                        columns ? "left and right" : "upper and lower", by, most)});
}

// The same numbers again half a slice (a third, ...) on, all of them.
bool repeats_at(const Texture& texture, std::size_t dx, std::size_t dy) {
  const std::size_t width = size_of(texture.extents.width());
  const std::size_t height = size_of(texture.extents.height());
  const float* const plane = texture.slice(SliceIndex(0));
  for (std::size_t y = 0; y < height; ++y)
    for (std::size_t x = 0; x < width; ++x)
      if (plane[y * width + x] != plane[(y + dy) % height * width + (x + dx) % width]) return false;
  return true;
}

}  // namespace

double median_of(std::vector<double> values) {
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2), values.end());
  return values[values.size() / 2];
}

void check_slices(const Subject& subject, Verification& found) {
  const std::size_t before = found.findings.size();
  check_repeats(subject, found);
  // Slices near the ends of a series that was made to end differ from the others by right.
  if (ends_along_slices(subject)) return;
  check_order(subject, found);
  if (found.findings.size() == before) check_gaps(subject, found);
}

void check_edges(const Subject& subject, Verification& found) {
  const Extents& extents = subject.texture.extents;
  for (const bool along_x : {true, false}) {
    const std::int64_t size = along_x ? extents.width() : extents.height();
    for (std::int64_t parts = 2; parts <= size / 2; ++parts) {
      if (size % parts != 0) continue;
      const std::size_t shift = size_of(size / parts);
      if (!repeats_at(subject.texture, along_x ? shift : 0, along_x ? 0 : shift)) continue;
      found.findings.push_back(
          {"repeats-inside", true,
           fmt::format("a slice is {} times the same {} pixels along {}", parts, shift, along_x ? "x" : "y")});
      break;
    }
  }
  if (!ends_along(subject, 0)) check_border(subject, true, found);
  if (!ends_along(subject, 1)) check_border(subject, false, found);
}

}  // namespace noiseloom::verify
