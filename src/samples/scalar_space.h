// Spaces of one number: sorted strata by the inverse of the distribution function.
#pragma once

#include "noiseloom/samples/space.h"

namespace noiseloom {

struct ScalarMap {
  // The value with `below` of the measure on its low side and `above` on its high side; both are given because 1 -
  // below has lost its digits where it is small.
  double (*quantile)(double below, double above);
  double (*cumulative)(double x);  // the measure below x
  double (*density)(double x);
};

class ScalarSpace : public SampleSpace {
 public:
  // channels and dimensions are 1.
  ScalarSpace(SpaceTraits traits, ScalarMap map) : SampleSpace(std::move(traits)), map_(map) {}

  void sample(std::int64_t n, std::int64_t id, const double* jitter, float* sample) const override;
  void list(std::int64_t n, const JitterOf& jitter, float* samples) const override;
  std::int64_t invert(std::int64_t n, const float* sample) const override;
  double density(const float* sample) const override { return map_.density(*sample); }
  double share_below(int /*channel*/, double value) const override { return map_.cumulative(value); }

  // Stratum k is [edge(k), edge(k + 1)), 0 <= k <= n.
  double edge(std::int64_t n, std::int64_t k) const { return quantile_at(n, k, 0); }

 private:
  double quantile_at(std::int64_t n, std::int64_t k, double jitter) const;
  float sample_between(std::int64_t n, std::int64_t k, double jitter, double low, double high) const;

  ScalarMap map_;
};

}  // namespace noiseloom
