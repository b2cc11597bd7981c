#include "noiseloom/measure/nets.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "noiseloom/samples/sample_space.h"

namespace noiseloom {
namespace {

SampleSpec sobol(int channels) {
  SampleSpec spec;
  spec.space = "sobol-owen";
  spec.parameters = {static_cast<double>(channels)};
  return spec;
}

std::vector<float> slices(const SampleSpec& spec, std::int64_t n, std::int32_t first, std::int32_t count,
                          std::uint64_t seed) {
  const SampleSource source(spec, n, first + count, seed);
  std::vector<float> points;
  for (std::int32_t s = first; s < first + count; ++s) {
    const std::vector<float> list = source.list(SliceIndex(s));
    points.insert(points.end(), list.begin(), list.end());
  }
  return points;
}

TEST(Nets, QualityOfKnownPoints) {
  EXPECT_EQ(net_quality(std::vector<float>{0.1F, 0.9F}, 2), 0);  // one point
  EXPECT_EQ(net_quality(std::vector<float>{0.1F, 0.9F, 0.6F, 0.2F}, 2), 0);
  EXPECT_EQ(net_quality(std::vector<float>{0.1F, 0.9F, 0.2F, 0.2F}, 2), 1);  // both in the left half
  EXPECT_EQ(net_quality(std::vector<float>{0.1F, 0.3F, 0.6F, 0.9F}, 1), 0);
  EXPECT_EQ(net_quality(std::vector<float>{0.1F, 0.2F, 0.6F, 0.9F}, 1), 1);  // halves are even, quarters are not
  EXPECT_EQ(net_quality(std::vector<float>{0.1F, 0.3F, 0.4F}, 1), std::nullopt);
  // The corners of the middle of each quarter: even in quarters, but not in strips.
  EXPECT_EQ(net_quality(std::vector<float>{0.3F, 0.3F, 0.3F, 0.7F, 0.7F, 0.3F, 0.7F, 0.7F}, 2), 1);
}

TEST(Nets, SlicesAndVolumesOfSobolAreNets) {
  for (const int channels : {1, 2}) {
    for (const int m : {0, 1, 5, 10}) {
      for (const std::uint64_t seed : {1U, 2U}) {
        const std::int64_t n = std::int64_t{1} << m;
        for (std::int32_t s = 0; s < 8; ++s)
          EXPECT_EQ(net_quality(slices(sobol(channels), n, s, 1, seed), channels), 0);
        EXPECT_EQ(net_quality(slices(sobol(channels), n, 0, 8, seed), channels), 0);
        EXPECT_EQ(net_quality(slices(sobol(channels), n, 4, 2, seed), channels), 0);  // an aligned run
      }
    }
  }
  EXPECT_EQ(net_quality(slices(sobol(2), 128 * 128, 0, 64, 1), 2), 0);
  // Sobol's own bounds: t is the sum of (degree of the polynomial - 1) over the dimensions: 0, 0, 1, 2.
  for (const auto& [channels, bound] : {std::pair(3, 1), std::pair(4, 3)}) {
    const std::optional<int> t = net_quality(slices(sobol(channels), 1024, 3, 1, 1), channels);
    ASSERT_TRUE(t);
    EXPECT_GE(*t, 1);
    EXPECT_LE(*t, bound);
  }
}

TEST(Nets, StrataAloneAreNoNets) {
  SampleSpec spec;
  spec.space = "vector2";
  EXPECT_GT(*net_quality(slices(spec, 1024, 0, 1, 1), 2), 0);
}

TEST(Nets, ScramblingDependsOnTheSeedAlone) {
  EXPECT_EQ(slices(sobol(2), 256, 0, 2, 7), slices(sobol(2), 256, 0, 2, 7));
  EXPECT_NE(slices(sobol(2), 256, 0, 2, 7), slices(sobol(2), 256, 0, 2, 8));
  // Each point is uniform: over many seeds, the mean of one coordinate is near one half.
  double sum = 0;
  for (std::uint64_t seed = 0; seed < 1000; ++seed) sum += static_cast<double>(slices(sobol(2), 1, 0, 1, seed)[0]);
  EXPECT_NEAR(sum / 1000, 0.5, 5 * 0.2887 / 31.6);
}

}  // namespace
}  // namespace noiseloom
