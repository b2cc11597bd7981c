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

#include "noiseloom/core/extents.h"
#include "noiseloom/samples/spec.h"

namespace noiseloom {

// Of one sample. file: what the spec says; what the file holds is SampleSource::channels().
int num_channels(const SampleSpec& spec);
// Of samples of `channels` numbers. file: what the spec says, save that lengths of one number are `absolute`.
DistanceKind distance_kind(const SampleSpec& spec, int channels);
// The name a config uses: "uniform", "vector3", "hemisphere-cosine", ...
std::string sample_space_name(const SampleSpec& spec);

// Distance in double. a, b: `channels` values each. circle: circumference 1. angle: radians, cosine clamped to [-1, 1];
// unit vectors in float have lengths off by up to 1e-7, so equal samples may be 5e-4 apart.
double distance(DistanceKind kind, int channels, const float* a, const float* b);

// What follows describes every space but file.
//
//   uniform, circle   [0, 1)                           vector2..8         the cube [0, 1)^C
//   tent              [0, 1), density 4 min(x, 1 - x)  sphere             unit vectors
//   gauss             mean 0, variance 1               hemisphere         unit vectors with z > 0
//   disk              |p| <= 1                         hemisphere-cosine  the same, density z / pi
//
// Scalars: stratum k of n holds the quantiles in [k / n, (k + 1) / n). Others: the unit cube (sphere: a box of 2 x 1),
// halved recursively, then mapped; a cut's two sides are numbered one after the other. For n up to 2^24
// (tent: 2^23) a sample lies in its own stratum as rounded to float; beyond, where a stratum may hold no float, beside
// it.

// Independent random numbers that a sample takes.
int num_dimensions(const SampleSpec& spec);
// Writes the sample of stratum `id` of `n` at `jitter`: one number in (0, 1) for each dimension.
void sample_at(const SampleSpec& spec, std::int64_t n, std::int64_t id, const double* jitter, float* sample);
// Density of a sample with respect to length, area or solid angle (circle: turns). Positive for every sample that
// sample_at gives.
double sample_pdf(const SampleSpec& spec, const float* sample);
// The stratum, of n, that holds a sample.
std::int64_t sample_invert(const SampleSpec& spec, std::int64_t n, const float* sample);

// The lists of every slice of one texture. Pure: list(slice) is a function of (spec, cells_per_slice, seed, slice).
//
// Samples of a file: float32 values are kept bit for bit, others are rounded to float32; strata are places in an order
// of the list (scalars: ascending; vectors: halved at the median of the widest channel, recursively). Values must be
// finite as float32, no denormals and within 1e18; points of several channels not all within 1e-18. distance =
// circle: in [0, 1); angle: lengths within 1e-3 of 1.
class SampleSource {
 public:
  // Reads and checks a user's file; UserError naming the shapes that are accepted, or slice, sample and channel of the
  // first values that are not.
  SampleSource(const SampleSpec& spec, std::int64_t cells_per_slice, SliceIndex num_slices, std::uint64_t seed);
  ~SampleSource();
  SampleSource(SampleSource&&) noexcept;

  int channels() const;
  // A file's Euclidean distance of one channel is `absolute`.
  DistanceKind distance() const;
  std::int64_t cells_per_slice() const;
  SliceIndex num_slices() const;
  // cells_per_slice * channels floats, [id][channel]. One jittered sample in each of n equal-measure strata, n any
  // number >= 1; or the file's.
  std::vector<float> list(SliceIndex slice) const;
  // True where the density over the space's own measure is not constant (tent, gauss, hemisphere-cosine).
  bool has_pdf() const;
  // sample_pdf; not for files, which bring no density.
  double pdf(const float* sample) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

// The start permutation of a slice: element [cell] is the id of the sample there. Uniformly random (Fisher-Yates from
// counter-based draws of 64 bits). Requires 1 <= cells_per_slice <= 2^32.
std::vector<std::uint32_t> start_permutation(std::uint64_t seed, SliceIndex slice, std::int64_t cells_per_slice);

}  // namespace noiseloom
