// Slices that are missing where neighbours show little of it.
//
// A filter over x, y and time spreads what it does to two slices over all frequencies that it lets through, so that
// hardly anything of it is left in the correlation of values at the same pixel. The coherence of the slices' spectra,
// band by band, has it: gamma_b(s, l) of slices s and s + l, which chance lets deviate by 1 / sqrt(n_b) for n_b
// frequencies. With c_b(l), its median over the series, a gap behind slice g makes those pairs across it that are l
// apart what others are that are l + 1 apart. Of all numbers that could tell, the likelihood's is
//
//   Z_g = sum_l sum_{s <= g < s + l} sum_b n_b (gamma_b(s, l) - c_b(l)) (c_b(l + 1) - c_b(l)) / D
//   D^2 = sum_l l sum_b n_b (c_b(l + 1) - c_b(l))^2
//
// which is a normal number where nothing is missing, and D more where a slice is.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <deque>

#include "measure/verify_parts.h"
#include "noiseloom/measure/plane_transform.h"

namespace noiseloom::verify {
namespace {

constexpr std::size_t num_bands = 16;
using Bands = std::array<double, num_bands>;

struct SliceSpectrum {
  std::vector<std::complex<double>> values;  // one half of the frequencies, channel by channel
  Bands power{};
};

// The spectra of slices, and which band each of their frequencies is in.
class SpectrumMaker {
 public:
  explicit SpectrumMaker(const Texture& texture)
      : texture_(texture),
        width_(static_cast<int>(texture.extents.width())),
        height_(static_cast<int>(texture.extents.height())),
        transform_(width_, height_) {
    for (int ky = 0; ky < height_; ++ky) {
      for (int kx = 0; kx <= width_ / 2; ++kx) {
        const double x = static_cast<double>(kx) / width_;
        const double y = static_cast<double>(std::min(ky, height_ - ky)) / height_;
        const double share = std::hypot(x, y) * std::sqrt(2.0);  // of the highest
        const auto band = std::min(num_bands - 1, static_cast<std::size_t>(share * num_bands));
        // The other half mirrors this one; the mean tells nothing.
        const bool is_mean = kx == 0 && ky == 0;
        const double weight = is_mean ? 0 : kx == 0 || 2 * kx == width_ ? 1 : 2;
        band_.push_back(band);
        weight_.push_back(weight);
        count_[band] += weight * texture.channels;
      }
    }
  }

  SliceSpectrum of(SliceIndex slice) {
    SliceSpectrum spectrum;
    const auto cells = static_cast<std::ptrdiff_t>(texture_.extents.cells_per_slice());
    for (int c = 0; c < texture_.channels; ++c) {
      const float* const plane = texture_.slice(slice) + c * cells;
      std::copy(plane, plane + cells, transform_.real().begin());
      transform_.forward();
      for (int ky = 0; ky < height_; ++ky) {
        for (int kx = 0; kx <= width_ / 2; ++kx) spectrum.values.push_back(transform_.at(kx, ky));
      }
    }
    spectrum.power = product(spectrum, spectrum);
    return spectrum;
  }

  Bands coherence(const SliceSpectrum& a, const SliceSpectrum& b) const {
    Bands bands = product(a, b);
    for (std::size_t k = 0; k < num_bands; ++k) {
      const double power = a.power[k] * b.power[k];
      bands[k] = power > 0 ? bands[k] / std::sqrt(power) : 0;
    }
    return bands;
  }

  const Bands& count() const { return count_; }

 private:
  Bands product(const SliceSpectrum& a, const SliceSpectrum& b) const {
    Bands sums{};
    for (std::size_t i = 0; i < a.values.size(); ++i) {
      const std::size_t place = i % band_.size();
      sums[band_[place]] += weight_[place] * (a.values[i] * std::conj(b.values[i])).real();
    }
    return sums;
  }

  const Texture& texture_;
  int width_;
  int height_;
  PlaneTransform transform_;
  std::vector<std::size_t> band_;
  std::vector<double> weight_;
  Bands count_{};
};

// [distance - 1][slice], for distances up to `most`, around the end.
std::vector<std::vector<Bands>> coherences(SpectrumMaker& maker, std::size_t slices, std::size_t most) {
  std::vector<std::vector<Bands>> all(most, std::vector<Bands>(slices));
  std::deque<SliceSpectrum> last;  // the newest in front
  for (std::size_t s = 0; s < slices + most; ++s) {
    SliceSpectrum spectrum = maker.of(SliceIndex(s % slices));
    for (std::size_t l = 1; l <= last.size(); ++l) {
      if (s >= l && s - l < slices) all[l - 1][s - l] = maker.coherence(last[l - 1], spectrum);
    }
    last.push_front(std::move(spectrum));
    if (last.size() > most) last.pop_back();
  }
  return all;
}

struct GapSigns {
  std::vector<double> z;  // of a gap behind each slice
  double expected = 0;    // where there is one
};

GapSigns signs_of_gaps(const Texture& texture, std::size_t most) {
  SpectrumMaker maker(texture);
  const auto slices = static_cast<std::size_t>(texture.extents.num_slices());
  const auto found = coherences(maker, slices, most + 1);
  std::vector<Bands> usual(most + 1);
  for (std::size_t l = 0; l <= most; ++l) {
    for (std::size_t k = 0; k < num_bands; ++k) {
      std::vector<double> values;
      for (const Bands& pair : found[l]) values.push_back(pair[k]);
      usual[l][k] = median_of(std::move(values));
    }
  }
  GapSigns signs{std::vector<double>(slices, 0)};
  for (std::size_t l = 0; l < most; ++l) {
    for (std::size_t k = 0; k < num_bands; ++k) {
      const double step = usual[l + 1][k] - usual[l][k];
      const double weight = maker.count()[k] * step;
      signs.expected += static_cast<double>(l + 1) * weight * step;
      for (std::size_t s = 0; s < slices; ++s) {
        for (std::size_t d = 0; d <= l; ++d) signs.z[(s + d) % slices] += weight * (found[l][s][k] - usual[l][k]);
      }
    }
  }
  signs.expected = std::sqrt(signs.expected);
  for (double& z : signs.z) z = signs.expected > 0 ? z / signs.expected : 0;
  return signs;
}

}  // namespace

std::vector<SliceIndex> gaps_behind(const Texture& texture) {
  const std::int32_t slices = texture.extents.num_slices();
  constexpr std::int32_t fewest = 8;
  if (texture.extents.num_axes() != 3 || slices < fewest) return {};
  const auto most = static_cast<std::size_t>(std::min<std::int32_t>(3, slices / 2 - 2));
  const GapSigns signs = signs_of_gaps(texture, most);
  std::vector<double> sizes;
  for (const double z : signs.z) sizes.push_back(std::abs(z));
  // What deviates more than chance has it, as features do that stand in for slices, does so everywhere.
  const double deviation = std::max(1.0, 1.4826 * median_of(std::move(sizes)));
  constexpr double certain = 6;
  const double bound = std::max(certain * deviation, signs.expected / 2);
  std::vector<SliceIndex> gaps;
  for (std::int32_t g = 0; g < slices; ++g) {
    const auto z = [&](std::int32_t at) { return signs.z[static_cast<std::size_t>((at + slices) % slices)]; };
    bool is_peak = z(g) > bound;
    for (std::int32_t d = 1; d <= static_cast<std::int32_t>(most) && is_peak; ++d) {
      is_peak = z(g) >= z(g - d) && z(g) >= z(g + d);
    }
    if (is_peak) gaps.emplace_back(g);
  }
  return gaps;
}

}  // namespace noiseloom::verify
