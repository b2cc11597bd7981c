#include "samples/sample_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <functional>
#include <limits>
#include <numeric>
#include <span>

#include "noiseloom/files/npy.h"
#include "samples/strata.h"

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
  // A whole texture: [slice axes..., y, x] or [slice axes..., y, x, channel].
  const auto is_texture = [&](std::size_t dimensions) {
    if (shape.size() < dimensions) return false;
    const auto plane = shape.begin() + static_cast<std::ptrdiff_t>(shape.size() - dimensions);
    const auto product = [](auto begin, auto end) {
      return std::accumulate(begin, end, std::int64_t{1}, std::multiplies<>());
    };
    return product(shape.begin(), plane) == slices && product(plane, plane + 2) == n;
  };
  const bool as_scalars = is_texture(2);
  const bool as_vectors = is_texture(3) && fits(shape.back());
  if (as_scalars || as_vectors) return {slices == 1, as_scalars ? 1 : shape.back()};
  throw UserError(path,
                  fmt::format("shape {}: the texture has {} slices of {} cells; accepted: ({},), ({}, C), ({}, {}) "
                              "or ({}, {}, C) with C from 1 to {}, or those of the texture itself, (..., y, x) or "
                              "(..., y, x, C)",
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

const char* name_of(DistanceKind kind) {
  return kind == DistanceKind::axis ? "axis" : kind == DistanceKind::cosine ? "cosine" : "angle";
}

void check_distance(DistanceKind distance, std::int64_t channels, const std::string& path) {
  if (channels > 1 && distance == DistanceKind::absolute) {
    throw UserError(path, fmt::format("{} channels, but the distance \"absolute\" is for 1", channels));
  }
  if (channels > 1 && distance == DistanceKind::circle) {
    throw UserError(path, fmt::format("{} channels, but the distance \"circle\" is for 1", channels));
  }
  if (!is_between_unit_vectors(distance)) return;
  const int least = distance == DistanceKind::axis ? 3 : 2;  // axes of the plane are a circle
  if (channels >= least && channels <= 4) return;
  throw UserError(path, fmt::format("{} channel{}, but the distance \"{}\" is for {} to 4", channels,
                                    channels == 1 ? "" : "s", name_of(distance), least));
}

// Distances between points are squared in float32, those between scalars added up.
constexpr double largest_coordinate = 1e18;
constexpr double smallest_extent = 1e-18;

void check_values(std::span<const float> values, const Layout& layout, DistanceKind distance, std::int64_t n,
                  const std::string& path) {
  Faults faults(path, layout, n);
  const std::size_t channels = static_cast<std::size_t>(layout.channels);
  float largest = 0;
  for (std::size_t first = 0; first < values.size(); first += channels) {
    const std::int64_t index = static_cast<std::int64_t>(first / channels);
    double square = 0;
    for (std::size_t c = 0; c < channels; ++c) {
      const float value = values[first + c];
      largest = std::max(largest, std::fabs(value));
      square += static_cast<double>(value) * static_cast<double>(value);
      if (!std::isfinite(value)) {
        faults.add(index, static_cast<std::int64_t>(c), fmt::format("= {}: samples must be finite", value));
      } else if (value != 0 && std::fabs(value) < std::numeric_limits<float>::min()) {
        faults.add(index, static_cast<std::int64_t>(c),
                   fmt::format("= {}: a denormal of float32; scale the samples, or make it 0", double{value}));
      } else if (std::fabs(value) > largest_coordinate) {
        faults.add(
            index, static_cast<std::int64_t>(c),
            fmt::format("= {}: must lie within 1e18, as distances are squared or added up in float32", double{value}));
      } else if (distance == DistanceKind::circle && !(value >= 0 && value < 1)) {
        faults.add(index, static_cast<std::int64_t>(c), fmt::format("= {}: must lie in [0, 1) on the circle", value));
      }
    }
    if (is_between_unit_vectors(distance) && std::isfinite(square) && std::fabs(std::sqrt(square) - 1) > 1e-3) {
      faults.add(
          index, -1,
          fmt::format("has length {:.6g}: the distance \"{}\" needs length 1", std::sqrt(square), name_of(distance)));
    }
  }
  faults.finish();
  if (channels > 1 && largest > 0 && largest < smallest_extent) {
    throw UserError(path, fmt::format("no value exceeds {}: too small for distances, which are squared; scale them up",
                                      static_cast<double>(largest)));
  }
}

// A float's bits so that unsigned integers order as the floats do (-0 before 0).
std::uint32_t sortable(float value) {
  const std::uint32_t bits = std::bit_cast<std::uint32_t>(value);
  return bits >> 31 != 0 ? ~bits : bits | 0x80000000U;
}

std::size_t widest_channel(const float* points, std::size_t channels, std::span<const std::uint64_t> ids) {
  std::array<float, max_dimensions> low;
  std::array<float, max_dimensions> high;
  low.fill(std::numeric_limits<float>::infinity());
  high.fill(-std::numeric_limits<float>::infinity());
  for (const std::uint64_t id : ids) {
    const float* point = points + static_cast<std::uint32_t>(id) * channels;
    for (std::size_t c = 0; c < channels; ++c) {
      low[c] = std::min(low[c], point[c]);
      high[c] = std::max(high[c], point[c]);
    }
  }
  std::size_t widest = 0;
  for (std::size_t c = 1; c < channels; ++c) {
    const auto width = [&](std::size_t k) { return static_cast<double>(high[k]) - static_cast<double>(low[k]); };
    if (width(c) > width(widest)) widest = c;
  }
  return widest;
}

// std::nth_element of distinct keys without branches on them, which a processor cannot predict: three times as fast.
void select(std::span<std::uint64_t> keys, std::size_t nth) {
  for (int round = 0; keys.size() > 32 && round < 64; ++round) {
    const std::uint64_t a = keys.front();
    const std::uint64_t b = keys[keys.size() / 2];
    const std::uint64_t c = keys.back();
    const std::uint64_t pivot = std::max(std::min(a, b), std::min(std::max(a, b), c));
    std::size_t below = 0;  // keys before it are less than the pivot; one of a, b, c is, and one is not
    for (std::uint64_t& key : keys) {
      const std::uint64_t moved = key;
      key = keys[below];
      keys[below] = moved;
      below += moved < pivot ? 1 : 0;
    }
    const bool left = nth < below;
    keys = left ? keys.first(below) : keys.subspan(below);
    nth -= left ? 0 : below;
  }
  std::nth_element(keys.begin(), keys.begin() + static_cast<std::ptrdiff_t>(nth), keys.end());
}

// Orders points by halving at the median of the widest channel, recursively. An element of `ids` holds the point's
// index in its low word; its high word is for the keys that it is ordered by. Ties go by index, so there is one such
// order.
void order_by_medians(const float* points, std::size_t channels, std::span<std::uint64_t> ids) {
  if (ids.size() < 2) return;
  const std::size_t widest = widest_channel(points, channels, ids);
  for (std::uint64_t& id : ids) {
    const std::uint32_t index = static_cast<std::uint32_t>(id);
    id = std::uint64_t{sortable(points[index * channels + widest])} << 32 | index;
  }
  const std::size_t half = ids.size() / 2;
  select(ids, half);
  order_by_medians(points, channels, ids.first(half));
  order_by_medians(points, channels, ids.subspan(half));
}

std::vector<float> in_order(std::span<const float> samples, std::size_t channels) {
  std::vector<float> ordered(samples.begin(), samples.end());
  if (channels == 1) {
    std::stable_sort(ordered.begin(), ordered.end());
    return ordered;
  }
  std::vector<std::uint64_t> ids(samples.size() / channels);
  std::iota(ids.begin(), ids.end(), std::uint64_t{0});
  order_by_medians(samples.data(), channels, ids);
  float* out = ordered.data();
  for (const std::uint64_t id : ids)
    out = std::copy_n(samples.data() + static_cast<std::uint32_t>(id) * channels, channels, out);
  return ordered;
}

}  // namespace

int channels_of_shape(const std::vector<std::int64_t>& shape, std::int64_t cells_per_slice, std::int32_t num_slices,
                      const std::string& path) {
  return static_cast<int>(layout_of(shape, cells_per_slice, num_slices, path).channels);
}

SampleFile::SampleFile(InputArrayPtr array, const std::string& path, DistanceKind distance,
                       std::int64_t cells_per_slice, std::int32_t num_slices)
    : cells_(static_cast<std::size_t>(cells_per_slice)) {
  const Layout layout = layout_of(array->shape, cells_per_slice, num_slices, path);
  check_distance(distance, layout.channels, path);
  channels_ = static_cast<std::size_t>(layout.channels);
  shared_ = layout.shared;
  const auto& values = std::get<SharedValues<float>>(array->values);
  check_values(values, layout, distance, cells_per_slice, path);
  if (shared_) {
    values_ = in_order(values, channels_);
  } else {
    array_ = std::move(array);
  }
}

std::vector<float> SampleFile::list(SliceIndex slice) const {
  if (shared_) return values_;
  const std::size_t count = cells_ * channels_;
  const std::span<const float> all(std::get<SharedValues<float>>(array_->values));
  return in_order(all.subspan(static_cast<std::size_t>(slice) * count, count), channels_);
}

}  // namespace noiseloom
