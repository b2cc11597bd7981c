// Dithering to n bits: floor(v (2^n - 1) + u) / (2^n - 1), whose mean over u is v.
#include <algorithm>

#include "noiseloom/core/error.h"
#include "render/effects/effect-inl.h"
#include "render/jobs/effect_list.h"

namespace noiseloom::render {
namespace {

// In units of levels. A value on a level stays there whatever the number, though float holds most of them not quite.
double on_levels(double value, double levels) {
  constexpr double hair = 1e-6;
  const double place = std::clamp(value, 0.0, 1.0) * levels;
  const double nearest = std::floor(place + 0.5);
  return std::fabs(place - nearest) < hair * std::max(1.0, levels) ? nearest : place;
}

struct DitherEffect : PlainEffect {
  DitherEffect(const Shared& shared, int, const Job*)
      : picture(&shared.picture.get(Data::picture, shared.pass_or("dither"))),
        levels(static_cast<double>((1 << shared.scene.dither.bits) - 1)) {}

  int channels() const { return picture->channels; }
  int numbers() const { return picture->channels; }

  double place(int channel, int x, int y) const {
    return on_levels(static_cast<double>(picture->row(channel, y)[x]), levels);
  }
  void estimate(int x, int y, Draw draw, float* out) const {
    for (int c = 0; c < picture->channels; ++c)
      out[c] = static_cast<float>(std::floor(place(c, x, y) + static_cast<double>(draw(c))) / levels);
  }
  void expect(int x, int y, double* out) const {
    for (int c = 0; c < picture->channels; ++c) out[c] = place(c, x, y) / levels;
  }

  const Image* picture;
  double levels;
};

// The pure hue at a place of 0 to 1 around the circle of colours.
double hue_channel(double hue, int channel) {
  double place = 6 * (hue + (3 - channel) / 3.0);
  place -= 6 * std::floor(place / 6);
  return std::clamp(std::fabs(place - 3) - 1, 0.0, 1.0);
}

double value_at(TestPicture kind, int bits, double u, double v, int channel) {
  switch (kind) {
    case TestPicture::ramp:
      return u;
    case TestPicture::dark_ramp:
      return u / 8;
    case TestPicture::flats: {
      const double levels = static_cast<double>((1 << bits) - 1);
      const double level = std::floor(u * 4) / 4 + 0.125;  // one of four levels or so
      const double nearest = std::floor(level * levels + 0.5) / levels;
      const double beside[] = {-0.02, -0.002, 0, 0.002, 0.02};
      return std::clamp(nearest + beside[std::min(4, static_cast<int>(5 * v))], 0.0, 1.0);
    }
    case TestPicture::colours:
      return v + (1 - v) * hue_channel(u, channel);
    case TestPicture::zone_plate: {
      const double x = u - 0.5;
      const double y = v - 0.5;
      return 0.5 + 0.5 * math::cos_2pi(40 * (x * x + y * y));
    }
  }
  return 0;
}

}  // namespace

int channels_of(TestPicture picture) { return picture == TestPicture::colours ? 3 : 1; }

Image test_picture(const DitherSpec& spec, int width, int height) {
  Image image = make_image(width, height, channels_of(spec.picture));
  for (int c = 0; c < image.channels; ++c)
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x)
        image.row(c, y)[x] =
            static_cast<float>(value_at(spec.picture, spec.bits, (x + 0.5) / width, (y + 0.5) / height, c));
  return image;
}

const EffectCalls dither_calls = {
    Effect::dither,
    [](const Scene& scene) { return channels_of(scene.dither.picture); },
    [](const Scene& scene, const Noise& noise) { return if_numbers(channels_of(scene.dither.picture), noise); },
    [](const Scene&) { return false; },
    estimate_image<DitherEffect>,
    truth_image<DitherEffect>};

}  // namespace noiseloom::render
