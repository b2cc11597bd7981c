#include "noiseloom/samples/sample_space.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <optional>

#include "noiseloom/core/math.h"
#include "noiseloom/core/random.h"
#include "samples/sample_file.h"
#include "samples/sample_maps.h"
#include "samples/sample_scalar.h"
#include "samples/strata.h"

namespace noiseloom {
namespace {

using Jitter = std::array<double, max_dimensions>;
using Sample = std::array<float, max_dimensions>;

bool is_scalar(SampleKind kind) {
  return kind == SampleKind::uniform || kind == SampleKind::tent || kind == SampleKind::gauss ||
         kind == SampleKind::circle;
}

// Rounding may carry a sample over the border of its stratum; then the jitter is drawn towards the middle, where there
// is room for it.
void sample_in_box(SampleKind kind, int channels, const Box& box, const double* jitter, float* sample) {
  for (const double keep : {1.0, 0.984375, 0.875, 0.0}) {
    std::array<double, max_dimensions> u;
    std::array<double, max_dimensions> exact;
    for (std::size_t axis = 0; axis < box.dimensions; ++axis) {
      const double at = 0.5 + keep * (jitter[axis] - 0.5);
      u[axis] = box.low[axis] + (box.high[axis] - box.low[axis]) * at;
    }
    to_sample(kind, channels, u.data(), exact.data());
    std::transform(exact.data(), exact.data() + channels, sample, [](double x) { return static_cast<float>(x); });
    to_domain(kind, channels, sample, u.data());
    if (box.contains(u.data()) && lies_in_space(kind, sample)) return;
  }
}

// In (0, 1), 52 bits each: two numbers a block.
Jitter draw_jitter(std::uint64_t seed, SliceIndex slice, std::int64_t id, int dimensions) {
  Jitter jitter{};
  const std::uint64_t blocks = static_cast<std::uint64_t>(dimensions + 1) / 2;
  for (std::uint64_t block = 0; block < blocks; ++block) {
    const RandomBlock bits = random_block(seed, Purpose::jitter, static_cast<std::uint32_t>(slice), 0,
                                          static_cast<std::uint64_t>(id) * blocks + block);
    for (std::size_t half = 0; half < 2; ++half) {
      const std::uint64_t word = std::uint64_t{bits[2 * half]} << 20 ^ bits[2 * half + 1] >> 12;
      jitter[2 * block + half] = static_cast<double>(2 * word + 1) * 0x1p-53;
    }
  }
  return jitter;
}

std::vector<float> analytic_list(const SampleSpec& spec, std::int64_t n, std::uint64_t seed, SliceIndex slice) {
  const int channels = num_channels(spec);
  const int dimensions = num_dimensions(spec);
  std::vector<float> list(static_cast<std::size_t>(n) * static_cast<std::size_t>(channels));
  float* out = list.data();
  if (is_scalar(spec.kind)) {
    double low = scalar_edge(spec.kind, n, 0);
    for (std::int64_t id = 0; id < n; ++id) {
      const double high = scalar_edge(spec.kind, n, id + 1);
      *out++ = scalar_sample(spec.kind, n, id, draw_jitter(seed, slice, id, 1)[0], low, high);
      low = high;
    }
    return list;
  }
  Strata(domain(spec.kind, channels), n).for_each([&](std::int64_t id, const Box& box) {
    sample_in_box(spec.kind, channels, box, draw_jitter(seed, slice, id, dimensions).data(), out);
    out += channels;
  });
  return list;
}

// floor(bound * bits / 2^64), bound <= 2^32: uniform below `bound` up to a bias of 2^-32.
std::uint32_t below(std::uint32_t hi, std::uint32_t lo, std::uint64_t bound) {
  return static_cast<std::uint32_t>((hi * bound + (lo * bound >> 32)) >> 32);
}

}  // namespace

int num_channels(const SampleSpec& spec) {
  switch (spec.kind) {
    case SampleKind::vector:
    case SampleKind::file:
      return spec.channels;
    case SampleKind::sphere:
    case SampleKind::hemisphere:
    case SampleKind::hemisphere_cosine:
      return 3;
    case SampleKind::disk:
      return 2;
    default:
      return 1;
  }
}

DistanceKind distance_kind(const SampleSpec& spec, int channels) {
  switch (spec.kind) {
    case SampleKind::circle:
      return DistanceKind::circle;
    case SampleKind::vector:
    case SampleKind::disk:
      return DistanceKind::euclidean;
    case SampleKind::sphere:
    case SampleKind::hemisphere:
    case SampleKind::hemisphere_cosine:
      return DistanceKind::angle;
    case SampleKind::file:
      return spec.distance == DistanceKind::euclidean && channels == 1 ? DistanceKind::absolute : spec.distance;
    default:
      return DistanceKind::absolute;
  }
}

std::string sample_space_name(const SampleSpec& spec) {
  switch (spec.kind) {
    case SampleKind::uniform:
      return "uniform";
    case SampleKind::tent:
      return "tent";
    case SampleKind::gauss:
      return "gauss";
    case SampleKind::circle:
      return "circle";
    case SampleKind::vector:
      return "vector" + std::to_string(spec.channels);
    case SampleKind::sphere:
      return "sphere";
    case SampleKind::hemisphere:
      return "hemisphere";
    case SampleKind::hemisphere_cosine:
      return "hemisphere-cosine";
    case SampleKind::disk:
      return "disk";
    case SampleKind::file:
      return "file";
  }
  return "";
}

double distance(DistanceKind kind, int channels, const float* a, const float* b) {
  if (kind == DistanceKind::absolute || kind == DistanceKind::circle) {
    const double d = std::fabs(static_cast<double>(*a) - static_cast<double>(*b));
    return kind == DistanceKind::circle ? std::min(d, 1 - d) : d;
  }
  double sum = 0;
  for (int c = 0; c < channels; ++c) {
    const double x = a[c];
    const double y = b[c];
    sum += kind == DistanceKind::angle ? x * y : (x - y) * (x - y);
  }
  return kind == DistanceKind::angle ? math::acos(sum) : std::sqrt(sum);
}

int num_dimensions(const SampleSpec& spec) {
  NOISELOOM_CHECK(spec.kind != SampleKind::file);
  return is_scalar(spec.kind) ? 1 : static_cast<int>(domain(spec.kind, spec.channels).dimensions);
}

void sample_at(const SampleSpec& spec, std::int64_t n, std::int64_t id, const double* jitter, float* sample) {
  NOISELOOM_CHECK(spec.kind != SampleKind::file);
  NOISELOOM_CHECK(id >= 0 && id < n);
  if (is_scalar(spec.kind)) {
    const double low = scalar_edge(spec.kind, n, id);
    *sample = scalar_sample(spec.kind, n, id, *jitter, low, scalar_edge(spec.kind, n, id + 1));
    return;
  }
  const Strata strata(domain(spec.kind, spec.channels), n);
  sample_in_box(spec.kind, num_channels(spec), strata.box(id), jitter, sample);
}

double sample_pdf(const SampleSpec& spec, const float* sample) {
  switch (spec.kind) {
    case SampleKind::sphere:
      return 0.25 / math::pi;
    case SampleKind::hemisphere:
      return 0.5 / math::pi;
    case SampleKind::hemisphere_cosine:
      return std::max(0.0, static_cast<double>(sample[2])) / math::pi;
    case SampleKind::disk:
      return 1 / math::pi;
    case SampleKind::vector:
      return 1;
    default:
      break;
  }
  NOISELOOM_CHECK(spec.kind != SampleKind::file);
  return scalar_pdf(spec.kind, *sample);
}

std::int64_t sample_invert(const SampleSpec& spec, std::int64_t n, const float* sample) {
  NOISELOOM_CHECK(spec.kind != SampleKind::file);
  if (is_scalar(spec.kind)) return scalar_invert(spec.kind, n, *sample);
  std::array<double, max_dimensions> u;
  to_domain(spec.kind, num_channels(spec), sample, u.data());
  return Strata(domain(spec.kind, spec.channels), n).find(u.data());
}

struct SampleSource::Impl {
  SampleSpec spec;
  std::int64_t cells_per_slice;
  SliceIndex num_slices;
  std::uint64_t seed;
  std::optional<SampleFile> file;
};

SampleSource::SampleSource(const SampleSpec& spec, std::int64_t cells_per_slice, SliceIndex num_slices,
                           std::uint64_t seed)
    : impl_(std::make_unique<Impl>(Impl{spec, cells_per_slice, num_slices, seed, {}})) {
  NOISELOOM_CHECK_LE(1, cells_per_slice);
  NOISELOOM_CHECK_LE(1, num_slices);
  if (spec.kind == SampleKind::file) {
    impl_->file.emplace(spec.file, spec.distance, cells_per_slice, num_slices);
    impl_->spec.channels = impl_->file->channels();
  }
}

SampleSource::~SampleSource() = default;
SampleSource::SampleSource(SampleSource&&) noexcept = default;

int SampleSource::channels() const { return num_channels(impl_->spec); }

DistanceKind SampleSource::distance() const { return distance_kind(impl_->spec, channels()); }

std::int64_t SampleSource::cells_per_slice() const { return impl_->cells_per_slice; }
SliceIndex SampleSource::num_slices() const { return impl_->num_slices; }

std::vector<float> SampleSource::list(SliceIndex slice) const {
  NOISELOOM_CHECK(slice >= 0 && slice < impl_->num_slices);
  if (impl_->file) return impl_->file->list(slice);
  return analytic_list(impl_->spec, impl_->cells_per_slice, impl_->seed, slice);
}

bool SampleSource::has_pdf() const {
  const SampleKind kind = impl_->spec.kind;
  return kind == SampleKind::tent || kind == SampleKind::gauss || kind == SampleKind::hemisphere_cosine;
}

double SampleSource::pdf(const float* sample) const { return sample_pdf(impl_->spec, sample); }

std::vector<std::uint32_t> start_permutation(std::uint64_t seed, SliceIndex slice, std::int64_t cells_per_slice) {
  NOISELOOM_CHECK(cells_per_slice >= 1 && cells_per_slice <= std::int64_t{1} << 32);
  std::vector<std::uint32_t> order(static_cast<std::size_t>(cells_per_slice));
  std::iota(order.begin(), order.end(), 0U);
  for (std::uint64_t last = order.size() - 1; last > 0; --last) {
    const RandomBlock bits = random_block(seed, Purpose::shuffle, static_cast<std::uint32_t>(slice), 0, last);
    std::swap(order[last], order[below(bits[0], bits[1], last + 1)]);
  }
  return order;
}

}  // namespace noiseloom
