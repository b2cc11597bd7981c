// Power at low frequencies: what is measured, and how blue the library's masks are.
#include "noiseloom/measure/quality.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include "support/mask_texture.h"

namespace noiseloom {
namespace {

using testing::HasSubstr;

const GroupQuality& group_of(const SpectralQuality& quality, const std::string& name) {
  for (const GroupQuality& group : quality.groups)
    if (group.name == name) return group;
  throw std::out_of_range(name);
}

SpectralQuality quality_of(const VacSpec& spec) {
  return spectral_quality(mask_texture(spec.extents, mask_places(spec)), DistanceKind::absolute, nullptr);
}

TEST(SpectralQuality, OfWhiteNoiseIsOne) {
  const Texture texture = start_texture(small_config("uniform", "x = 64, y = 64, t = 64"));
  const SpectralQuality quality = spectral_quality(texture, DistanceKind::absolute, nullptr);
  ASSERT_EQ(quality.groups.size(), 2U);
  // 64 slices of 28 frequencies, half of them free: a standard deviation of 1 / sqrt(896) = 0.033; five of them, odds
  // of 6e-7. Along t 4096 lines: 1 / 64, for each bin.
  EXPECT_NEAR(group_of(quality, "xy").low_frequency_power, 1, 0.17);
  ASSERT_EQ(group_of(quality, "t").first_bins.size(), 3U);
  for (const double power : group_of(quality, "t").first_bins) EXPECT_NEAR(power, 1, 5.0 / 64);
}

TEST(SpectralQuality, MeasuresWhatTheFilterGroupsAndEverySliceAxis) {
  const RunConfig config = mask_config(Extents({8, 8, 3, 1, 5}));
  Texture texture = make_texture(config.problem.extents, 1);
  for (std::size_t i = 0; i < texture.values.size(); ++i) texture.values[i] = static_cast<float>(i * 7 % 11);
  const SpectralQuality quality = spectral_quality(texture, DistanceKind::absolute, &config.problem.filter);
  std::vector<std::string> names;
  for (const GroupQuality& group : quality.groups) names.push_back(group.name);
  EXPECT_THAT(names, testing::ElementsAre("xy", "t", "w", "tw"));
  EXPECT_EQ(group_of(quality, "t").first_bins.size(), 1U);
  EXPECT_EQ(group_of(quality, "w").first_bins.size(), 2U);
  EXPECT_TRUE(group_of(quality, "tw").first_bins.empty());
  EXPECT_TRUE(std::isnan(group_of(quality, "tw").low_frequency_power));
  EXPECT_THAT(quality_json(quality), HasSubstr("\"low_frequency_power\": {\"xy\": null, \"t\": null, \"w\": null, "
                                               "\"tw\": null}, \"first_bins\": {\"t\": ["));
  EXPECT_EQ(quality_text(quality).find("nan"), std::string::npos);
  const SpectralQuality small = spectral_quality(texture, DistanceKind::absolute, &config.problem.filter, 15);
  EXPECT_EQ(small.groups.size(), 3U);
  EXPECT_THAT(small.left_out, testing::ElementsAre("xy"));
}

// The bounds are those that a mask of the method must keep (the same figures come from tests/bench/mask_quality.py,
// which shares no code with this).
TEST(MaskQuality, OfSlicesOf64x64x16IsWithinItsBound) {
  const SpectralQuality quality = quality_of(testing_support::vac_spec({64, 64, 16}, {{0, 1}, {2}}));
  EXPECT_LE(group_of(quality, "xy").low_frequency_power, 4.5e-4);
}

TEST(MaskQuality, Of256x256IsWithinItsBound) {
  if (testing_support::under_sanitizers) GTEST_SKIP() << "takes half a minute under sanitizers; 64x64x16 stands for it";
  const SpectralQuality quality = quality_of(testing_support::vac_spec({256, 256}, {{0, 1}}));
  EXPECT_LE(group_of(quality, "xy").low_frequency_power, 3e-5);
}

TEST(MaskQuality, Of128x128x32IsWithinItsBoundsOverSpaceAndTime) {
  if (testing_support::under_sanitizers) GTEST_SKIP() << "takes half a minute under sanitizers; 64x64x16 stands for it";
  const SpectralQuality quality = quality_of(testing_support::vac_spec({128, 128, 32}, {{0, 1}, {2}}));
  EXPECT_LE(group_of(quality, "xy").low_frequency_power, 4.5e-4);
  const std::vector<double>& bins = group_of(quality, "t").first_bins;
  ASSERT_EQ(bins.size(), 3U);
  EXPECT_LE(bins[0], 0.017);
  EXPECT_LE(bins[1], 0.026);
  EXPECT_LE(bins[2], 0.05);
}

}  // namespace
}  // namespace noiseloom
