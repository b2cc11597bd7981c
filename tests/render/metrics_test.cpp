// What is measured beside the root of the mean squared error.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "noiseloom/core/math.h"
#include "render/measures/measure_pass.h"
#include "render/pictures/flip.h"
#include "render/pictures/spectra.h"
#include "render/scene_support.h"

namespace noiseloom::render {
namespace {

Image waves(int width, int height, double cycles_x, double cycles_y) {
  Image image = make_image(width, height, 1);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      image.row(0, y)[x] = static_cast<float>(
          0.5 + 0.3 * std::cos(2 * std::numbers::pi * (cycles_x * x / width + cycles_y * y / height)));
  return image;
}

// By the definition, in double, window after window.
double slow_structural_error(const Image& a, const Image& b) {
  double sum = 0;
  for (int y = 0; y < a.height; ++y)
    for (int x = 0; x < a.width; ++x) {
      double weights = 0;
      double means[2] = {};
      double squares[2] = {};
      double product = 0;
      for (int dy = -5; dy <= 5; ++dy)
        for (int dx = -5; dx <= 5; ++dx) {
          const double weight = std::exp(-(dx * dx + dy * dy) / (2 * 1.5 * 1.5));
          const int from_x = (x + dx + 2 * a.width) % a.width;
          const int from_y = (y + dy + 2 * a.height) % a.height;
          const double va = static_cast<double>(a.row(0, from_y)[from_x]);
          const double vb = static_cast<double>(b.row(0, from_y)[from_x]);
          weights += weight;
          means[0] += weight * va;
          means[1] += weight * vb;
          squares[0] += weight * va * va;
          squares[1] += weight * vb * vb;
          product += weight * va * vb;
        }
      const double ma = means[0] / weights;
      const double mb = means[1] / weights;
      const double spread = squares[0] / weights - ma * ma + squares[1] / weights - mb * mb;
      sum += (2 * ma * mb + 1e-4) * (2 * (product / weights - ma * mb) + 9e-4) /
             ((ma * ma + mb * mb + 1e-4) * (spread + 9e-4));
    }
  return 1 - sum / static_cast<double>(a.pixels());
}

TEST(Metrics, StructuralSimilarityIsThatOfItsDefinition) {
  const Image a = waves(17, 13, 2, 1);
  const Image b = waves(17, 13, 3, 2);
  EXPECT_NEAR(structural_error(a, b, 1, Border::wrap, {}), slow_structural_error(a, b), 1e-5);
  EXPECT_NEAR(structural_error(a, a, 1, Border::wrap, {}), 0, 1e-6);
}

TEST(Metrics, ErrorsThatAreNoNumbersAreToldAndNoTableIsLeftOut) {
  const Scene scene = scene_of(
      "[image]\nwidth = 8\nheight = 8\nframes = 1\nrepeats = 1\noutputs = []\nmetrics = [\"unseen\"]\n[[noise]]\n"
      "kind = \"white\"\n[effects.integrand]\n[effects.sparse]\nimportance = \"flat\"\n");
  ThreadPool pool(1);
  Result result = render(scene, noises_of(scene), pool);
  EXPECT_EQ(results_text(result).find("integrand, share of pixels that no frame"), std::string::npos);
  result.squares.assign(result.squares.size(), std::numeric_limits<double>::quiet_NaN());
  EXPECT_NE(results_text(result).find("integrand, root of the mean squared error"), std::string::npos);
  Noise wrong = mask(8, 8, 1);
  Texture texture = *wrong.texture;
  texture.values[5] = std::numeric_limits<float>::quiet_NaN();
  wrong.texture = std::make_shared<const Texture>(std::move(texture));
  EXPECT_THROW(render(scene, {wrong}, pool), UserError);
}

Image of_colour(float red, float green, float blue) {
  Image image = make_image(40, 30, 3);
  for (int c = 0; c < 3; ++c) std::fill_n(image.row(c, 0), image.pixels(), c == 0 ? red : c == 1 ? green : blue);
  return image;
}

// By hand: pictures of one colour have no features, and 0.5 of sRGB is of the lightness 53.4 (100 - 53.4 = 46.6).
TEST(Metrics, FlipOfPlainPicturesIsThatOfTheirColours) {
  const auto flip = [](const Image& a, const Image& b) { return flip_error(a, b, 3, Border::clamp, {}); };
  const Image white = of_colour(1, 1, 1);
  EXPECT_EQ(flip(white, white), 0);
  EXPECT_NEAR(flip(of_colour(0, 1, 0), of_colour(0, 0, 1)), 1, 2e-3);  // the colours that are furthest apart
  const double largest = std::pow(201.4, 0.7);
  const double grey = std::pow(46.6, 0.7);
  EXPECT_NEAR(flip(white, of_colour(0.5F, 0.5F, 0.5F)), 0.95 * grey / (0.4 * largest), 0.02);
  EXPECT_EQ(flip(white, of_colour(0.5F, 0.5F, 0.5F)), flip(of_colour(0.5F, 0.5F, 0.5F), white));
}

// Of images that whole numbers make, by an implementation in NumPy that shares nothing with this one: two-dimensional
// kernels in double, the constants of the authors' program.
TEST(Metrics, FlipIsThatOfItsAuthors) {
  constexpr int width = 40;
  constexpr int height = 30;
  constexpr double usual = 0.7 * 3840 / 0.7 * math::pi / 180;
  const auto made = [&](const auto& code) {
    Image image = make_image(width, height, 3);
    for (int c = 0; c < 3; ++c)
      for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) image.row(c, y)[x] = static_cast<float>(code(x, y, c) / 255);
    return image;
  };
  const auto ramps = [](int x, int y, int c) { return (3 * x + 5 * y + 80 * c) % 256; };
  const Image colours = made([&](int x, int y, int c) { return 1.0 * ramps(x, y, c); });
  const Image noisy =
      made([&](int x, int y, int c) { return 0.75 * ramps(x, y, c) + 0.25 * ((37 * x + 91 * y + 53 * c) % 256); });
  const auto rings = [](int x, int y) { return (x * x + y * y) / 7 % 64 + 96; };
  const Image grey = made([&](int x, int y, int) { return 1.0 * rings(x, y); });
  const Image squares = made([&](int x, int y, int) { return rings(x, y) + (x / 3 + y / 3) % 2 * 24.0; });
  const auto flip = [](const Image& a, const Image& b, double pixels_per_degree) {
    return flip_error(a, b, 3, Border::clamp, {}, pixels_per_degree);
  };
  EXPECT_NEAR(flip(colours, noisy, usual), 0.439404, 2e-5);
  EXPECT_NEAR(flip(grey, squares, usual), 0.196853, 2e-5);
  EXPECT_NEAR(flip(colours, noisy, 20), 0.512024, 2e-5);
  EXPECT_NEAR(flip(grey, squares, 20), 0.187624, 2e-5);
}

// Noise that the eye blurs away differs less than noise of the same size that it sees.
TEST(Metrics, FlipSeesCoarseNoiseBeforeFineNoise) {
  Image grey = make_image(48, 48, 1);
  std::fill(grey.values.begin(), grey.values.end(), 0.5F);
  const auto with_squares = [&](int size) {
    Image image = grey;
    for (int y = 0; y < 48; ++y)
      for (int x = 0; x < 48; ++x) image.row(0, y)[x] += (x / size + y / size) % 2 == 0 ? 0.05F : -0.05F;
    return flip_error(image, grey, 1, Border::wrap, {});
  };
  EXPECT_LT(with_squares(1), 0.7 * with_squares(8));
}

TEST(Metrics, BandsHoldTheWavesOfTheirFrequenciesAndNoMean) {
  const std::pair<double, std::size_t> cases[] = {{2, 0}, {8, 1}, {20, 2}};  // of 64 pixels
  for (const auto& [cycles, band] : cases) {
    const std::array<double, 3> powers = powers_in_bands(waves(64, 64, cycles, 0));
    for (std::size_t b = 0; b < 3; ++b) EXPECT_NEAR(powers[b], b == band ? 0.3 * 0.3 / 2 : 0, 1e-6) << cycles;
  }
  EXPECT_EQ(powers_in_bands(make_image(8, 8, 1)), (std::array<double, 3>{}));
}

TEST(Metrics, SpectraOverTimeHoldWhatFlickers) {
  Texture errors = make_texture(Extents({32, 16, 32}), 1);
  for (const SliceIndex s : first_indices<SliceIndex>(32))
    for (std::size_t i = 0; i < 32 * 16; ++i)
      errors.slice(s)[i] = (s.value() % 2 == 0 ? 1.0F : -1.0F) * (i % 2 == 0 ? 1 : -1);
  const ErrorSpectrum fast = error_spectrum(errors, false);
  EXPECT_NEAR(fast.in_time[2], 1, 1e-6);
  EXPECT_NEAR(fast.bands[2], 1, 1e-6);
  for (const SliceIndex s : first_indices<SliceIndex>(32))
    for (std::size_t i = 0; i < 32 * 16; ++i) errors.slice(s)[i] = i % 2 == 0 ? 1 : -1;
  const ErrorSpectrum still = error_spectrum(errors, true);
  EXPECT_NEAR(still.in_time[0], 1, 1e-6);
  EXPECT_TRUE(error_spectrum(make_texture(Extents({8, 8, 2}), 1), false).is_empty());
}

const std::string identity =
    "[image]\nwidth = 32\nheight = 24\nframes = 4\nrepeats = 3\nmetrics = [\"deviation\", \"bands\", \"ssim\"]\n"
    "outputs = [\"curves\", \"spectra\"]\n[[noise]]\nkind = \"white\"\n[[noise]]\nkind = \"ign\"\n"
    "[effects.integrand]\n[filter.time]\nkernels = [\"ema\"]\n";

TEST(Metrics, BandsAddUpToTheDeviation) {
  const Result result = rendered(identity);
  for (std::size_t noise = 0; noise < 2; ++noise)
    for (int repeat = 0; repeat < 3; ++repeat) {
      const auto of = [&](Metric metric) { return result.of_repeat(metric, 0, noise, repeat, 1, 3); };
      EXPECT_NEAR(of(Metric::low) + of(Metric::middle) + of(Metric::high), of(Metric::deviation), 1e-7);
      EXPECT_LE(of(Metric::deviation), of(Metric::rmse));
      EXPECT_GT(of(Metric::ssim), 0.1);
    }
  EXPECT_EQ(result.spectra.size(), 4U);
  EXPECT_NE(results_csv(result).find(",predicted,deviation,ssim,low,middle,high\n"), std::string::npos);
  EXPECT_NE(spectra_csv(result).find("integrand,ign,ema,t,"), std::string::npos);
}

// An error that is the same everywhere is no deviation.
TEST(Metrics, DeviationLeavesOutTheMean) {
  Noise one = mask(1, 1, 1, "one");
  const Scene scene = scene_of(
      "[image]\nwidth = 8\nheight = 8\nframes = 1\nrepeats = 1\nmetrics = [\"deviation\"]\n[[noise]]\nkind = "
      "\"white\"\n[effects.integrand]\nfunction = \"step\"\nthreshold = 0.25\n");
  ThreadPool pool(1);
  const Result result = render(scene, {one}, pool);
  EXPECT_NEAR(result.rmse(0, 0, 0, 0).mean, 0.25, 1e-6);
  EXPECT_NEAR(result.value(Metric::deviation, 0, 0, 0, 0).mean, 0, 1e-7);
}

TEST(Metrics, OneWrongPixelMovesTheLargestErrorAlone) {
  Image difference = make_image(20, 15, 2);
  for (int i = 0; i < 300; ++i) {
    const int place = i * 7 % 300;
    difference.values[static_cast<std::size_t>(place)] = static_cast<float>(i % 2 == 0 ? i : -i);
  }
  const auto quantiles = quantiles_of_error(difference);
  EXPECT_NEAR(quantiles[0], 149 / std::sqrt(2.0), 1e-4);
  EXPECT_NEAR(quantiles[1], 297 / std::sqrt(2.0), 1e-4);
  EXPECT_NEAR(quantiles[2], 299 / std::sqrt(2.0), 1e-4);
  difference.values[299 * 7 % 300] = 1e6F;
  const auto with_firefly = quantiles_of_error(difference);
  EXPECT_EQ(with_firefly[0], quantiles[0]);
  EXPECT_EQ(with_firefly[1], quantiles[1]);
  EXPECT_NEAR(with_firefly[2], 1e6 / std::sqrt(2.0), 1);
  EXPECT_EQ(quantiles_of_error(make_image(1, 1, 3)), (std::array<double, 3>{}));
  const Result result = rendered(
      "[image]\nwidth = 40\nheight = 30\nframes = 1\nmetrics = [\"quantiles\"]\n[[noise]]\nkind = "
      "\"white\"\n[effects.integrand]\n");
  EXPECT_NEAR(result.value(Metric::median, 0, 0, 0, 0).mean, 0.25, 0.02);  // of what is even from -1/2 to 1/2
  EXPECT_NEAR(result.value(Metric::p99, 0, 0, 0, 0).mean, 0.495, 0.005);
  EXPECT_NEAR(result.value(Metric::largest, 0, 0, 0, 0).mean, 0.5, 0.002);
}

TEST(Metrics, AnExpectationNamesOneThatIsMeasured) {
  EXPECT_ANY_THROW(scene_of(identity + "[[expect]]\norder = \"ign < white\"\nmetric = \"unseen\"\n"));
  EXPECT_NO_THROW(scene_of(identity + "[[expect]]\norder = \"ign < white\"\nmetric = \"low\"\n"));
  const Scene scene = scene_of(identity + "[[expect]]\norder = \"ign < white\"\nmetric = \"low\"\ntime = \"ema\"\n");
  const auto checked = check_expectations(scene, rendered(scene));
  EXPECT_NE(checked[0].text.find("low of integrand"), std::string::npos);
}

}  // namespace
}  // namespace noiseloom::render
