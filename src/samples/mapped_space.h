// Spaces that a measure-preserving map takes from a box: strata are those of the box (strata.h).
#pragma once

#include <functional>
#include <mutex>
#include <utility>
#include <vector>

#include "noiseloom/samples/space.h"
#include "samples/strata.h"

namespace noiseloom {

// Maps that are near to isometric make strata that are nearly square in the box nearly round in the space.
struct BoxMap {
  Box domain;
  // u in the domain -> sample, in double.
  std::function<void(int channels, const double* u, double* sample)> to_sample;
  // The inverse, from a sample as it is stored.
  std::function<void(int channels, const float* sample, double* u)> to_domain;
  // What the space promises of a stored sample, whatever rounding did.
  std::function<bool(const float* sample)> contains;
  std::function<double(const float* sample)> density;
  // The distribution function of a coordinate; none: it is counted over a stratified list.
  std::function<double(int channel, double value)> share_below = {};
};

// The box [0, 1)^dimensions.
Box unit_box(int dimensions);

class MappedSpace : public SampleSpace {
 public:
  // dimensions of the traits are those of the domain.
  MappedSpace(SpaceTraits traits, BoxMap map) : SampleSpace(std::move(traits)), map_(std::move(map)) {}

  void sample(std::int64_t n, std::int64_t id, const double* jitter, float* sample) const override;
  void list(std::int64_t n, const JitterOf& jitter, float* samples) const override;
  std::int64_t invert(std::int64_t n, const float* sample) const override;
  double density(const float* sample) const override { return map_.density(sample); }
  double share_below(int channel, double value) const override;

 private:
  void sample_in(const Box& box, const double* jitter, float* sample) const;

  BoxMap map_;
  mutable std::once_flag counted_;
  mutable std::vector<std::vector<float>> coordinates_;  // of every channel, ascending
};

}  // namespace noiseloom
