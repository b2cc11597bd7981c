#include "render/world/surface.h"

#include <gtest/gtest.h>

#include <cmath>

#include "noiseloom/core/math.h"
#include "noiseloom/samples/sample_space.h"
#include "render/scene_support.h"

namespace noiseloom::render {
namespace {

Hit on_plane(double distance) { return {{distance, 0, 0}, {0, 1, 0}, Shape::plane}; }
Hit on_sphere(double x, double y, double z) { return {{x, 1 + y, z}, {x, y, z}, Shape::sphere}; }

Vector turned_to(Vector local, Vector normal) {
  const Frame frame = frame_of(normal);
  return local.x * frame.first + local.y * frame.second + local.z * normal;
}

TEST(Surface, AxesAreAcrossTheNormalAtThePolesToo) {
  for (const Vector n : {Vector{0, 0, 1}, Vector{0, 0, -1}, Vector{0, 1, -0.0}, Vector{0, 1, 0}, Vector{0.6, 0, -0.8},
                         Vector{0.48, 0.6, 0.64}}) {
    const Frame frame = frame_of(n);
    EXPECT_NEAR(dot(frame.first, n), 0, 1e-15);
    EXPECT_NEAR(dot(frame.second, n), 0, 1e-15);
    EXPECT_NEAR(dot(frame.first, frame.second), 0, 1e-15);
    EXPECT_NEAR(dot(frame.first, frame.first), 1, 1e-15);
    EXPECT_NEAR(dot(frame.second, frame.second), 1, 1e-15);
  }
}

TEST(Surface, OpenSharesAreSumsOverDirections) {
  constexpr int n = 500;
  for (const Hit& hit : {on_plane(0.5), on_plane(1), on_plane(2), on_sphere(0.6, 0.8, 0), on_sphere(0.8, -0.6, 0),
                         on_sphere(0, 1, 0), on_sphere(0, -1, 0)}) {
    double open = 0;
    for (int i = 0; i < n; ++i)
      for (int j = 0; j < n; ++j) {
        const double radius = std::sqrt((i + 0.5) / n);
        const Vector local = {radius * math::cos_2pi((j + 0.5) / n), radius * math::sin_2pi((j + 0.5) / n),
                              std::sqrt(1 - radius * radius)};
        open += is_hidden(hit, turned_to(local, hit.normal)) ? 0 : 1;
      }
    EXPECT_NEAR(open / (n * n), open_share(hit), 2e-3);
  }
  EXPECT_NEAR(open_share(on_plane(0.5)), 0.2845, 1e-4);
  EXPECT_NEAR(open_share(on_plane(1)), 0.6464, 1e-4);
  EXPECT_NEAR(open_share(on_plane(2)), 0.9106, 1e-4);
}

TEST(Surface, APlaneAloneIsOpen) {
  for (const double distance : {1e6, 1e9}) EXPECT_EQ(is_hidden(on_plane(distance), {-0.0, 1, 0}), false);
  EXPECT_NEAR(open_share(on_plane(1e6)), 1, 1e-15);
  // Along the plane itself, and just below it as rounded directions may be.
  EXPECT_FALSE(is_hidden(on_plane(3), {1, 0, 0}));
  EXPECT_FALSE(is_hidden(on_plane(3), {1, -1e-9, 0}));
}

TEST(Surface, SharedSolidAnglesOfCaps) {
  const double right = 0;  // the cosine of a right angle
  EXPECT_NEAR(shared_solid_angle(right, right, right), math::pi, 1e-12);
  EXPECT_NEAR(shared_solid_angle(right, 0.9, 1), math::two_pi * 0.1, 1e-12);
  EXPECT_EQ(shared_solid_angle(0.9, 0.95, 0), 0);
  EXPECT_NEAR(shared_solid_angle(right, 0.9, 0), math::pi * 0.1, 1e-12);  // half of the cap
  EXPECT_NEAR(shared_solid_angle(0.9, 0.9, 1), math::two_pi * 0.1, 1e-12);
}

TEST(Surface, PicturesHaveBothShapes) {
  ThreadPool pool(2);
  const Hits hits = make_hits(60, 40, pool);
  int sphere = 0;
  for (const Hit& hit : hits.hits) {
    EXPECT_NEAR(dot(hit.normal, hit.normal), 1, 1e-12);
    if (hit.shape == Shape::plane) {
      EXPECT_EQ(hit.place.y, 0);
    }
    sphere += hit.shape == Shape::sphere ? 1 : 0;
  }
  EXPECT_NEAR(sphere, math::pi * 10 * 10, 20);  // a circle of a third of the width
}

TEST(Surface, EdgeWeightsAddUpToOneAndKeepToTheirSurface) {
  ThreadPool pool(1);
  const Hits hits = make_hits(48, 40, pool);
  for (const std::vector<std::string>& edges :
       {std::vector<std::string>{"depth"}, {"normal"}, {"depth", "normal"}, {}}) {
    const SpaceFilterSpec filter{.kernel = SpaceKernel::box, .size = 5, .edges = edges};
    const EdgeWeights weights = make_edge_weights(hits, filter, Border::clamp);
    double across = 0;
    for (std::size_t i = 0; i < hits.hits.size(); ++i) {
      double sum = 0;
      for (const auto& plane : weights.taps) sum += static_cast<double>(plane[i]);
      EXPECT_NEAR(sum, 1, 1e-6);
    }
    // The picture of the shapes themselves.
    Image image = make_image(48, 40, 1);
    for (std::size_t i = 0; i < image.values.size(); ++i) image.values[i] = hits.hits[i].shape == Shape::sphere ? 1 : 0;
    const Image result = filtered(image, weights, Border::clamp);
    for (std::size_t i = 0; i < image.values.size(); ++i)
      across += std::fabs(static_cast<double>(result.values[i]) - static_cast<double>(image.values[i]));
    if (edges.empty()) {
      EXPECT_GT(across, 20);
      const Image plain = filtered(image, taps_of(filter), Border::clamp);
      for (std::size_t i = 0; i < image.values.size(); ++i) EXPECT_NEAR(result.values[i], plain.values[i], 1e-5);
    } else if (edges.size() == 2) {
      EXPECT_LT(across, 5);
    }
  }
}

const std::string on_surfaces =
    "[image]\nwidth = 24\nheight = 20\nframes = 300\nrepeats = 1\n[[noise]]\nkind = \"white\"\n[filter.time]\nkernels "
    "= "
    "[\"mc\"]\n[effects.soft-shadow]\n[effects.ambient-occlusion]\n";

// As in a volume: the error of the mean of 300 frames, where a bias would stay.
void expect_unbiased(const Scene& scene, const Noise& noise, std::size_t effect) {
  ThreadPool pool(2);
  const Result result = render(scene, {noise}, pool);
  EXPECT_NEAR(result.rmse(effect, 0, 1, scene.frames - 1).mean / result.rmse(effect, 0, 0, scene.frames - 1).mean,
              1 / std::sqrt(scene.frames), 0.012);
}

TEST(Surface, EstimatesFromNumbersAreUnbiased) {
  Scene scene = scene_of(on_surfaces);
  const Noise white = open_noise(scene.noises[0], "", nullptr);
  expect_unbiased(scene, white, 1);
  expect_unbiased(scene, white, 0);
  scene.occlusion.samples = 3;
  expect_unbiased(scene, white, 0);
  scene.occlusion.uniform = true;
  expect_unbiased(scene, white, 0);
  scene.shadow.radius = 30;
  expect_unbiased(scene, white, 1);
}

// Directions of every kind serve either estimate, and where they are of another density that is said.
TEST(Surface, EstimatesFromDirectionsAreUnbiased) {
  Scene scene = scene_of(on_surfaces);
  scene.shadow.on = false;
  for (const char* const space : {"sphere", "hemisphere", "hemisphere-cosine"}) {
    Texture texture = make_texture(Extents({32, 32, 300}), 3);
    SampleSpec samples;
    samples.space = space;
    const SampleSource source(samples, 32 * 32, 300, 7);
    for (const SliceIndex slice : first_indices<SliceIndex>(300)) {
      const std::vector<float> list = source.list(slice);
      const auto order = start_permutation(3, slice, 32 * 32);
      std::vector<float> places;
      for (const auto id : order)
        for (std::size_t c = 0; c < 3; ++c) places.push_back(list[3 * std::size_t{id.value()} + c]);
      interleaved_to_planar(places, 3, texture.slice(slice));
    }
    Noise noise = mask(1, 1, 1, "directions");
    noise.texture = std::make_shared<const Texture>(std::move(texture));
    noise.samples = samples;
    noise.channels = 3;
    for (const bool uniform : {false, true}) {
      scene.occlusion.uniform = uniform;
      expect_unbiased(scene, noise, 0);
      const bool is_cosine = std::string(space) == "hemisphere-cosine";
      EXPECT_EQ(notes_of_reading(scene, {noise}).size(), uniform == is_cosine ? 1U : 0U) << space;
    }
  }
}

}  // namespace
}  // namespace noiseloom::render
