// A mask has no seam where it wraps around, and is free of its other side where it does not.
#include <algorithm>
#include <cmath>

#include "noiseloom/measure/quality.h"
#include "support/mask_texture.h"

namespace noiseloom {
namespace {

TEST(Torus, AShiftChangesNoSpectrum) {
  const VacSpec spec = testing_support::vac_spec({24, 20, 12}, {{0, 1}, {2}});
  const std::vector<std::uint64_t> places = mask_places(spec);
  std::vector<std::uint64_t> moved(places.size());
  for (std::uint64_t p = 0; p < places.size(); ++p)
    moved[testing_support::shifted(spec.extents, p, {7, 19, 5})] = places[p];
  const auto spectra = [&](const std::vector<std::uint64_t>& of) {
    return spectral_quality(mask_texture(spec.extents, of), DistanceKind::absolute, nullptr);
  };
  const SpectralQuality before = spectra(places);
  const SpectralQuality after = spectra(moved);
  ASSERT_EQ(before.groups.size(), 2U);
  for (std::size_t g = 0; g < 2; ++g)
    for (std::size_t i = 0; i < before.groups[g].spectrum.power.size(); ++i)
      ASSERT_NEAR(after.groups[g].spectrum.power[i], before.groups[g].spectrum.power[i], 1e-12);
  // Turned around inside the slices alone, the mask is another one over time.
  for (std::uint64_t p = 0; p < places.size(); ++p)
    moved[p] = p / 480 % 2 == 0 ? places[p] : places[p / 480 * 480 + 479 - p % 480];
  EXPECT_GT(std::abs(spectra(moved).groups[1].first_bins[0] - before.groups[1].first_bins[0]), 1e-3);
}

// The values of a mask in layers across one axis.
class Layers {
 public:
  Layers(const Extents& extents, const std::vector<std::uint64_t>& places, int axis)
      : layers_(static_cast<std::size_t>(extents.size(axis))) {
    std::size_t stride = 1;
    for (int a = 0; a < axis; ++a) stride *= static_cast<std::size_t>(extents.size(a));
    for (std::size_t p = 0; p < places.size(); ++p)
      layers_[p / stride % layers_.size()].push_back(static_cast<double>(places[p]));
  }
  std::size_t count() const { return layers_.size(); }
  // Pearson's correlation of the pixels of two layers that face each other. Each layer's own mean is taken away: at an
  // edge that is free, early pixels gather.
  double correlation(std::size_t i, std::size_t j) const {
    const std::vector<double>& a = layers_[i % count()];
    const std::vector<double>& b = layers_[j % count()];
    const double n = static_cast<double>(a.size());
    double ma = 0, mb = 0, aa = 0, bb = 0, ab = 0;
    for (std::size_t k = 0; k < a.size(); ++k) {
      ma += a[k] / n;
      mb += b[k] / n;
    }
    for (std::size_t k = 0; k < a.size(); ++k) {
      aa += (a[k] - ma) * (a[k] - ma);
      bb += (b[k] - mb) * (b[k] - mb);
      ab += (a[k] - ma) * (b[k] - mb);
    }
    return ab / std::sqrt(aa * bb);
  }

 private:
  std::vector<std::vector<double>> layers_;
};

struct Moments {
  double mean = 0;
  double deviation = 0;
};
Moments moments_of(const std::vector<double>& values) {
  Moments m;
  for (const double v : values) m.mean += v / static_cast<double>(values.size());
  for (const double v : values) m.deviation += (v - m.mean) * (v - m.mean) / static_cast<double>(values.size() - 1);
  m.deviation = std::sqrt(m.deviation);
  return m;
}

// Of all pairs of layers `lag` apart that the seam does not separate.
Moments inside(const Layers& layers, std::size_t lag) {
  std::vector<double> values;
  for (std::size_t i = 0; i + lag < layers.count(); ++i) values.push_back(layers.correlation(i, i + lag));
  return moments_of(values);
}

// A pair across the seam is told from one inside, or from one that nothing couples, where it lies this many of their
// standard deviations from their mean. Those are taken from at least 16 pairs: odds of a false alarm below 2e-4 for
// each comparison (Student's t), and the seed is fixed.
constexpr double slack = 5;
const std::vector<std::int64_t> sizes = {64, 64, 32};

TEST(Torus, NeighboursAcrossTheSeamAreAsThoseInside) {
  if (testing_support::under_sanitizers) GTEST_SKIP() << "131072 pixels take ten seconds under sanitizers";
  const VacSpec spec = testing_support::vac_spec(sizes, {{0, 1}, {2}});
  const std::vector<std::uint64_t> places = mask_places(spec);
  for (int axis = 0; axis < 3; ++axis) {
    const Layers layers(spec.extents, places, axis);
    for (const std::size_t lag : {std::size_t{1}, std::size_t{2}, std::size_t{3}}) {
      const Moments usual = inside(layers, lag);
      for (std::size_t i = layers.count() - lag; i < layers.count(); ++i)
        EXPECT_NEAR(layers.correlation(i, i + lag), usual.mean, slack * usual.deviation) << axis << " " << lag;
    }
    // What the test can see: neighbours do repel each other.
    EXPECT_LT(inside(layers, 1).mean, -slack * inside(layers, 1).deviation) << axis;
  }
}

TEST(Torus, TheSeamOfABoundedAxisIsFree) {
  if (testing_support::under_sanitizers) GTEST_SKIP() << "131072 pixels take ten seconds under sanitizers";
  for (int bounded = 0; bounded < 3; ++bounded) {
    VacSpec spec = testing_support::vac_spec(sizes, {{0, 1}, {2}});
    spec.toroidal = {true, true, true};
    spec.toroidal[static_cast<std::size_t>(bounded)] = false;
    const std::vector<std::uint64_t> places = mask_places(spec);
    for (int axis = 0; axis < 3; ++axis) {
      const Layers layers(spec.extents, places, axis);
      const std::size_t last = layers.count() - 1;
      const Moments usual = inside(layers, 1);
      const double across = layers.correlation(last, last + 1);
      if (axis != bounded) {
        EXPECT_NEAR(across, usual.mean, slack * usual.deviation) << bounded << " " << axis;
        continue;
      }
      std::vector<double> strangers;  // pairs half the axis apart
      for (std::size_t i = 0; i < layers.count() / 2; ++i)
        strangers.push_back(layers.correlation(i, i + layers.count() / 2));
      EXPECT_NEAR(across, 0, slack * moments_of(strangers).deviation) << axis;
      EXPECT_GT(across, usual.mean + slack * usual.deviation) << axis;
    }
  }
}

}  // namespace
}  // namespace noiseloom
