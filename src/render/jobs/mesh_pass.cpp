#include "render/jobs/mesh_pass.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>

#include "noiseloom/core/math.h"
#include "render/jobs/job.h"
#include "render/jobs/scene_passes.h"
#include "render/jobs/scene_sizes.h"
#include "render/scene/view.h"
#include "render/world/mesh.h"

namespace noiseloom::render {
namespace {

// Groups of directions that know nothing of each other: how their means differ says how exact the mean of all is.
constexpr int groups = 4;
int in_group(const Scene& scene) { return scene.object.truth / groups; }

struct MeanOfGroups {
  double mean = 0;
  double square_of_error = 0;
};

// The mean of is_open(u, v) over numbers that fill the square evenly, moved to a place of their own in every pixel and
// group.
template <class IsOpen>
MeanOfGroups mean_of(int each, std::uint32_t effect, std::uint64_t pixel, const IsOpen& is_open) {
  constexpr double golden = 0.6180339887498949;
  std::array<double, groups> means{};
  for (std::size_t group = 0; group < groups; ++group) {
    const RandomBlock block = random_block(1, purpose_of_truth, effect, static_cast<std::uint32_t>(group), pixel);
    const double u = to_unit_double(block[0], block[1]);
    const double v = to_unit_double(block[2], block[3]);
    int open = 0;
    for (int i = 0; i < each; ++i) {
      const double place = v + i * golden;
      open += is_open((i + u) / each, place - std::floor(place)) ? 1 : 0;
    }
    means[group] = static_cast<double>(open) / each;
  }
  MeanOfGroups result;
  for (const double mean : means) result.mean += mean / groups;
  for (const double mean : means)
    result.square_of_error += (mean - result.mean) * (mean - result.mean) / (groups * (groups - 1));
  return result;
}

// The same for a pixel of the mesh whatever else is seen, so that what moves has the truth of what stays.
std::uint64_t number_of_pixel(std::int64_t x, std::int64_t y) {
  constexpr std::int64_t middle = std::int64_t{1} << 27;
  return (static_cast<std::uint64_t>(y + middle) << 28) + static_cast<std::uint64_t>(x + middle);
}

using IsOpen = std::function<bool(const Hit& hit, double u, double v)>;

Image shares_of(Shared& shared, Effect effect, const IsOpen& is_open) {
  const Scene& scene = shared.scene;
  const std::array<ViewSpan, 2> window = window_of(scene);
  const Mesh* const mesh = mesh_of(shared, shared.pass);
  Image image = make_image(static_cast<int>(window[0].size), static_cast<int>(window[1].size), 1);
  const double pixel = side_of_pixel(scene.width);
  std::vector<double> errors(static_cast<std::size_t>(image.height));
  shared.pool.for_each(image.height, [&](std::int64_t y, int) {
    for (int x = 0; x < image.width; ++x) {
      const Hit hit = hit_of(pixel, x - static_cast<double>(window[0].before) + 0.5 - 0.5 * scene.width,
                             0.5 * scene.height - (static_cast<double>(y - window[1].before)) - 0.5, mesh);
      const MeanOfGroups mean = mean_of(in_group(scene), static_cast<std::uint32_t>(effect),
                                        number_of_pixel(x - window[0].before, y - window[1].before),
                                        [&](double u, double v) { return is_open(hit, u, v); });
      image.row(0, static_cast<int>(y))[x] = static_cast<float>(mean.mean);
      errors[static_cast<std::size_t>(y)] += mean.square_of_error;
    }
  });
  count_of(*shared.counts, Work::primary_rays) += std::ssize(image.values);
  count_of(*shared.counts, Work::mesh_rays) += std::ssize(image.values) * groups * in_group(scene);
  double sum = 0;
  for (const double square : errors) sum += square;
  shared.notes.push_back(
      fmt::format("the truth of {} is a mean over {} directions of each pixel, and itself off by {:.2g} (rms)",
                  name_of(effect), groups * in_group(scene), std::sqrt(sum / static_cast<double>(image.pixels()))));
  return image;
}

}  // namespace

const Mesh* mesh_of(const Shared& shared, std::string_view reader) {
  return shared.scene.object.is_mesh() ? shared.mesh.get(Data::mesh, shared.pass_or(reader)).get() : nullptr;
}

SharesInFrame shares_in(const Shared& shared, const Job* job, std::string_view effect) {
  if (!shared.scene.object.is_mesh()) return {};
  if (job != nullptr && !shared.scene.motion.on) return {};  // truth asks for them, once for all frames
  const Shares& shares = shared.shares.get(Data::shares, shared.pass_or(effect));
  const int frame = job == nullptr ? 0 : static_cast<int>(job->frame);
  const std::array<int, 2> step = shared.scene.motion.on ? view_step(shared.scene) : std::array<int, 2>{};
  return {&shares, shares.left + frame * step[0], shares.top + frame * step[1]};
}

std::string off_without_mesh(const Scene& scene) {
  if (!scene.object.is_mesh()) return "object.shape is no mesh";
  return scene.motion.on ? applies : off_without_surfaces(scene);
}

std::string off_without_shares(const Scene& scene) {
  if (!scene.object.is_mesh()) return "object.shape is no mesh";
  return scene.occlusion.on || scene.shadow.on ? applies : "no ambient-occlusion and no soft-shadow";
}

void load_mesh(Shared& shared) {
  const ObjectSpec& object = shared.scene.object;
  const Mesh& mesh = *shared.mesh.make(std::make_unique<const Mesh>(object));
  if (mesh.num_left_out() > 0)
    shared.notes.push_back(fmt::format("{}: {} triangles without an area are left out, {} stay", object.file,
                                       mesh.num_left_out(), mesh.num_triangles()));
}

void find_shares(Shared& shared) {
  const Scene& scene = shared.scene;
  const std::array<ViewSpan, 2> window = window_of(scene);
  const Mesh* const mesh = mesh_of(shared, shared.pass);
  Shares shares{.left = static_cast<int>(window[0].before),
                .top = static_cast<int>(window[1].before),
                .of_sky = {},
                .of_sun = {}};
  if (scene.occlusion.on)
    shares.of_sky = shares_of(shared, Effect::occlusion, [&](const Hit& hit, double u, double v) {
      return !is_hidden(hit, turned(cosine_direction(u, v), hit.normal), mesh);
    });
  const double cos_radius = math::cos_2pi(scene.shadow.radius / 360);
  if (scene.shadow.on)
    shares.of_sun = shares_of(shared, Effect::shadow, [&](const Hit& hit, double u, double v) {
      return !is_in_shadow(hit, turned(direction_at(1 - u * (1 - cos_radius), v), sun_direction), mesh);
    });
  shared.shares.make(std::move(shares));
}

Counts work_of_shares(const Scene& scene, std::span<const Noise>) {
  Counts counts{};
  const std::int64_t asked = (scene.occlusion.on ? 1 : 0) + (scene.shadow.on ? 1 : 0);
  count_of(counts, Work::primary_rays) = asked * pixels_of_shares(scene);
  count_of(counts, Work::mesh_rays) = asked * pixels_of_shares(scene) * groups * in_group(scene);
  return counts;
}

std::int64_t bytes_of_mesh(const Scene& scene, std::span<const Noise>) { return bytes_of_mesh_in(scene.object); }

std::int64_t bytes_of_shares(const Scene& scene, std::span<const Noise>) {
  return 4 * pixels_of_shares(scene) * ((scene.occlusion.on ? 1 : 0) + (scene.shadow.on ? 1 : 0));
}

}  // namespace noiseloom::render
