#include "noiseloom/samples/sample_space.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>

#include "noiseloom/core/math.h"
#include "noiseloom/core/random.h"
#include "noiseloom/files/npy.h"
#include "noiseloom/samples/space.h"
#include "samples/curve.h"
#include "samples/sample_file.h"

namespace noiseloom {
namespace {

// Numbers in (0, 1), 52 bits each: two a block.
void draw_jitter(std::uint64_t seed, SliceIndex slice, std::int64_t id, int dimensions, double* jitter) {
  const std::uint64_t blocks = static_cast<std::uint64_t>(dimensions + 1) / 2;
  for (std::uint64_t block = 0; block < blocks; ++block) {
    const RandomBlock bits = random_block(seed, Purpose::jitter, static_cast<std::uint32_t>(slice), 0,
                                          static_cast<std::uint64_t>(id) * blocks + block);
    for (int half = 0; half < 2 && 2 * static_cast<int>(block) + half < dimensions; ++half) {
      const auto at = static_cast<std::size_t>(2 * half);
      const std::uint64_t word = std::uint64_t{bits[at]} << 20 ^ bits[at + 1] >> 12;
      *jitter++ = static_cast<double>(2 * word + 1) * 0x1p-53;
    }
  }
}

// floor(bound * bits / 2^64), bound <= 2^32: uniform below `bound` up to a bias of 2^-32.
std::uint32_t below(std::uint32_t hi, std::uint32_t lo, std::uint64_t bound) {
  return static_cast<std::uint32_t>((hi * bound + (lo * bound >> 32)) >> 32);
}

DistanceKind distance_of_space(const SampleSpec& spec) {
  switch (spec.compared_by) {
    case ComparedBy::own:
      break;
    case ComparedBy::euclidean:
      return DistanceKind::euclidean;
    case ComparedBy::manhattan:
      return DistanceKind::manhattan;
    case ComparedBy::chebyshev:
      return DistanceKind::chebyshev;
    case ComparedBy::cosine:
      return DistanceKind::cosine;
  }
  return space_traits(spec).distance;
}

}  // namespace

bool has_pdf(const SampleSpec& spec) { return !spec.is_file() && !space_traits(spec).has_constant_density; }

int num_channels(const SampleSpec& spec) { return spec.is_file() ? spec.channels : space_traits(spec).channels; }

int num_channels(const SampleSpec& spec, std::int64_t cells_per_slice, std::int32_t num_slices) {
  if (!spec.is_file()) return num_channels(spec);
  const std::vector<std::int64_t> shape = spec.array ? spec.array->shape : read_npy_shape(spec.file);
  return channels_of_shape(shape, cells_per_slice, num_slices, spec.file);
}

DistanceKind distance_kind(const SampleSpec& spec, int channels) {
  const DistanceKind kind = spec.is_file() ? spec.distance : distance_of_space(spec);
  const bool is_length =
      kind == DistanceKind::euclidean || kind == DistanceKind::manhattan || kind == DistanceKind::chebyshev;
  return is_length && channels == 1 ? DistanceKind::absolute : kind;
}

std::string describe_samples(const SampleSpec& spec) {
  switch (spec.is_file() ? spec.distance : distance_of_space(spec)) {
    case DistanceKind::manhattan:
      return spec.space + " by manhattan";
    case DistanceKind::chebyshev:
      return spec.space + " by chebyshev";
    case DistanceKind::cosine:
      return spec.space + " by cosine";
    default:
      return spec.space + (spec.compared_by == ComparedBy::euclidean ? " by euclidean" : "");
  }
}

bool are_unit_vectors(const SampleSpec& spec) {
  return is_between_unit_vectors(spec.is_file() ? spec.distance : space_traits(spec).distance);
}

double distance(DistanceKind kind, int channels, const float* a, const float* b) {
  double differences = 0;
  double largest = 0;
  double squares = 0;
  double product = 0;
  double to_opposite = 0;
  for (int c = 0; c < channels; ++c) {
    const double x = a[c];
    const double y = b[c];
    differences += std::fabs(x - y);
    largest = std::max(largest, std::fabs(x - y));
    squares += (x - y) * (x - y);
    product += x * y;
    to_opposite += (x + y) * (x + y);
  }
  switch (kind) {
    case DistanceKind::absolute:
    case DistanceKind::manhattan:
      return differences;
    case DistanceKind::circle:
      return std::min(differences, 1 - differences);
    case DistanceKind::euclidean:
      return std::sqrt(squares);
    case DistanceKind::angle:
      return math::acos(product);
    case DistanceKind::axis:
      return 0.5 * std::sqrt(squares * to_opposite);
    case DistanceKind::chebyshev:
      return largest;
    case DistanceKind::cosine:
      return 0.5 * squares;
  }
  return 0;
}

struct SampleSource::Impl {
  SampleSpec spec;
  std::int64_t cells_per_slice;
  std::int32_t num_slices;
  std::uint64_t seed;
  std::shared_ptr<const SampleSpace> space;  // null for a file
  std::optional<SampleFile> file;
};

SampleSource::SampleSource(const SampleSpec& spec, std::int64_t cells_per_slice, std::int32_t num_slices,
                           std::uint64_t seed)
    : impl_(std::make_unique<Impl>(Impl{spec, cells_per_slice, num_slices, seed, {}, {}})) {
  NOISELOOM_CHECK_LE(1, cells_per_slice);
  NOISELOOM_CHECK_LE(1, num_slices);
  if (spec.is_file()) {
    const InputArrayPtr array = spec.array ? spec.array : read_float_array(spec.file);
    impl_->file.emplace(array, spec.file, spec.distance, cells_per_slice, num_slices);
    impl_->spec.channels = impl_->file->channels();
  } else {
    impl_->space = space_of(spec);
  }
}

SampleSource::~SampleSource() = default;
SampleSource::SampleSource(SampleSource&&) noexcept = default;

bool SampleSource::is_file() const { return impl_->file.has_value(); }

int SampleSource::channels() const { return num_channels(impl_->spec); }

DistanceKind SampleSource::distance() const { return distance_kind(impl_->spec, channels()); }

std::int64_t SampleSource::cells_per_slice() const { return impl_->cells_per_slice; }
std::int32_t SampleSource::num_slices() const { return impl_->num_slices; }

std::vector<float> SampleSource::list(SliceIndex slice) const {
  NOISELOOM_CHECK(first_indices<SliceIndex>(impl_->num_slices).contains(slice));
  if (impl_->file) return impl_->file->list(slice);
  const SampleSpace& space = *impl_->space;
  const int dimensions = space.traits().dimensions;
  std::vector<float> list(static_cast<std::size_t>(impl_->cells_per_slice) *
                          static_cast<std::size_t>(space.traits().channels));
  space.list_of_slice(
      impl_->cells_per_slice, slice, impl_->seed,
      [&](std::int64_t id, double* jitter) { draw_jitter(impl_->seed, slice, id, dimensions, jitter); }, list.data());
  const Curve curve = impl_->spec.curve;
  return curve == Curve::none ? list : along_curve(curve, space.traits().channels, list);
}

bool SampleSource::has_pdf() const { return impl_->space && !impl_->space->traits().has_constant_density; }

double SampleSource::pdf(const float* sample) const { return impl_->space->density(sample); }

Permutation identity_permutation(std::int64_t cells_per_slice) {
  Permutation order(static_cast<std::size_t>(cells_per_slice));
  for (std::size_t id = 0; id < order.size(); ++id) order[id] = SampleId(static_cast<std::uint32_t>(id));
  return order;
}

Permutation start_permutation(std::uint64_t seed, SliceIndex slice, std::int64_t cells_per_slice) {
  NOISELOOM_CHECK(cells_per_slice >= 1 && cells_per_slice <= std::int64_t{1} << 32);
  Permutation order = identity_permutation(cells_per_slice);
  for (std::uint64_t last = order.size() - 1; last > 0; --last) {
    const RandomBlock bits = random_block(seed, Purpose::shuffle, static_cast<std::uint32_t>(slice), 0, last);
    std::swap(order[last], order[below(bits[0], bits[1], last + 1)]);
  }
  return order;
}

}  // namespace noiseloom
