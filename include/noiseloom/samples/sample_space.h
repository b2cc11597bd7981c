// The samples of a texture: stratified lists from a built-in space (samples/space.h) or from a user's file, and where
// each sample stands before anything is optimised.
//
// A sample *list* is float32, interleaved [id][channel]; id is the index of the stratum.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "noiseloom/core/extents.h"
#include "noiseloom/samples/spec.h"

namespace noiseloom {

// True where the density of the spec's space is not constant; false for files, which bring none.
bool has_pdf(const SampleSpec& spec);
// Of one sample. file: what the spec says; what the file holds is SampleSource::channels().
int num_channels(const SampleSpec& spec);
// Of samples of `channels` numbers: what the spec says, save that lengths of one number are `absolute`.
DistanceKind distance_kind(const SampleSpec& spec, int channels);
// As people are told: "vector2", and "vector2 by manhattan" where R is of another distance than the space's own.
std::string describe_samples(const SampleSpec& spec);
// Whether samples are unit vectors, however they are compared.
bool are_unit_vectors(const SampleSpec& spec);

// Of a texture of those slices. file: what its contents say, or its header where they are not at hand; throws UserError
// for a shape that fits no such texture.
int num_channels(const SampleSpec& spec, std::int64_t cells_per_slice, std::int32_t num_slices);

// Distance in double. a, b: `channels` values each. circle: circumference 1. angle: radians, cosine clamped to [-1, 1];
// unit vectors in float have lengths off by up to 1e-7, so equal samples may be 5e-4 apart. axis and cosine: from
// chords; see DistanceKind.
double distance(DistanceKind kind, int channels, const float* a, const float* b);

// The lists of every slice of one texture. Pure: list(slice) is a function of (spec, cells_per_slice, seed, slice).
//
// Samples of a file: float32 values are kept bit for bit, others are rounded to float32; strata are places in an order
// of the list (scalars: ascending; vectors: halved at the median of the widest channel, recursively). Values must be
// finite as float32, no denormals and within 1e18; points of several channels not all within 1e-18. distance =
// circle: in [0, 1); angle, axis and cosine: lengths within 1e-3 of 1.
class SampleSource {
 public:
  // Reads and checks a user's file; UserError naming the shapes that are accepted, or slice, sample and channel of the
  // first values that are not.
  SampleSource(const SampleSpec& spec, std::int64_t cells_per_slice, std::int32_t num_slices, std::uint64_t seed);
  ~SampleSource();
  SampleSource(SampleSource&&) noexcept;

  bool is_file() const;
  int channels() const;
  // As distance_kind().
  DistanceKind distance() const;
  std::int64_t cells_per_slice() const;
  std::int32_t num_slices() const;
  // cells_per_slice * channels floats, [id][channel]. One jittered sample in each of n equal-measure strata, n any
  // number >= 1; or the file's.
  std::vector<float> list(SliceIndex slice) const;
  // True where the density over the space's own measure is not constant (tent, gauss, hemisphere-cosine).
  bool has_pdf() const;
  // The density of the space; not for files, which bring none.
  double pdf(const float* sample) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

// A sample of a slice: its place in the slice's list. No cell of the slice, though there are as many of these.
using SampleId = Index<struct SampleIdTag, std::uint32_t>;
// Where the samples of a slice lie: element [cell] is the sample there.
using Permutation = std::vector<SampleId>;

// The permutation that a slice starts with. Uniformly random (Fisher-Yates from
// counter-based draws of 64 bits). Requires 1 <= cells_per_slice <= 2^32.
Permutation start_permutation(std::uint64_t seed, SliceIndex slice, std::int64_t cells_per_slice);
// Every sample in the cell that has its number.
Permutation identity_permutation(std::int64_t cells_per_slice);

}  // namespace noiseloom
