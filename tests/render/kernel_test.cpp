// Effects that draw from a kernel, a sky or a map.
#include "render/world/kernel.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

#include "noiseloom/core/error.h"
#include "noiseloom/core/random.h"
#include "noiseloom/files/image_decoder.h"
#include "noiseloom/samples/sample_space.h"
#include "render/scene_support.h"
#include "render/world/sky_light.h"

namespace noiseloom::render {
namespace {

TEST(MassTable, EachTexelIsDrawnWithTheChanceOfItsMass) {
  const std::vector<double> masses = {0, 1, 2, 0, 0, 0, 4, 0, 1};
  const MassTable table(3, 3, masses);
  std::vector<double> found(9);
  constexpr int n = 480;
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i) {
      const Texel texel = table.at((i + 0.5) / n, (j + 0.5) / n);
      found[static_cast<std::size_t>(texel.y * 3 + texel.x)] += 1.0 / (n * n);
    }
  for (int y = 0; y < 3; ++y)
    for (int x = 0; x < 3; ++x) {
      const auto i = static_cast<std::size_t>(y * 3 + x);
      EXPECT_NEAR(found[i], masses[i] / 8, 0.003);
      EXPECT_NEAR(table.mass({x, y}), masses[i] / 8, 1e-12);
    }
  constexpr double last = 1 - 0x1p-24;
  EXPECT_EQ(table.at(last, last).x, 2);
  EXPECT_EQ(table.at(0, 0).x, 1);
}

// What is biased would stay in the mean of many frames.
void expect_unbiased_mean(const std::string& effect, const std::string& noise, const Noise* texture = nullptr) {
  const Scene scene =
      scene_of("[image]\nwidth = 24\nheight = 20\nframes = 200\nrepeats = 1\noutputs = [\"curves\"]\n[[noise]]\n" +
               noise + "\n[filter.time]\nkernels = [\"mc\"]\n" + effect);
  ThreadPool pool(2);
  const Result result = texture == nullptr ? rendered(scene) : render(scene, {*texture}, pool);
  double square = 0;  // of one frame: of all of them, as a few bright samples are most of it
  for (int frame = 0; frame < 200; ++frame) square += result.square(0, 0, 0, 0, frame) / 200;
  EXPECT_NEAR(result.rmse(0, 0, 1, 199).mean / std::sqrt(square), 1 / std::sqrt(200.0), 0.011) << effect << noise;
}

// Points of a space in an order that is white over the picture and over time.
Noise points_of(const std::string& space, std::int32_t slices) {
  SampleSpec samples;
  samples.space = space;
  Texture texture = make_texture(Extents({32, 32, slices}), 2);
  const SampleSource source(samples, 32 * 32, slices, 3);
  for (const SliceIndex slice : first_indices<SliceIndex>(slices)) {
    const std::vector<float> list = source.list(slice);
    const auto order = start_permutation(5, slice, 32 * 32);
    std::vector<float> places;
    for (const auto id : order)
      for (std::size_t c = 0; c < 2; ++c) places.push_back(list[2 * std::size_t{id.value()} + c]);
    interleaved_to_planar(places, 2, texture.slice(slice));
  }
  Noise noise = mask(1, 1, 1, space);
  noise.texture = std::make_shared<const Texture>(std::move(texture));
  noise.samples = samples;
  noise.channels = 2;
  return noise;
}

TEST(Convolution, EstimatesAreUnbiased) {
  for (const char* const kernel : {"disk", "hexagon", "star", "gauss"}) {
    const std::string effect = std::string("[effects.convolution]\nsize = 9\nkernel = \"") + kernel + "\"\n";
    expect_unbiased_mean(effect, "kind = \"white\"");
    expect_unbiased_mean(effect, "kind = \"white\"\nimportance = false");
    if (kernel == std::string("gauss")) continue;
    const Noise points = points_of(kernel, 200);
    expect_unbiased_mean(effect, "kind = \"white\"", &points);
  }
}

TEST(Convolution, AKernelOfOnePixelIsThePicture) {
  const Result result = rendered(
      "[image]\nwidth = 20\nheight = 20\nframes = 2\n[[noise]]\nkind = \"white\"\n[effects.convolution]\nsize = 1\n");
  for (const double square : result.squares) EXPECT_EQ(square, 0);
  EXPECT_EQ(result.truths[0].values, picture_of_lights(20, 20).values);
}

TEST(Sky, EstimatesAreUnbiased) {
  expect_unbiased_mean("[effects.sky]\n", "kind = \"white\"");
  expect_unbiased_mean("[effects.sky]\n", "kind = \"white\"\nimportance = false");
}

// The first frame is that of a sky that stands; in the fifth it has turned around; between them the error of a mean
// over frames falls as that of independent estimates, which none does that is off.
TEST(Sky, TurnsByCellsAndStaysUnbiased) {
  const auto scene = [](const char* sky) {
    return std::string(
               "[image]\nwidth = 24\nheight = 20\nframes = 49\noutputs = [\"curves\", \"images\"]\n[[noise]]\nkind = "
               "\"white\"\n[[noise]]\nname = \"even\"\nkind = \"white\"\nimportance = false\n[effects.sky]\n") +
           sky + "[filter.time]\nkernels = [\"mc\"]\n";
  };
  const Result still = rendered(scene(""));
  for (const char* const turn : {"turn = 16\n", "turn = -16\n"}) {
    const Result turning = rendered(scene(turn));
    for (std::size_t noise = 0; noise < 2; ++noise) {
      EXPECT_EQ(turning.rmse(0, noise, 0, 0).mean, still.rmse(0, noise, 0, 0).mean);
      double squares = 0;
      for (int frame = 0; frame < 49; ++frame) squares += turning.square(0, noise, 0, 0, frame) / 49;
      EXPECT_NEAR(std::sqrt(turning.square(0, noise, 0, 1, 48) / squares), 1.0 / 7, 0.1 / 7);
    }
    for (std::size_t i = 0; i < still.truths[0].values.size(); ++i)  // of frame 49
      ASSERT_NEAR(turning.truths[0].values[i], still.truths[0].values[i], 1e-5F);
  }
}

TEST(Sky, HasAsManyCellsAsAreAskedFor) {
  const SkyLight few = make_sky({.on = true, .file = "", .columns = 16});
  EXPECT_EQ(few.cells.width(), 16);
  EXPECT_EQ(few.cells.height(), 4);
  const SkyLight all = make_sky({.on = true, .file = "", .columns = 512});
  EXPECT_EQ(all.cells.width(), 64);
  EXPECT_EQ(most_cells({.on = true, .file = "", .columns = 512}), 64 * 16);
  EXPECT_EQ(all.turned({63, 3}, 1).x, 0);
  EXPECT_EQ(all.turned({0, 3}, -129).x, 63);
}

TEST(Sky, LightsAnOpenPlaneWithItsBrightness) {
  const SkyLight sky = make_sky({});
  double brightness = 0;
  double solid = 0;
  for (std::size_t i = 0; i < sky.directions.size(); ++i) {
    EXPECT_NEAR(dot(sky.directions[i], sky.directions[i]), 1, 1e-12);
    brightness +=
        (0.2126 * sky.light[i][0] + 0.7152 * sky.light[i][1] + 0.0722 * sky.light[i][2]) * sky.directions[i].y;
    solid += sky.solid_angles[i];
    const Texel cell = sky.cell_of(sky.directions[i]);
    EXPECT_EQ(sky.index(cell), i);
  }
  EXPECT_NEAR(brightness, 0.8, 1e-9);
  EXPECT_NEAR(solid, 2 * 3.14159265358979, 1e-6);
}

// Directions by brightness, those below a height turned to the zenith, in slices of 32 x 32.
Noise directions_of(const SkyLight& sky, double least_height, std::int32_t slices) {
  Texture texture = make_texture(Extents({32, 32, slices}), 3);
  for (const SliceIndex slice : first_indices<SliceIndex>(slices))
    for (std::size_t i = 0; i < 1024; ++i) {
      const RandomBlock drawn = random_block(7, Purpose::jitter, static_cast<std::uint32_t>(slice), 0, i);
      const Texel cell = sky.cells.at(static_cast<double>(drawn[0]) * 0x1p-32, static_cast<double>(drawn[1]) * 0x1p-32);
      Vector direction = sky.directions[sky.index(cell)];
      if (direction.y < least_height) direction = {0, 1, 0};
      texture.slice(slice)[i] = static_cast<float>(direction.x);
      texture.slice(slice)[1024 + i] = static_cast<float>(direction.y);
      texture.slice(slice)[2048 + i] = static_cast<float>(direction.z);
    }
  Noise noise = mask(1, 1, 1, "tex");
  noise.texture = std::make_shared<const Texture>(std::move(texture));
  noise.samples.space = "image";
  noise.samples.onto = ImageDomain::hemisphere;
  noise.channels = 3;
  return noise;
}

std::string error_of_directions(const Noise& noise, const SkyLight& sky) {
  try {
    check_directions(noise, sky);
  } catch (const UserError& error) {
    return error.what();
  }
  return "";
}

TEST(Sky, DirectionsOfAnotherSkyAreRefused) {
  const SkyLight sky = make_sky({});
  for (const std::int32_t slices : {1, 20}) {
    EXPECT_EQ(error_of_directions(directions_of(sky, 0, slices), sky), "");
    EXPECT_NE(error_of_directions(directions_of(sky, 0.3, slices), sky).find("made for another image"),
              std::string::npos);
  }
}

// Of an odd number of rows: half of the middle one lies above the horizon.
TEST(Sky, OfAnImageIsAllThatLiesAboveItsHorizon) {
  set_image_decoder([](const std::string& name) {
    std::vector<float> light(9 * 7, 0.5F);
    for (std::size_t i = 0; i < light.size(); ++i)
      if (name == "half" && i % 9 < 4) light[i] = 0;
    return std::make_shared<const InputArray>(InputArray{{7, 9, 1}, light});
  });
  SampleSpec samples;
  samples.space = "image";
  samples.file = "sky.png";
  samples.onto = ImageDomain::hemisphere;
  SkySpec spec;
  spec.file = samples.file;
  const SkyLight sky = make_sky(spec);
  EXPECT_NEAR(std::accumulate(sky.solid_angles.begin(), sky.solid_angles.end(), 0.0), 2 * 3.14159265358979, 1e-6);
  const SampleSource source(samples, 64 * 64, 1, 3);
  Noise noise = mask(1, 1, 1, "tex");
  Texture texture = make_texture(Extents({64, 64}), 3);
  interleaved_to_planar(source.list(SliceIndex(0)), 3, texture.slice(SliceIndex(0)));
  noise.texture = std::make_shared<const Texture>(std::move(texture));
  noise.samples = samples;
  noise.channels = 3;
  EXPECT_EQ(error_of_directions(noise, sky), "");
  // A scene whose sky is black on the left is not rendered with them.
  Scene scene = scene_of(
      "[image]\nwidth = 8\nheight = 8\nframes = 1\nrepeats = 1\noutputs = []\n[[noise]]\nkind = \"white\"\n"
      "[effects.sky]\n");
  scene.sky.file = "half";
  ThreadPool pool(1);
  EXPECT_THROW(render(scene, {noise}, pool), UserError);
  set_image_decoder(nullptr);
}

TEST(Sparse, WhiteNoiseLeavesThePowerOfWhatItMisses) {
  const Result result = rendered(
      "[image]\nwidth = 200\nheight = 150\nframes = 5\nrepeats = 2\nmetrics = [\"unseen\"]\n[[noise]]\nkind = "
      "\"white\"\n[[noise]]\nkind = \"golden-ratio\"\n[effects.sparse]\nimportance = \"flat\"\nlevel = 0.25\n");
  for (int frame = 0; frame < 5; ++frame)
    EXPECT_NEAR(result.value(Metric::unseen, 0, 0, 0, frame).mean, std::pow(0.75, frame + 1), 0.006);
  // What moves on by the golden ratio meets a quarter of 0 to 1 within five frames, wherever it begins.
  EXPECT_EQ(result.value(Metric::unseen, 0, 1, 0, 4).mean, 0);
  EXPECT_NEAR(result.rmse(0, 0, 0, 0).mean, std::sqrt(0.25 * 0.75), 0.004);
}

}  // namespace
}  // namespace noiseloom::render
