// The sphere and the plane under a sky, by one direction a pixel and frame: light of the direction, times the cosine,
// if it is open, over the chance with which the direction is drawn. Directions are the cells of the sky.
//
//   drawn by brightness (the default)   with the chance of the cell's light
//   drawn evenly                        all of the same density over the hemisphere
//
// Textures of the sky's image onto the hemisphere hold directions drawn by brightness. Where the sky turns, cells and
// directions of textures turn with it, and the truth of every frame is the sum over all cells, found once.
#include <algorithm>
#include <cmath>
#include <numeric>

#include "noiseloom/core/error.h"
#include "render/effects/effect-inl.h"
#include "render/jobs/effect_list.h"
#include "render/jobs/mesh_pass.h"
#include "render/jobs/scene_passes.h"
#include "render/jobs/scene_sizes.h"
#include "render/world/sky_light.h"

namespace noiseloom::render {
namespace {

bool holds_directions_of_sky(const Scene& scene, const Noise& noise) {
  return !scene.sky.file.empty() && has_texture(noise.spec.kind) && noise.samples.is_image() &&
         noise.samples.onto == ImageDomain::hemisphere;
}

int numbers_of_sky(const Scene& scene, const Noise& noise) {
  return holds_directions_of_sky(scene, noise) ? 3 : if_numbers(2, noise);
}

struct SkyEffect : PlainEffect {
  SkyEffect(const Shared& shared, int, const Job* job)
      : hits(&shared.hits.get(Data::hits, shared.pass_or("sky"))),
        sky(&shared.sky.get(Data::sky, shared.pass_or("sky"))),
        mesh(mesh_of(shared, "sky")) {
    if (job == nullptr) return;
    if (shared.scene.sky.turn != 0) {
      turn = job->frame * shared.scene.sky.turn;
      const std::vector<Image>& truths = shared.sky_truths.get(Data::sky_truths, shared.pass_or("sky"));
      truth_of_frame = &truths[static_cast<std::size_t>(job->frame) % truths.size()];
    }
    const Noise& noise = job->noise_of_job();
    is_direction = holds_directions_of_sky(shared.scene, noise);
    numbers_of_pixel = numbers_of_sky(shared.scene, noise);
    by_light = is_direction || noise.spec.importance;
  }

  int channels() const { return 3; }
  int numbers() const { return numbers_of_pixel; }
  int rays() const { return 1; }

  // Of equal solid angle: columns are all alike, rows are cut where their share of the hemisphere ends.
  Texel even_cell(double u, double v) const {
    const double cosine = 1 - v;
    const double sine = std::sqrt(std::max(0.0, 1 - cosine * cosine));
    return sky->cell_of({sine * math::cos_2pi(u), cosine, sine * math::sin_2pi(u)});
  }
  double cosine_if_open(const Hit& hit, std::size_t cell) const {
    const Vector direction = sky->directions[cell];
    const double cosine = dot(hit.normal, direction);
    return cosine > 0 && !is_hidden(hit, direction, mesh) ? cosine : 0;
  }
  void estimate(int x, int y, Draw draw, float* out) const {
    const double u = static_cast<double>(draw(0));
    const double v = static_cast<double>(draw(1));
    const Texel place = is_direction ? sky->turned(sky->cell_of({u, v, static_cast<double>(draw(2))}), turn)
                        : by_light   ? sky->turned(sky->cells.at(u, v), turn)
                                     : even_cell(u, v);
    const Texel cell = sky->turned(place, -turn);
    const std::size_t i = sky->index(cell);
    const std::size_t seen = sky->index(place);
    const double chance = by_light ? sky->cells.mass(cell) : sky->solid_angles[seen] / math::two_pi;
    const double cosine = cosine_if_open(hits->at(x, y), seen);
    // A cell without light has no chance: rounding may carry a direction over its edge.
    for (std::size_t c = 0; c < 3; ++c)
      out[c] = chance > 0 ? static_cast<float>(sky->light[i][c] * cosine / chance) : 0;
  }
  void expect(int x, int y, double* out) const {
    for (int c = 0; c < 3; ++c)
      out[c] = truth_of_frame == nullptr ? 0 : static_cast<double>(truth_of_frame->row(c, y)[x]);
    if (truth_of_frame != nullptr) return;
    const Hit& hit = hits->at(x, y);
    for (std::size_t i = 0; i < sky->directions.size(); ++i) {
      const double cosine = cosine_if_open(hit, i);
      if (!(cosine > 0)) continue;
      for (std::size_t c = 0; c < 3; ++c) out[c] += sky->light[i][c] * cosine;
    }
  }

  const Hits* hits;
  const SkyLight* sky;
  const Mesh* mesh;
  bool is_direction = false;
  bool by_light = true;
  int numbers_of_pixel = 2;
  std::int64_t turn = 0;                  // columns, in this frame
  const Image* truth_of_frame = nullptr;  // where it turns
};

// Frames until the sky is as it was in the first, or all of them.
std::int64_t different_frames(const Scene& scene, std::int64_t columns) {
  return std::min<std::int64_t>(scene.frames, columns / std::gcd(columns, std::int64_t{scene.sky.turn}));
}

// What comes from the directions of cells: [direction][frame][channel].
std::vector<double> light_of_frames(const SkyLight& sky, std::int64_t turn, std::int64_t frames) {
  std::vector<double> light;
  for (int y = 0; y < sky.cells.height(); ++y)
    for (int x = 0; x < sky.cells.width(); ++x)
      for (std::int64_t frame = 0; frame < frames; ++frame) {
        const std::array<double, 3>& of_cell = sky.light[sky.index(sky.turned({x, y}, -frame * turn))];
        light.insert(light.end(), of_cell.begin(), of_cell.end());
      }
  return light;
}

}  // namespace

void make_sky_pass(Shared& shared) {
  const SkyLight& sky = shared.sky.make(make_sky(shared.scene.sky));
  std::vector<double> chances = sky.solid_angles;
  for (double& chance : chances) chance /= math::two_pi;
  for (const Noise& noise : shared.opened) {
    if (holds_directions_of_sky(shared.scene, noise)) {
      check_directions(noise, sky);
    } else if (!noise.spec.importance) {
      shared.notes.push_back(note_of_weights(noise.spec.name, "sky", weights_of(sky.cells, chances)));
    }
  }
}

std::int64_t bytes_of_sky(const Scene& scene, std::span<const Noise>) {
  return most_cells(scene.sky) * static_cast<std::int64_t>(sizeof(Vector) + 5 * sizeof(double));
}

std::string off_without_turning_sky(const Scene& scene) {
  if (!scene.sky.on) return "no effects.sky";
  return scene.sky.turn != 0 ? applies : "the sky stands still";
}

// What a pixel sees of the directions of cells is found once; frames have other light there.
void make_sky_truths(Shared& shared) {
  const Scene& scene = shared.scene;
  const SkyEffect effect(shared, 0, nullptr);
  const SkyLight& sky = *effect.sky;
  const std::int64_t frames = different_frames(scene, sky.cells.width());
  std::vector<Image>& truths = shared.sky_truths.make(
      std::vector<Image>(static_cast<std::size_t>(frames), make_image(scene.width, scene.height, 3)));
  const std::vector<double> light = light_of_frames(sky, scene.sky.turn, frames);
  const auto numbers = static_cast<std::size_t>(3 * frames);
  shared.pool.for_each(scene.height, [&](std::int64_t row, int) {
    const int y = static_cast<int>(row);
    std::vector<double> sums(numbers);
    for (int x = 0; x < scene.width; ++x) {
      std::fill(sums.begin(), sums.end(), 0.0);
      for (std::size_t place = 0; place < sky.directions.size(); ++place) {
        const double cosine = effect.cosine_if_open(effect.hits->at(x, y), place);
        if (!(cosine > 0)) continue;
        const double* const of_place = light.data() + place * numbers;
        for (std::size_t i = 0; i < numbers; ++i) sums[i] += of_place[i] * cosine;
      }
      for (std::size_t frame = 0; frame < truths.size(); ++frame)
        for (int c = 0; c < 3; ++c)
          truths[frame].row(c, y)[x] = static_cast<float>(sums[3 * frame + static_cast<std::size_t>(c)]);
    }
  });
  count_of(*shared.counts, Work::guided_taps) += pixels_of(scene) * most_cells(scene.sky);
  count_of(*shared.counts, Work::expectations) += pixels_of(scene) * frames;
}

Counts work_of_sky_truths(const Scene& scene, std::span<const Noise>) {
  Counts counts{};
  count_of(counts, Work::guided_taps) = pixels_of(scene) * most_cells(scene.sky);
  count_of(counts, Work::expectations) = pixels_of(scene) * different_frames(scene, most_columns(scene.sky));
  return counts;
}

std::int64_t bytes_of_sky_truths(const Scene& scene, std::span<const Noise>) {
  return (12 * pixels_of(scene) + 24 * most_cells(scene.sky)) * different_frames(scene, most_columns(scene.sky));
}

const EffectCalls sky_calls = {Effect::sky,
                               [](const Scene&) { return 3; },
                               numbers_of_sky,
                               [](const Scene&) { return false; },
                               estimate_image<SkyEffect>,
                               truth_image<SkyEffect>,
                               nullptr,
                               [](const Scene& scene) {
                                 Counts counts{};
                                 count_of(counts, Work::guided_taps) = most_cells(scene.sky);
                                 return counts;
                               }};

}  // namespace noiseloom::render
