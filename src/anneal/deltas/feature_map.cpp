#include "noiseloom/anneal/feature_map.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "noiseloom/core/error.h"
#include "noiseloom/core/math.h"

namespace noiseloom {
namespace {

constexpr std::size_t fit_samples = 1024;

// A sample of the list and how many it stands for, 1 on average.
struct WeightedSample {
  const float* channels;
  double weight;
};

struct SamplesToFit {
  std::vector<WeightedSample> samples;
  bool are_uneven;
};

// The samples that A is fitted to: at equal distances in the list. Of a peaked density or one with far tails these
// would be nearly all from the peak: a handful of others decides most of the energy, and a fit of some thirty functions
// to twenty samples says nothing of the rest (a sun that holds 98 % of a sky was annealed to R 1.65 by it). There half
// of them are drawn in proportion to a sample's mean distance from all, with weights that undo it.
SamplesToFit samples_to_fit(const ValueKernel& kernel, std::span<const float> list) {
  constexpr std::size_t most_candidates = 16384;
  constexpr std::size_t most_probes = 256;
  // Uniform samples of any space: below 2; normal ones: 3 to 4.
  constexpr double uneven = 8;
  const auto channels = static_cast<std::size_t>(kernel.channels);
  const std::size_t total = list.size() / channels;
  const auto every = [&](std::size_t k, std::size_t count) { return list.data() + k * total / count * channels; };
  const std::size_t count = std::min(total, fit_samples);
  std::vector<WeightedSample> samples;
  for (std::size_t k = 0; k < count; ++k) samples.push_back({every(k, count), 1});

  const std::size_t candidates = std::min(total, most_candidates);
  const std::size_t probes = std::min(total, most_probes);
  std::vector<double> distance(candidates);  // sum over the probes of (K(a, a) + K(b, b)) / 2 - K(a, b)
  double sum = 0;
  for (std::size_t k = 0; k < candidates; ++k) {
    const float* const a = every(k, candidates);
    for (std::size_t p = 0; p < probes; ++p) {
      const float* const b = every(p, probes);
      distance[k] += 0.5 * (kernel(a, a) + kernel(b, b)) - kernel(a, b);
    }
    sum += distance[k];
  }
  const double mean = sum / static_cast<double>(candidates);
  if (!(*std::max_element(distance.begin(), distance.end()) > uneven * mean)) return {samples, false};
  // Systematic drawing: the j-th sample is where the running sum of the shares passes (j + 1/2) / count.
  const auto share = [&](std::size_t k) { return 0.5 * (distance[k] + mean) / sum; };
  std::size_t at = 0;
  double passed = share(0);
  for (std::size_t j = 0; j < count; ++j) {
    const double wanted = (static_cast<double>(j) + 0.5) / static_cast<double>(count);
    while (passed < wanted && at + 1 < candidates) passed += share(++at);
    samples[j] = {every(at, candidates), 1 / (share(at) * static_cast<double>(candidates))};
  }
  return {samples, true};
}

using Matrix = std::vector<double>;  // square, row after row

// Lower triangular factor of a positive definite matrix.
Matrix cholesky(Matrix a, std::size_t n) {
  for (std::size_t j = 0; j < n; ++j) {
    for (std::size_t i = j; i < n; ++i) {
      double sum = a[i * n + j];
      for (std::size_t k = 0; k < j; ++k) sum -= a[i * n + k] * a[j * n + k];
      a[i * n + j] = i == j ? std::sqrt(sum) : sum / a[j * n + j];
    }
  }
  return a;
}

// Overwrites the columns of b with the solutions of L L^T x = b.
void solve(const Matrix& factor, Matrix& b, std::size_t n) {
  for (std::size_t column = 0; column < n; ++column) {
    for (std::size_t i = 0; i < n; ++i) {
      for (std::size_t k = 0; k < i; ++k) b[i * n + column] -= factor[i * n + k] * b[k * n + column];
      b[i * n + column] /= factor[i * n + i];
    }
    for (std::size_t i = n; i-- > 0;) {
      for (std::size_t k = i + 1; k < n; ++k) b[i * n + column] -= factor[k * n + i] * b[k * n + column];
      b[i * n + column] /= factor[i * n + i];
    }
  }
}

void transpose(Matrix& a, std::size_t n) {
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t j = 0; j < i; ++j) std::swap(a[i * n + j], a[j * n + i]);
  }
}

FeatureMap::Basis basis_of(DistanceKind kind) {
  switch (kind) {
    case DistanceKind::circle:
      return FeatureMap::Basis::circle;
    case DistanceKind::angle:
    case DistanceKind::axis:
    case DistanceKind::cosine:
      return FeatureMap::Basis::powers;
    default:
      return FeatureMap::Basis::cosines;
  }
}

// All degree vectors with entries up to `most`, the first table varying slowest.
void enumerate(int num_tables, int most, std::vector<int>& prefix, std::vector<std::vector<int>>& out) {
  if (static_cast<int>(prefix.size()) == num_tables) {
    out.push_back(prefix);
    return;
  }
  for (int degree = 0; degree <= most; ++degree) {
    prefix.push_back(degree);
    enumerate(num_tables, most, prefix, out);
    prefix.pop_back();
  }
}

}  // namespace

FeatureMap::FeatureMap(const ValueKernel& kernel, int most_features, std::span<const float> list)
    : basis_(basis_of(kernel.distance)),
      channels_(kernel.channels),
      num_tables_(basis_ == Basis::circle ? 2 : kernel.channels),
      low_(static_cast<std::size_t>(channels_)),
      inverse_width_(static_cast<std::size_t>(channels_)) {
  NOISELOOM_CHECK(most_features >= 1 && !list.empty());
  span_list(list);
  choose_features(kernel, most_features);
  fit(kernel, list);
}

void FeatureMap::span_list(std::span<const float> list) {
  const auto channels = static_cast<std::size_t>(channels_);
  std::vector<float> values(list.size() / channels);
  for (std::size_t c = 0; c < channels; ++c) {
    for (std::size_t k = 0; k < values.size(); ++k) values[k] = list[k * channels + c];
    const auto [first, last] = std::minmax_element(values.begin(), values.end());
    float least = *first;
    float most = *last;
    const auto at = [&](std::size_t rank) {
      std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(rank), values.end());
      return values[rank];
    };
    const float quarter = at(values.size() / 4);
    const float middle = at(values.size() / 2);
    const float bulk = at(values.size() * 3 / 4) - quarter;
    // Wider than that of a normal distribution of 2^32 samples: 9. Where half of the samples are equal there is no
    // bulk.
    if (bulk > 0 && most - least > 12 * bulk) {
      least = std::max(least, middle - 4 * bulk);
      most = std::min(most, middle + 4 * bulk);
    }
    low_[c] = least;
    inverse_width_[c] = most > least ? 1 / (most - least) : 0;
  }
}

// The lowest degrees: by the sum of squares, the rate at which the kernel's coefficients fall.
void FeatureMap::choose_features(const ValueKernel& kernel, int most_features) {
  // A kernel of axes is even; of z^2 = 1 - x^2 - y^2 no power of z above the first is needed.
  const bool even_only = kernel.distance == DistanceKind::axis;
  const bool odd_only = kernel.kind == ValueKernelKind::distance && basis_ != Basis::cosines && !even_only;
  const int most_power = even_only ? 6 : 5;
  std::vector<std::vector<int>> all;
  std::vector<int> prefix;
  const int most = basis_ == Basis::circle   ? most_features
                   : basis_ == Basis::powers ? most_power
                   : num_tables_ == 1        ? most_features
                   : num_tables_ == 2        ? 8
                   : num_tables_ <= 4        ? 3
                                             : 1;
  enumerate(num_tables_, most, prefix, all);
  std::erase_if(all, [&](const std::vector<int>& degrees) {
    const int total = std::accumulate(degrees.begin(), degrees.end(), 0);
    const auto factors = std::count_if(degrees.begin(), degrees.end(), [](int degree) { return degree > 0; });
    return total == 0 || (odd_only && total % 2 == 0) || (basis_ == Basis::circle && factors > 1) ||
           (basis_ == Basis::powers && total > most_power) || (even_only && (total % 2 == 1 || degrees.back() > 1));
  });
  const auto size = [this](const std::vector<int>& degrees) {
    int sum = 0;
    for (const int degree : degrees) sum += basis_ == Basis::powers ? degree : degree * degree;
    return sum;
  };
  std::stable_sort(all.begin(), all.end(), [&](const auto& a, const auto& b) { return size(a) < size(b); });
  if (std::ssize(all) > most_features) all.resize(static_cast<std::size_t>(most_features));
  for (const std::vector<int>& degrees : all) {
    degrees_.insert(degrees_.end(), degrees.begin(), degrees.end());
    max_degree_ = std::max(max_degree_, *std::max_element(degrees.begin(), degrees.end()));
  }
}

std::vector<double> FeatureMap::features(const float* sample) const {
  const auto entry = [&](int t, int degree) -> double {
    if (degree == 0) return 1;
    if (basis_ == Basis::circle) {
      const double turns = static_cast<double>(degree) * double{sample[0]};
      return t == 0 ? math::cos_2pi(turns) : math::sin_2pi(turns);
    }
    const double x = double{sample[t]};
    if (basis_ == Basis::cosines) {
      const double inside = std::clamp((x - double{low(t)}) * double{inverse_width(t)}, 0.0, 1.0);
      return math::cos_2pi(0.5 * static_cast<double>(degree) * inside);
    }
    double power = x;
    for (int k = 1; k < degree; ++k) power *= x;
    return power;
  };
  std::vector<double> values;
  for (int n = 0; n < num_features(); ++n) {
    double value = 1;
    for (int t = 0; t < num_tables_; ++t) value *= entry(t, degree(n, t));
    values.push_back(value);
  }
  return values;
}

// A = G^-1 H G^-1 with G the covariance of f and H = E[(f(a) - f) K(a, b) (f(b) - f)^T] over all pairs.
void FeatureMap::fit(const ValueKernel& kernel, std::span<const float> list) {
  const auto n = static_cast<std::size_t>(num_features());
  const auto [samples, are_uneven] = samples_to_fit(kernel, list);
  const std::size_t count = samples.size();
  std::vector<std::vector<double>> centred;
  std::vector<double> mean(n);
  for (const WeightedSample& sample : samples) {
    centred.push_back(features(sample.channels));
    for (std::size_t i = 0; i < n; ++i) mean[i] += sample.weight * centred.back()[i] / static_cast<double>(count);
  }
  Matrix covariance(n * n);
  Matrix coupling(n * n);
  for (std::vector<double>& row : centred) {
    for (std::size_t i = 0; i < n; ++i) row[i] -= mean[i];
  }
  std::vector<double> pulled(n);  // sum over b of K(a, b) f(b)
  const double per_sample = 1 / static_cast<double>(count);
  double variance = 0;  // E[K(a, a)] - E[K(a, b)]
  for (std::size_t a = 0; a < count; ++a) {
    const float* const sample = samples[a].channels;
    const double weight = samples[a].weight;
    std::fill(pulled.begin(), pulled.end(), 0.0);
    for (std::size_t b = 0; b < count; ++b) {
      const double k = samples[b].weight * kernel(sample, samples[b].channels);
      for (std::size_t j = 0; j < n; ++j) pulled[j] += k * centred[b][j];
      variance -= weight * k * per_sample * per_sample;
    }
    variance += weight * kernel(sample, sample) * per_sample;
    for (std::size_t i = 0; i < n; ++i) {
      const double pull = weight * centred[a][i];
      for (std::size_t j = 0; j < n; ++j) {
        covariance[i * n + j] += pull * centred[a][j] * per_sample;
        coupling[i * n + j] += pull * pulled[j] * per_sample * per_sample;
      }
    }
  }
  double trace = 0;
  for (std::size_t i = 0; i < n; ++i) trace += covariance[i * n + i];
  mixing_.assign(n * n, 0.0);
  if (!(trace > 1e-12)) return;  // all samples equal: nothing to couple
  // Features may depend on each other (x^3 + x y^2 + x z^2 = x on the sphere).
  // Of uneven samples, functions that hardly differ within the peak would be held to it by huge coefficients.
  const double ridge = are_uneven ? 1e-3 : 1e-9;
  for (std::size_t i = 0; i < n; ++i) covariance[i * n + i] += ridge * trace;
  const Matrix factor = cholesky(covariance, n);
  solve(factor, coupling, n);
  transpose(coupling, n);
  solve(factor, coupling, n);
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t j = 0; j < n; ++j) mixing_[i * n + j] = 0.5 * (coupling[i * n + j] + coupling[j * n + i]);
  }
  double held = 0;
  for (std::size_t k = 0; k < n * n; ++k) held += mixing_[k] * covariance[k];
  missed_ = variance > 0 ? std::clamp(1 - held / variance, 0.0, 1.0) : 0;
}

}  // namespace noiseloom
