// The sphere and the plane under a sky, by one direction a pixel and frame: light of the direction, times the cosine,
// if it is open, over the chance with which the direction is drawn. Directions are the cells of the sky.
//
//   drawn by brightness (the default)   with the chance of the cell's light
//   drawn evenly                        all of the same density over the hemisphere
//
// Textures of the sky's image onto the hemisphere hold directions drawn by brightness.
#include <algorithm>
#include <cmath>

#include "noiseloom/core/error.h"
#include "render/effect-inl.h"
#include "render/effect_list.h"
#include "render/mesh_pass.h"
#include "render/sky_light.h"

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
    const Texel cell = is_direction ? sky->cell_of({u, v, static_cast<double>(draw(2))})
                       : by_light   ? sky->cells.at(u, v)
                                    : even_cell(u, v);
    const std::size_t i = sky->index(cell);
    const double chance = by_light ? sky->cells.mass(cell) : sky->solid_angles[i] / math::two_pi;
    const double cosine = cosine_if_open(hits->at(x, y), i);
    // A cell without light has no chance: rounding may carry a direction over its edge.
    for (std::size_t c = 0; c < 3; ++c)
      out[c] = chance > 0 ? static_cast<float>(sky->light[i][c] * cosine / chance) : 0;
  }
  void expect(int x, int y, double* out) const {
    for (int c = 0; c < 3; ++c) out[c] = 0;
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
};

}  // namespace

void make_sky_pass(Shared& shared) {
  const SkyLight& sky = shared.sky.make(make_sky(shared.scene.sky));
  for (const Noise& noise : shared.opened)
    if (holds_directions_of_sky(shared.scene, noise)) check_directions(noise, sky);
}

std::int64_t bytes_of_sky(const Scene&, std::span<const Noise>) {
  return most_cells_of_sky * static_cast<std::int64_t>(sizeof(Vector) + 5 * sizeof(double));
}

const EffectCalls sky_calls = {Effect::sky,
                               [](const Scene&) { return 3; },
                               numbers_of_sky,
                               [](const Scene&) { return false; },
                               estimate_image<SkyEffect>,
                               truth_image<SkyEffect>,
                               nullptr,
                               [](const Scene&) {
                                 Counts counts{};
                                 count_of(counts, Work::guided_taps) = most_cells_of_sky;
                                 return counts;
                               }};

}  // namespace noiseloom::render
