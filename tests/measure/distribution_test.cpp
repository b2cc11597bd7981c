// A warning where values are not distributed as the samples are, and none where they are, whoever made them.
#include "noiseloom/measure/distribution.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "noiseloom/image/encoding.h"
#include "noiseloom/samples/space.h"
#include "support/run_files.h"

namespace noiseloom {
namespace {

using testing::HasSubstr;

constexpr const char* all_samples[] = {"uniform", "tent",    "gauss",  "circle",     "vector2",
                                       "vector3", "vector5", "sphere", "hemisphere", "hemisphere-cosine",
                                       "disk"};

std::string warning_for(const Texture& texture, const std::string& samples) {
  return distribution_warning(texture, small_config(samples).problem.samples);
}

// Samples drawn one by one, without strata: as uneven as chance makes them.
Texture random_texture(const RunConfig& config, unsigned seed) {
  Texture texture = start_texture(config);
  const SampleSpace& space = sample_space(config.problem.samples);
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> unit(1e-9, 1 - 1e-9);
  const std::size_t cells = static_cast<std::size_t>(texture.extents.cells_per_slice());
  std::vector<float> sample(static_cast<std::size_t>(texture.channels));
  for (const SliceIndex s : texture.extents.slices())
    for (std::size_t cell = 0; cell < cells; ++cell) {
      std::vector<double> jitter(static_cast<std::size_t>(space.traits().dimensions));
      for (double& j : jitter) j = unit(random);
      space.sample(1, 0, jitter.data(), sample.data());
      for (std::size_t c = 0; c < sample.size(); ++c) texture.slice(s)[c * cells + cell] = sample[c];
    }
  return texture;
}

TEST(Distribution, OfSamplesFits) {
  for (const char* const samples : all_samples) {
    const RunConfig config = small_config(samples, "x = 61, y = 53, t = 3");
    EXPECT_EQ(distribution_warning(start_texture(config), config.problem.samples), "") << samples;
    for (unsigned seed = 1; seed <= 3; ++seed)  // each fails with odds of one in a million
      EXPECT_EQ(distribution_warning(random_texture(config, seed), config.problem.samples), "") << samples;
  }
}

TEST(Distribution, FitsAsCodesOfEightBits) {
  for (const char* const samples : {"uniform", "tent", "vector2", "sphere", "disk", "hemisphere-cosine"}) {
    const RunConfig config = small_config(samples, "x = 128, y = 128, t = 9");  // the bound is below a code's width
    Texture texture = start_texture(config);
    const ValueRange range = *natural_range(config.problem.samples);
    for (float& v : texture.values)
      v = static_cast<float>(from_unit(range, dequantise(quantise(to_unit(range, static_cast<double>(v)), 8), 8)));
    EXPECT_EQ(distribution_warning(texture, config.problem.samples), "") << samples;
  }
}

template <class Change>
std::string warning_after(const std::string& samples, Change change) {
  Texture texture = start_texture(small_config(samples, "x = 61, y = 53"));
  for (float& v : texture.values) v = static_cast<float>(change(static_cast<double>(v)));
  return warning_for(texture, samples);
}

TEST(Distribution, IsChangedByGammaContrastAndThresholds) {
  const auto gamma = [](double v) { return std::pow(v, 1.8); };
  const auto inverse_gamma = [](double v) { return std::pow(v, 1 / 1.8); };
  const auto contrast = [](double v) { return 0.08 + 0.84 * v; };
  const auto stretched = [](double v) { return std::clamp(1.2 * (v - 0.5) + 0.5, 0.0, 1.0); };
  const auto tones = [](double v) { return v < 0.3 ? 0.25 : 0.75; };
  for (const char* const samples : {"uniform", "circle", "vector3", "tent"}) {
    EXPECT_THAT(warning_after(samples, gamma), HasSubstr("not distributed as samples")) << samples;
    EXPECT_THAT(warning_after(samples, inverse_gamma), HasSubstr("not distributed")) << samples;
    if (std::string(samples) != "tent") {  // few of its values lie where these two change any
      EXPECT_THAT(warning_after(samples, contrast), HasSubstr("they reach from 0.08")) << samples;
      EXPECT_THAT(warning_after(samples, stretched), HasSubstr("not distributed")) << samples;
    }
    EXPECT_THAT(warning_after(samples, tones), HasSubstr("in 2 tones")) << samples;
  }
  EXPECT_THAT(warning_after("disk", [](double v) { return 0.6 * v; }), HasSubstr("of channel 0"));
}

TEST(Distribution, OfOneSpaceIsNotThatOfAnother) {
  const auto texture = [](const char* const samples) { return start_texture(small_config(samples, "x = 61, y = 53")); };
  EXPECT_NE(warning_for(texture("tent"), "uniform"), "");
  EXPECT_NE(warning_for(texture("uniform"), "tent"), "");
  EXPECT_NE(warning_for(texture("hemisphere"), "sphere"), "");
  EXPECT_NE(warning_for(texture("hemisphere-cosine"), "hemisphere"), "");
  EXPECT_NE(warning_for(texture("hemisphere"), "hemisphere-cosine"), "");
}

TEST(Distribution, OfGaussIsKnownUpToShiftAndScaleWhereItIsCoded) {
  EXPECT_EQ(warning_after("gauss", [](double v) { return 0.5 + v / 10; }), "");
  EXPECT_NE(warning_after("gauss", [](double v) { return 2 * v; }), "");
  EXPECT_NE(warning_after("gauss", [](double v) { return 0.5 + std::atan(3 * v) / 4; }), "");
}

}  // namespace
}  // namespace noiseloom
