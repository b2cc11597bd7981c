#include "noiseloom/core/error.h"
#include "noiseloom/core/random.h"
#include "render/effects/effect-inl.h"
#include "render/jobs/effect_list.h"

namespace noiseloom::render {
namespace {

constexpr double circle_radius = 0.4;    // of the circle
constexpr double gauss_deviation = 0.2;  // of the Gaussian

// One threshold for each repeat, each in its own part of 0..1; of jittered steps one for each frame, too.
double threshold_of(const Scene& scene, int repeat, const Job* job) {
  if (scene.integrand.function == Integrand::step) return scene.integrand.threshold;
  const bool is_jittered = job != nullptr && scene.integrand.function == Integrand::jittered_steps;
  const auto frame = static_cast<std::uint32_t>(is_jittered ? job->frame : 0);
  const RandomBlock block =
      random_block(scene.seed, purpose_of_threshold, frame, 0, static_cast<std::uint64_t>(repeat));
  return (repeat + to_unit_double(block[0], block[1])) / scene.repeats;
}

bool takes_two(Integrand function) { return function == Integrand::circle || function == Integrand::gauss; }

struct IntegrandEffect : PlainEffect {
  IntegrandEffect(const Shared& shared, int repeat, const Job* job)
      : function(shared.scene.integrand.function), threshold(threshold_of(shared.scene, repeat, job)) {}

  int channels() const { return 1; }
  int numbers() const { return takes_two(function) ? 2 : 1; }

  double value(Draw draw) const {
    const double u = static_cast<double>(draw(0));
    switch (function) {
      case Integrand::constant:
        return 0.5;
      case Integrand::identity:
        return u;
      case Integrand::step:
      case Integrand::steps:
      case Integrand::jittered_steps:
        return u < threshold ? 1 : 0;
      case Integrand::sine:
        return math::sin_2pi(0.5 * u);
      case Integrand::circle:
      case Integrand::gauss:
        break;
    }
    const double x = u - 0.5;
    const double y = static_cast<double>(draw(1)) - 0.5;
    const double r2 = x * x + y * y;
    if (function == Integrand::circle) return r2 < circle_radius * circle_radius ? 1 : 0;
    return math::exp(-r2 / (2 * gauss_deviation * gauss_deviation));
  }
  void estimate(int, int, Draw draw, float* out) const { out[0] = static_cast<float>(value(draw)); }

  void expect(int, int, double* out) const { out[0] = mean(); }
  double mean() const {
    switch (function) {
      case Integrand::constant:
      case Integrand::identity:
        return 0.5;
      case Integrand::step:
      case Integrand::steps:
      case Integrand::jittered_steps:
        return threshold;
      case Integrand::sine:
        return 2 / math::pi;
      case Integrand::circle:
        return math::pi * circle_radius * circle_radius;
      case Integrand::gauss: {
        const double side =
            gauss_deviation * std::sqrt(math::two_pi) * math::erf(0.5 / (gauss_deviation * std::sqrt(2.0)));
        return side * side;
      }
    }
    return 0;
  }

  Integrand function;
  double threshold;
};

}  // namespace

const EffectCalls integrand_calls = {Effect::integrand,
                                     [](const Scene&) { return 1; },
                                     [](const Scene& scene, const Noise& noise) {
                                       return if_numbers(takes_two(scene.integrand.function) ? 2 : 1, noise);
                                     },
                                     [](const Scene& scene) { return scene.integrand.function == Integrand::steps; },
                                     estimate_image<IntegrandEffect>,
                                     truth_image<IntegrandEffect>};

}  // namespace noiseloom::render
