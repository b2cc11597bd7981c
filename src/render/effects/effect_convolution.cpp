// A blur by one point of the kernel in each frame: the picture at the pixel plus the point.
//
//   drawn by mass (the default)   the picture itself
//   drawn evenly                  times the mass over that of an even kernel
//
// Textures whose samples are the points of the kernel are read as they are.
#include <fmt/format.h>

#include <algorithm>

#include "noiseloom/core/error.h"
#include "noiseloom/samples/space.h"
#include "render/effects/effect-inl.h"
#include "render/jobs/effect_list.h"
#include "render/world/kernel.h"

namespace noiseloom::render {
namespace {

// Whether the noise holds points of the kernel.
bool holds_points(const ConvolutionSpec& spec, const Noise& noise) {
  if (!has_texture(noise.spec.kind)) return false;
  if (spec.kernel == BlurKernel::image) return noise.samples.is_image() && noise.samples.onto == ImageDomain::square;
  if (noise.samples.space != space_of_kernel(spec.kernel)) return false;
  const std::vector<double>& parameters = noise.samples.parameters;
  return parameters.empty() || parameters == initial_parameters(find_sample_space(noise.samples.space)->traits());
}

int numbers_of_convolution(const Scene& scene, const Noise& noise) {
  return holds_points(scene.convolution, noise) ? 2 : if_numbers(2, noise);
}

struct ConvolutionEffect : PlainEffect {
  ConvolutionEffect(const Shared& shared, int, const Job* job)
      : blur(&shared.kernel.get(Data::kernel, shared.pass_or("convolution"))) {
    if (job == nullptr) return;
    const Noise& noise = job->noise_of_job();
    is_point = holds_points(shared.scene.convolution, noise);
    of_disk = shared.scene.convolution.kernel != BlurKernel::image;
    by_mass = noise.spec.importance;
  }

  int channels() const { return 3; }
  int numbers() const { return 2; }

  const float* picture_at(int x, int y, Texel texel) const {
    const Image& picture = blur->picture;
    const int from_x = inside(x + texel.x - blur->masses.width() / 2, picture.width, Border::wrap);
    const int from_y = inside(y + texel.y - blur->masses.height() / 2, picture.height, Border::wrap);
    return picture.row(0, from_y) + from_x;
  }
  void estimate(int x, int y, Draw draw, float* out) const {
    const MassTable& masses = blur->masses;
    const double u = static_cast<double>(draw(0));
    const double v = static_cast<double>(draw(1));
    const Texel texel = is_point  ? texel_of(u, v, of_disk, masses.width(), masses.height())
                        : by_mass ? masses.at(u, v)
                                  : texel_of(u, v, false, masses.width(), masses.height());
    const double weight = is_point || by_mass ? 1 : masses.mass(texel) * masses.width() * masses.height();
    const float* const seen = picture_at(x, y, texel);
    for (std::size_t c = 0; c < 3; ++c)
      out[c] = static_cast<float>(weight * static_cast<double>(seen[c * blur->picture.pixels()]));
  }
  void expect(int x, int y, double* out) const {
    for (int c = 0; c < 3; ++c) out[c] = 0;
    for (int row = 0; row < blur->masses.height(); ++row)
      for (int column = 0; column < blur->masses.width(); ++column) {
        const double mass = blur->masses.mass({column, row});
        if (!(mass > 0)) continue;
        const float* const seen = picture_at(x, y, {column, row});
        for (std::size_t c = 0; c < 3; ++c) out[c] += mass * static_cast<double>(seen[c * blur->picture.pixels()]);
      }
  }

  const BlurMasses* blur;
  bool is_point = false;
  bool of_disk = false;
  bool by_mass = true;
};

// An image's points must be those of the kernel: none where it is black, and their mean where it has its own.
void check_points(const Noise& noise, const MassTable& masses) {
  const Texture& texture = *noise.texture;
  const auto cells = static_cast<std::size_t>(texture.extents.cells_per_slice());
  double mean_x = 0;
  double mean_y = 0;
  for (const SliceIndex s : texture.extents.slices())
    for (std::size_t i = 0; i < cells; ++i) {
      const Texel texel =
          texel_of(static_cast<double>(texture.slice(s)[i]), static_cast<double>(texture.slice(s)[cells + i]), false,
                   masses.width(), masses.height());
      if (!(masses.mass(texel) > 0))
        throw UserError("noise \"" + noise.spec.name + "\"",
                        fmt::format("has samples at pixel {}, {} of the kernel, which is black: it was made for "
                                    "another image than effects.convolution.file",
                                    texel.x, texel.y));
      mean_x += texel.x;
      mean_y += texel.y;
    }
  const double samples = static_cast<double>(texture.extents.num_cells());
  for (int y = 0; y < masses.height(); ++y)
    for (int x = 0; x < masses.width(); ++x) {
      mean_x -= samples * masses.mass({x, y}) * x;
      mean_y -= samples * masses.mass({x, y}) * y;
    }
  if (std::fabs(mean_x) > samples || std::fabs(mean_y) > samples)
    throw UserError("noise \"" + noise.spec.name + "\"",
                    fmt::format("has its samples {:.1f}, {:.1f} pixels off the middle of the kernel: it was made for "
                                "another image than effects.convolution.file",
                                mean_x / samples, mean_y / samples));
}

}  // namespace

void make_kernel_pass(Shared& shared) {
  const BlurMasses& blur = shared.kernel.make(
      {make_kernel(shared.scene.convolution), picture_of_lights(shared.scene.width, shared.scene.height)});
  const double texels = 1.0 * blur.masses.width() * blur.masses.height();
  for (const Noise& noise : shared.opened)
    if (!noise.spec.importance && !holds_points(shared.scene.convolution, noise))
      shared.notes.push_back(
          note_of_weights(noise.spec.name, "convolution",
                          weights_of(blur.masses, std::vector<double>(static_cast<std::size_t>(texels), 1 / texels))));
  if (shared.scene.convolution.kernel != BlurKernel::image) return;
  for (const Noise& noise : shared.opened)
    if (holds_points(shared.scene.convolution, noise)) check_points(noise, blur.masses);
}

std::int64_t bytes_of_kernel(const Scene& scene, std::span<const Noise>) {
  const std::int64_t size = scene.convolution.kernel == BlurKernel::image ? 255 : scene.convolution.size;
  return 8 * size * (size + 1) + 12 * std::int64_t{scene.width} * scene.height;
}

const EffectCalls convolution_calls = {Effect::convolution,
                                       [](const Scene&) { return 3; },
                                       numbers_of_convolution,
                                       [](const Scene&) { return false; },
                                       estimate_image<ConvolutionEffect>,
                                       truth_image<ConvolutionEffect>,
                                       nullptr,
                                       [](const Scene& scene) {
                                         // How large an image is only it says.
                                         const bool is_known = scene.convolution.kernel != BlurKernel::image;
                                         Counts counts{};
                                         count_of(counts, Work::guided_taps) =
                                             is_known ? std::int64_t{scene.convolution.size} * scene.convolution.size
                                                      : 0;
                                         return counts;
                                       }};

}  // namespace noiseloom::render
