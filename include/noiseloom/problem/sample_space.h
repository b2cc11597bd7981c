// Sample spaces: the set a sample lives in, its distribution, its distance, and stratified lists of it.
//
// A sample *list* is float32, interleaved [id][channel]; id is the index of the stratum. Strata are numbered along a
// locality-preserving order (for scalars: ascending value), so samples whose ids are near are near in the space; the
// optimiser proposes partners by id distance.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "noiseloom/problem/spec.h"

namespace noiseloom {

int num_channels(const SampleSpec& spec);
DistanceKind distance_kind(const SampleSpec& spec);
// The name a config uses: "uniform", "vector3", "hemisphere-cosine", ...
std::string sample_space_name(const SampleSpec& spec);

// Distance in double. a, b: `channels` values each. circle: circumference 1. angle: radians, cosine clamped to [-1, 1].
double distance(DistanceKind kind, int channels, const float* a, const float* b);

// The lists of every slice of one texture. Pure: list(slice) is a function of (spec, cells_per_slice, seed, slice).
class SampleSource {
 public:
  // Reads and checks a user's file (finite values, shape; UserError naming the position otherwise).
  SampleSource(const SampleSpec& spec, std::int64_t cells_per_slice, SliceIndex num_slices, std::uint64_t seed);
  ~SampleSource();
  SampleSource(SampleSource&&) noexcept;

  int channels() const;
  DistanceKind distance() const;
  std::int64_t cells_per_slice() const;
  SliceIndex num_slices() const;
  // cells_per_slice * channels floats. One jittered sample in each of n equal-measure strata; n any number >= 1.
  std::vector<float> list(SliceIndex slice) const;
  // True where the density over the space's own measure is not constant (tent, gauss, hemisphere-cosine).
  bool has_pdf() const;
  // Density of one sample with respect to length, area or solid angle.
  double pdf(const float* sample) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

// The start permutation of a slice: element [cell] is the id of the sample there. Uniformly random (Fisher-Yates from
// counter-based draws).
std::vector<std::uint32_t> start_permutation(std::uint64_t seed, SliceIndex slice, std::int64_t cells_per_slice);

}  // namespace noiseloom
