// Ambient occlusion and the soft shadow of a sun, by random directions.
#include <algorithm>

#include "noiseloom/core/error.h"
#include "render/effects/effect-inl.h"
#include "render/jobs/effect_list.h"
#include "render/jobs/mesh_pass.h"

namespace noiseloom::render {
namespace {

int numbers_of_occlusion(const Scene& scene, const Noise& noise) {
  if (noise.directions() != Directions::none) return 3 * scene.occlusion.samples;
  return if_numbers(2 * scene.occlusion.samples, noise);
}

// A direction whose cosine c to the normal is of equal density becomes one that is as dense as the cosine, sqrt(c), or
// the other way round, c^2.
Vector bent(Vector direction, Vector normal, bool toward) {
  const double cosine = std::clamp(dot(direction, normal), 0.0, 1.0);
  const double along = toward ? std::sqrt(cosine) : cosine * cosine;
  const double beside = std::sqrt(std::max(0.0, 1 - cosine * cosine));
  const double scale = beside > 0 ? std::sqrt(std::max(0.0, 1 - along * along)) / beside : 0;
  return along * normal + scale * (direction - cosine * normal);
}

// What the surfaces are, for one effect: those of the frame, where something moves.
const Hits& hits_of(const Shared& shared, const Job* job, const char* effect) {
  if (job != nullptr && shared.scene.motion.on) return job->moving_hits.get(Data::moving_hits, job->pass);
  return shared.hits.get(Data::hits, shared.pass_or(effect));
}

struct OcclusionEffect {
  OcclusionEffect(const Shared& shared, int, const Job* job)
      : hits(&hits_of(shared, job, "ambient-occlusion")),
        mesh(mesh_of(shared, "ambient-occlusion")),
        shares(shares_in(shared, job, "ambient-occlusion")),
        spec(shared.scene.occlusion) {
    if (job == nullptr) return;
    const Noise& noise = job->noise_of_job();
    kind = noise.directions();
    numbers_of_pixel = numbers_of_occlusion(shared.scene, noise);
  }

  int channels() const { return 1; }
  int numbers() const { return numbers_of_pixel; }
  int rays() const { return spec.samples; }
  int march_steps() const { return 0; }

  // One direction, what it counts, and where it goes.
  double sample(const Hit& hit, Draw draw, int i) const {
    const auto number = [&](int k) { return static_cast<double>(draw(k)); };
    switch (kind) {
      case Directions::none: {
        if (!spec.uniform) return open(hit, turned(cosine_direction(number(2 * i), number(2 * i + 1)), hit.normal));
        const double cosine = number(2 * i);
        return 2 * cosine * open(hit, turned(direction_at(cosine, number(2 * i + 1)), hit.normal));
      }
      case Directions::cosine:
      case Directions::hemisphere:
        return weighed(hit, turned({number(3 * i), number(3 * i + 1), number(3 * i + 2)}, hit.normal));
      case Directions::sphere:
        break;
    }
    const Vector direction = {number(3 * i), number(3 * i + 1), number(3 * i + 2)};
    return weighed(hit, dot(direction, hit.normal) < 0 ? -1 * direction : direction);
  }
  // All noises of a scene are of one estimate, so that their errors may be compared: directions of another density than
  // the scene's are bent toward the normal or away from it.
  double weighed(const Hit& hit, Vector direction) const {
    if (spec.uniform == (kind == Directions::cosine)) direction = bent(direction, hit.normal, !spec.uniform);
    if (!spec.uniform) return open(hit, direction);
    return 2 * std::max(0.0, dot(direction, hit.normal)) * open(hit, direction);
  }
  double open(const Hit& hit, Vector direction) const { return is_hidden(hit, direction, mesh) ? 0 : 1; }

  void estimate(int x, int y, Draw draw, float* out) const {
    double sum = 0;
    for (int i = 0; i < spec.samples; ++i) sum += sample(hits->at(x, y), draw, i);
    out[0] = static_cast<float>(sum / spec.samples);
  }
  void expect(int x, int y, double* out) const {
    out[0] = mesh == nullptr ? open_share(hits->at(x, y)) : shares.of_sky(x, y);
  }

  const Hits* hits;
  const Mesh* mesh;
  SharesInFrame shares;
  OcclusionSpec spec;
  Directions kind = Directions::none;
  int numbers_of_pixel = 0;
};

struct ShadowEffect {
  ShadowEffect(const Shared& shared, int, const Job* job)
      : hits(&hits_of(shared, job, "soft-shadow")),
        mesh(mesh_of(shared, "soft-shadow")),
        shares(shares_in(shared, job, "soft-shadow")),
        cos_radius(math::cos_2pi(shared.scene.shadow.radius / 360)) {}

  int channels() const { return 1; }
  int numbers() const { return 2; }
  int rays() const { return 1; }
  int march_steps() const { return 0; }

  void estimate(int x, int y, Draw draw, float* out) const {
    const double cosine = 1 - static_cast<double>(draw(0)) * (1 - cos_radius);
    const Vector direction = turned(direction_at(cosine, static_cast<double>(draw(1))), sun_direction);
    out[0] = is_in_shadow(hits->at(x, y), direction, mesh) ? 0 : 1;
  }
  void expect(int x, int y, double* out) const {
    out[0] = mesh == nullptr ? sun_share(hits->at(x, y), cos_radius) : shares.of_sun(x, y);
  }

  const Hits* hits;
  const Mesh* mesh;
  SharesInFrame shares;
  double cos_radius;
};

}  // namespace

const EffectCalls occlusion_calls = {Effect::occlusion,
                                     [](const Scene&) { return 1; },
                                     numbers_of_occlusion,
                                     [](const Scene&) { return false; },
                                     estimate_image<OcclusionEffect>,
                                     truth_image<OcclusionEffect>};

const EffectCalls shadow_calls = {Effect::shadow,
                                  [](const Scene&) { return 1; },
                                  [](const Scene&, const Noise& noise) { return if_numbers(2, noise); },
                                  [](const Scene&) { return false; },
                                  estimate_image<ShadowEffect>,
                                  truth_image<ShadowEffect>};

}  // namespace noiseloom::render
