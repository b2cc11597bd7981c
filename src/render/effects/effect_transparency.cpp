// Stochastic transparency: each pane, from front to back, is there where its number is below its opacity; the first
// that is there is seen. The mean is what compositing one over the other gives.
#include "noiseloom/core/error.h"
#include "render/effects/effect-inl.h"
#include "render/jobs/effect_list.h"

namespace noiseloom::render {
namespace {

struct Colour {
  double channel[3];
};

struct TransparencyEffect : PlainEffect {
  TransparencyEffect(const Shared& shared, int, const Job*)
      : spec(&shared.scene.transparency), width(shared.scene.width), height(shared.scene.height) {}

  int channels() const { return 3; }
  int numbers() const { return static_cast<int>(spec->alpha.size()); }

  Colour background(int x, int y) const {
    const double u = (x + 0.5) / width;
    const double v = (y + 0.5) / height;
    const double square = ((x / 16 + y / 16) % 2 == 0) ? 1.0 : 0.55;
    return {{square * (0.25 + 0.75 * u), square * (0.3 + 0.5 * v), square * (0.9 - 0.6 * u)}};
  }
  Colour pane(int i) const {
    static constexpr Colour colours[] = {{{0.9, 0.2, 0.1}}, {{0.1, 0.7, 0.3}}, {{0.2, 0.3, 0.9}}, {{0.95, 0.85, 0.2}}};
    return colours[i % 4];
  }
  // Staggered panes: n of them, each two steps wide, the steps being 1/(n + 3) of the picture, and lower each time.
  bool covers(int i, int x, int y) const {
    if (!spec->staggered) return true;
    const double step = 1.0 / (numbers() + 3);
    const double u = (x + 0.5) / width - (i + 0.5) * step;
    const double v = (y + 0.5) / height - 0.5 * step * (1 + i % 2);
    return u >= 0 && u < 2.5 * step && v >= 0 && v < 1 - 2 * step;
  }

  void estimate(int x, int y, Draw draw, float* out) const {
    Colour seen = background(x, y);
    for (int i = 0; i < numbers(); ++i)
      if (covers(i, x, y) && static_cast<double>(draw(i)) < spec->alpha[static_cast<std::size_t>(i)]) {
        seen = pane(i);
        break;
      }
    for (int c = 0; c < 3; ++c) out[c] = static_cast<float>(seen.channel[c]);
  }
  void expect(int x, int y, double* out) const {
    const Colour behind = background(x, y);
    for (int c = 0; c < 3; ++c) out[c] = behind.channel[c];
    for (int i = numbers() - 1; i >= 0; --i) {
      if (!covers(i, x, y)) continue;
      const double alpha = spec->alpha[static_cast<std::size_t>(i)];
      for (int c = 0; c < 3; ++c) out[c] = alpha * pane(i).channel[c] + (1 - alpha) * out[c];
    }
  }

  const TransparencySpec* spec;
  int width;
  int height;
};

}  // namespace

const EffectCalls transparency_calls = {Effect::transparency,
                                        [](const Scene&) { return 3; },
                                        [](const Scene& scene, const Noise& noise) {
                                          return if_numbers(static_cast<int>(scene.transparency.alpha.size()), noise);
                                        },
                                        [](const Scene&) { return false; },
                                        estimate_image<TransparencyEffect>,
                                        truth_image<TransparencyEffect>};

}  // namespace noiseloom::render
