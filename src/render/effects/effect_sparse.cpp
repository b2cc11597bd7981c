// Samples in some pixels only: a pixel has one in a frame where its number is below its importance.
#include <fmt/format.h>

#include <cmath>

#include "noiseloom/core/error.h"
#include "noiseloom/samples/luminance.h"
#include "render/effects/effect-inl.h"
#include "render/jobs/effect_list.h"

namespace noiseloom::render {
namespace {

struct SparseEffect : PlainEffect {
  SparseEffect(const Shared& shared, int, const Job*)
      : importance(&shared.importance.get(Data::importance, shared.pass_or("sparse"))) {}

  int channels() const { return 1; }
  int numbers() const { return 1; }

  void estimate(int x, int y, Draw draw, float* out) const { out[0] = draw(0) < importance->row(0, y)[x] ? 1 : 0; }
  void expect(int x, int y, double* out) const { out[0] = static_cast<double>(importance->row(0, y)[x]); }

  const Image* importance;
};

// Soft spots, on a ground of which little is asked.
double spots_at(double u, double v) {
  const double wave = math::sin_2pi(1.5 * u + 0.1) * math::sin_2pi(2 * v + 0.05 + 0.3 * u);
  return 0.04 + 0.7 * wave * wave;
}

// Stretched over the picture; numbers above 1 ask for no more than 1 does.
Image importance_of_image(const std::string& file, int width, int height) {
  SampleSpec samples;
  samples.space = "image";
  samples.file = file;
  samples.encoding = ImageEncoding::linear;
  const InputArrayPtr map = read_luminance(samples);
  const auto& values = std::get<SharedValues<float>>(map->values);
  Image image = make_image(width, height, 1);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const std::int64_t from_y = y * map->shape[0] / height;
      const std::int64_t from_x = x * map->shape[1] / width;
      const float value = values[static_cast<std::size_t>(from_y * map->shape[1] + from_x)];
      if (!(value >= 0) || !std::isfinite(value))
        throw UserError(
            file, fmt::format("holds {} at x {}, y {}: importance is finite and at least 0", value, from_x, from_y));
      image.row(0, y)[x] = std::min(value, 1.0F);
    }
  return image;
}

}  // namespace

void make_importance_pass(Shared& shared) {
  const SparseSpec& spec = shared.scene.sparse;
  const int width = shared.scene.width;
  const int height = shared.scene.height;
  if (spec.importance == ImportanceMap::image) {
    shared.importance.make(importance_of_image(spec.file, width, height));
    return;
  }
  Image& image = shared.importance.make(make_image(width, height, 1));
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const double u = (x + 0.5) / width;
      const double value = spec.importance == ImportanceMap::ramp   ? u
                           : spec.importance == ImportanceMap::flat ? spec.level
                                                                    : spots_at(u, (y + 0.5) / height);
      image.row(0, y)[x] = static_cast<float>(value);
    }
}

const EffectCalls sparse_calls = {Effect::sparse,
                                  [](const Scene&) { return 1; },
                                  [](const Scene&, const Noise& noise) { return if_numbers(1, noise); },
                                  [](const Scene&) { return false; },
                                  estimate_image<SparseEffect>,
                                  truth_image<SparseEffect>};

}  // namespace noiseloom::render
