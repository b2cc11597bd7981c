#include "problem/sample_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <span>

#include "noiseloom/core/npy.h"
#include "problem/strata.h"

namespace noiseloom {
namespace {

using Shape = std::vector<std::int64_t>;

// What the file's dimensions mean.
struct Layout {
  bool shared;
  std::int64_t channels;
};

Layout layout_of(const Shape& shape, std::int64_t n, std::int64_t slices, const std::string& path) {
  const auto fits = [](std::int64_t channels) { return channels >= 1 && channels <= std::int64_t{max_dimensions}; };
  const bool vectors = shape.size() == 2 && shape[0] == n && fits(shape[1]);
  const bool scalars_per_slice = shape.size() == 2 && shape[0] == slices && shape[1] == n;
  if (vectors && scalars_per_slice) {
    throw UserError(path,
                    fmt::format("shape {}: could be {} samples of {} channels or {} slices of {} samples; give it "
                                "three dimensions (slices, samples, channels)",
                                npy_shape_text(shape), n, shape[1], slices, n));
  }
  if (shape == Shape{n}) return {true, 1};
  if (vectors) return {true, shape[1]};
  if (scalars_per_slice) return {false, 1};
  if (shape.size() == 3 && shape[0] == slices && shape[1] == n && fits(shape[2])) return {false, shape[2]};
  throw UserError(path,
                  fmt::format("shape {}: the texture has {} slices of {} cells; accepted: ({},), ({}, C), ({}, {}) "
                              "or ({}, {}, C) with C from 1 to {}",
                              npy_shape_text(shape), slices, n, n, n, slices, n, slices, n, max_dimensions));
}

// Collects faults, naming the first few.
class Faults {
 public:
  Faults(const std::string& path, const Layout& layout, std::int64_t n) : path_(path), layout_(layout), n_(n) {}

  // `index` counts samples over the whole file; channel < 0, or the only one, is not named.
  void add(std::int64_t index, std::int64_t channel, const std::string& text) {
    if (++count_ > most_) return;
    const std::string slice = layout_.shared ? "" : fmt::format("slice {}, ", index / n_);
    const std::string place = channel < 0 || layout_.channels == 1 ? "" : fmt::format(", channel {}", channel);
    faults_.push_back({path_, fmt::format("{}sample {}{} {}", slice, index % n_, place, text)});
  }
  void finish() {
    if (count_ > most_) faults_.push_back({path_, fmt::format("and {} more", count_ - most_)});
    throw_if_any(std::move(faults_));
  }

 private:
  static constexpr std::int64_t most_ = 5;
  std::string path_;
  Layout layout_;
  std::int64_t n_;
  std::int64_t count_ = 0;
  std::vector<Fault> faults_;
};

void check_distance(DistanceKind distance, std::int64_t channels, const std::string& path) {
  if (channels > 1 && distance == DistanceKind::absolute) {
    throw UserError(path, fmt::format("{} channels, but the distance \"absolute\" is for 1", channels));
  }
  if (channels > 1 && distance == DistanceKind::circle) {
    throw UserError(path, fmt::format("{} channels, but the distance \"circle\" is for 1", channels));
  }
  if (channels < 2 && distance == DistanceKind::angle) {
    throw UserError(path, "1 channel, but the distance \"angle\" is for 2 and more");
  }
}

std::vector<float> checked_values(const std::vector<double>& values, const Layout& layout, DistanceKind distance,
                                  std::int64_t n, const std::string& path) {
  Faults faults(path, layout, n);
  std::vector<float> result(values.size());
  const std::size_t channels = static_cast<std::size_t>(layout.channels);
  for (std::size_t first = 0; first < values.size(); first += channels) {
    const std::int64_t index = static_cast<std::int64_t>(first / channels);
    double square = 0;
    for (std::size_t c = 0; c < channels; ++c) {
      const float value = static_cast<float>(values[first + c]);
      result[first + c] = value;
      square += static_cast<double>(value) * static_cast<double>(value);
      if (!std::isfinite(value)) {
        const char* reason = std::isfinite(values[first + c]) ? "does not fit float32" : "samples must be finite";
        faults.add(index, static_cast<std::int64_t>(c), fmt::format("= {}: {}", values[first + c], reason));
      } else if (distance == DistanceKind::circle && !(value >= 0 && value < 1)) {
        faults.add(index, static_cast<std::int64_t>(c), fmt::format("= {}: must lie in [0, 1) on the circle", value));
      }
    }
    if (distance == DistanceKind::angle && std::isfinite(square) && std::fabs(std::sqrt(square) - 1) > 1e-3) {
      faults.add(index, -1, fmt::format("has length {:.6g}: the distance \"angle\" needs length 1", std::sqrt(square)));
    }
  }
  faults.finish();
  return result;
}

// Orders `ids` of points in `channels` dimensions: halves at the median of the widest channel, recursively. Ties go by
// id, so the order is one only.
void order_by_medians(const float* points, std::size_t channels, std::span<std::uint32_t> ids) {
  if (ids.size() < 2) return;
  std::size_t widest = 0;
  double width = -1;
  for (std::size_t c = 0; c < channels; ++c) {
    float low = points[ids[0] * channels + c];
    float high = low;
    for (const std::uint32_t id : ids) {
      low = std::min(low, points[id * channels + c]);
      high = std::max(high, points[id * channels + c]);
    }
    const double extent = static_cast<double>(high) - static_cast<double>(low);
    if (extent > width) {
      widest = c;
      width = extent;
    }
  }
  const auto middle = static_cast<std::ptrdiff_t>(ids.size() / 2);
  std::nth_element(ids.begin(), ids.begin() + middle, ids.end(), [&](std::uint32_t a, std::uint32_t b) {
    const float x = points[a * channels + widest];
    const float y = points[b * channels + widest];
    return x < y || (x == y && a < b);
  });
  order_by_medians(points, channels, ids.first(ids.size() / 2));
  order_by_medians(points, channels, ids.subspan(ids.size() / 2));
}

std::vector<float> in_order(std::span<const float> samples, std::size_t channels) {
  std::vector<float> ordered(samples.begin(), samples.end());
  if (channels == 1) {
    std::stable_sort(ordered.begin(), ordered.end());
    return ordered;
  }
  std::vector<std::uint32_t> ids(samples.size() / channels);
  std::iota(ids.begin(), ids.end(), 0U);
  order_by_medians(samples.data(), channels, ids);
  float* out = ordered.data();
  for (const std::uint32_t id : ids) out = std::copy_n(samples.data() + id * channels, channels, out);
  return ordered;
}

}  // namespace

SampleFile::SampleFile(const std::string& path, DistanceKind distance, std::int64_t cells_per_slice,
                       SliceIndex num_slices)
    : cells_(static_cast<std::size_t>(cells_per_slice)) {
  NpyArray array = read_npy(path);
  const Layout layout = layout_of(array.shape, cells_per_slice, num_slices, path);
  check_distance(distance, layout.channels, path);
  channels_ = static_cast<std::size_t>(layout.channels);
  shared_ = layout.shared;
  values_ = checked_values(array.values, layout, distance, cells_per_slice, path);
  if (shared_) values_ = in_order(values_, channels_);
}

std::vector<float> SampleFile::list(SliceIndex slice) const {
  if (shared_) return values_;
  const std::size_t count = cells_ * channels_;
  return in_order(std::span(values_).subspan(static_cast<std::size_t>(slice) * count, count), channels_);
}

}  // namespace noiseloom
