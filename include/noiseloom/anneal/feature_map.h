// The value kernel K between the samples of different slices, written with a few functions of one sample, its
// *features* f:
//
//   K(a, b) = f(a)^T A f(b)  +  terms of one sample alone, which no swap of samples within a slice changes
//
// With them the pull of all other slices on a sample is a sum that is taken once for each visit
// (anneal/deltas/background.h), however many slices the temporal filter reaches.
//
// f are functions that are cheap to evaluate: products of cosines cos(k pi x) over the bounding box of the samples
// (scalars, vectors), cos and sin(2 pi k x) (circle), monomials (directions); of the kernel -d, odd ones where even
// ones vanish, and even ones of axes. Of a channel with far tails the box spans the bulk alone, as a box that the tails
// stretch leaves the bulk unresolved. A is the least-squares fit over all pairs of a subset of the samples, in which
// peaks and what lies far from them both have their share, so that any distribution is served. For uniform scalars it
// is known in closed form: -|a - b| = sum_n 4 cos(n pi a) cos(n pi b) / (n pi)^2 + ..., of which the tail after N terms
// holds 6 / (pi^2 N) of the variance.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "noiseloom/problem/value_kernel.h"

namespace noiseloom {

class FeatureMap {
 public:
  // `most_features` features at most (fewer where the space has fewer). list: samples, interleaved; at least one. Pure,
  // in double.
  FeatureMap(const ValueKernel& kernel, int most_features, std::span<const float> list);

  // A feature is a product of at most max_factors entries of the tables of its sample.
  static constexpr int max_factors = 8;
  enum class Basis { cosines, circle, powers };

  Basis basis() const { return basis_; }
  int channels() const { return channels_; }
  int num_tables() const { return num_tables_; }
  // Entries of one table: degrees 0 (which is 1) to max_degree.
  int max_degree() const { return max_degree_; }
  int num_features() const { return static_cast<int>(degrees_.size()) / num_tables_; }
  // The degree of feature n in table t.
  int degree(int n, int t) const { return degrees_[static_cast<std::size_t>(n * num_tables_ + t)]; }
  // cosines: table c at x is cos(k pi (x - low[c]) inverse_width[c]), clamped to the box.
  float low(int c) const { return low_[static_cast<std::size_t>(c)]; }
  float inverse_width(int c) const { return inverse_width_[static_cast<std::size_t>(c)]; }
  // A, symmetric: [m * num_features + n].
  const std::vector<double>& mixing() const { return mixing_; }
  // What the features leave out of the variance, 0 to 1: 1 - E[f^T A f] / E[K'(a, a)], where K' is K less its terms of
  // one sample (uniform scalars, N features: 6 / (pi^2 N)). Over the samples that A was fitted to.
  double missed() const { return missed_; }

  // f(sample), in double.
  std::vector<double> features(const float* sample) const;

 private:
  void span_list(std::span<const float> list);
  void choose_features(const ValueKernel& kernel, int most_features);
  void fit(const ValueKernel& kernel, std::span<const float> list);

  Basis basis_;
  int channels_;
  int num_tables_;
  int max_degree_ = 0;
  std::vector<int> degrees_;
  std::vector<float> low_;
  std::vector<float> inverse_width_;
  std::vector<double> mixing_;
  double missed_ = 0;
};

}  // namespace noiseloom
