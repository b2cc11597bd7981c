#include "noiseloom/measure/spectrum.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <mutex>
#include <numbers>

#include "noiseloom/measure/plane_transform.h"

namespace noiseloom {
namespace {

// The real-valued signals that stand for a texture: its channels, or cos and sin of a circle's.
class Signals {
 public:
  Signals(const Texture& texture, DistanceKind kind) : texture_(texture), circle_(kind == DistanceKind::circle) {
    const double n = static_cast<double>(texture.extents.num_cells());
    for (int c = 0; c < count(); ++c) {
      double sum = 0;
      double squares = 0;
      for (const SliceIndex s : texture.extents.slices())
        for (const float v : plane(c, s)) sum += value(c, v);
      for (const SliceIndex s : texture.extents.slices())
        for (const float v : plane(c, s)) {
          const double d = value(c, v) - sum / n;
          squares += d * d;
        }
      means_.push_back(sum / n);
      variance_ += squares / n;
    }
  }
  int count() const { return circle_ ? 2 : texture_.channels; }
  double variance() const { return variance_; }  // summed over the signals
  // Of a value of the texture that lies plane_offset(signal) behind the first channel's.
  double centred(int signal, float v) const { return value(signal, v) - means_[static_cast<std::size_t>(signal)]; }
  std::size_t plane_offset(int signal) const {
    return circle_ ? 0 : static_cast<std::size_t>(signal * texture_.extents.cells_per_slice());
  }

 private:
  std::span<const float> plane(int signal, SliceIndex s) const {
    return {texture_.slice(s) + plane_offset(signal), static_cast<std::size_t>(texture_.extents.cells_per_slice())};
  }
  double value(int signal, float stored) const {
    const double v = static_cast<double>(stored);
    if (!circle_) return v;
    const double angle = 2 * std::numbers::pi * v;
    return signal == 0 ? std::cos(angle) : std::sin(angle);
  }

  const Texture& texture_;
  bool circle_;
  std::vector<double> means_;
  double variance_ = 0;
};

// How far apart neighbours along an axis lie in Texture::values.
std::size_t stride_of(const Texture& texture, int axis) {
  std::size_t stride = axis < 2 ? 1 : texture.floats_per_slice();
  for (int a = axis < 2 ? 0 : 2; a < axis; ++a) stride *= static_cast<std::size_t>(texture.extents.size(a));
  return stride;
}

// Where the values at all positions along `axes` lie, relative to that at the origin; the first axis varies fastest.
std::vector<std::size_t> offsets_along(const Texture& texture, const std::vector<int>& axes) {
  std::vector<std::size_t> offsets = {0};
  for (const int axis : axes) {
    const std::size_t count = offsets.size();
    for (std::int64_t i = 1; i < texture.extents.size(axis); ++i)
      for (std::size_t k = 0; k < count; ++k)
        offsets.push_back(offsets[k] + static_cast<std::size_t>(i) * stride_of(texture, axis));
  }
  return offsets;
}

std::vector<int> other_axes(const Extents& extents, const std::vector<int>& axes) {
  std::vector<int> others;
  for (int axis = 0; axis < extents.num_axes(); ++axis)
    if (std::find(axes.begin(), axes.end(), axis) == axes.end()) others.push_back(axis);
  return others;
}

// FFTW makes and frees plans in one thread at a time; carrying them out is not restricted.
std::mutex& planning() {
  static std::mutex mutex;
  return mutex;
}

// Power of real blocks of one shape, summed (FFTW); the half spectrum that FFTW keeps.
class PowerSum {
 public:
  // sizes: the first varies fastest.
  explicit PowerSum(const std::vector<std::int64_t>& sizes) : sizes_(sizes), half_(sizes[0] / 2 + 1) {
    std::size_t rows = 1;
    std::vector<int> dimensions;
    for (auto size = sizes.rbegin(); size != sizes.rend(); ++size) dimensions.push_back(narrow<int>(*size));
    for (std::size_t a = 1; a < sizes.size(); ++a) rows *= static_cast<std::size_t>(sizes[a]);
    values_.resize(rows * static_cast<std::size_t>(sizes[0]));
    coefficients_.resize(rows * static_cast<std::size_t>(half_));
    sums_.resize(coefficients_.size());
    const std::lock_guard lock(planning());
    plan_ = fftw_plan_dft_r2c(static_cast<int>(dimensions.size()), dimensions.data(), values_.data(),
                              reinterpret_cast<fftw_complex*>(coefficients_.data()), FFTW_ESTIMATE);
    NOISELOOM_CHECK(plan_ != nullptr);
  }
  ~PowerSum() {
    const std::lock_guard lock(planning());
    fftw_destroy_plan(plan_);
  }
  PowerSum(const PowerSum&) = delete;
  PowerSum& operator=(const PowerSum&) = delete;

  std::vector<double>& values() { return values_; }
  void add() {
    fftw_execute(plan_);
    for (std::size_t i = 0; i < sums_.size(); ++i) sums_[i] += std::norm(coefficients_[i]);
  }
  // Of all frequencies: those that FFTW leaves out have the power of their mirror images.
  std::vector<double> whole() const {
    std::vector<double> power(values_.size());
    std::vector<std::int64_t> k(sizes_.size(), 0);
    for (double& p : power) {
      const bool mirrored = k[0] >= half_;
      std::size_t at = 0;
      for (std::size_t a = sizes_.size(); a-- > 1;)
        at = at * static_cast<std::size_t>(sizes_[a]) +
             static_cast<std::size_t>(mirrored ? (sizes_[a] - k[a]) % sizes_[a] : k[a]);
      p = sums_[at * static_cast<std::size_t>(half_) + static_cast<std::size_t>(mirrored ? sizes_[0] - k[0] : k[0])];
      for (std::size_t a = 0; a < k.size() && ++k[a] == sizes_[a]; ++a) k[a] = 0;
    }
    return power;
  }

 private:
  std::vector<std::int64_t> sizes_;
  std::int64_t half_;
  std::vector<double> values_;
  std::vector<std::complex<double>> coefficients_;
  std::vector<double> sums_;
  fftw_plan plan_ = nullptr;
};

// visit(index, |f|) for every frequency.
template <class Visit>
void for_each_frequency(const AxesSpectrum& spectrum, Visit visit) {
  std::vector<std::int64_t> k(spectrum.sizes.size(), 0);
  for (std::size_t i = 0; i < spectrum.power.size(); ++i) {
    double squares = 0;
    for (std::size_t a = 0; a < k.size(); ++a) {
      const std::int64_t size = spectrum.sizes[a];
      const double f = static_cast<double>(std::min(k[a], size - k[a])) / static_cast<double>(size);
      squares += f * f;
    }
    visit(i, std::sqrt(squares));
    for (std::size_t a = 0; a < k.size() && ++k[a] == spectrum.sizes[a]; ++a) k[a] = 0;
  }
}

// Means over rings round(f * longest) = 1, 2, ..., longest / 2.
class Rings {
 public:
  explicit Rings(std::int64_t longest) : longest_(longest), rings_(static_cast<std::size_t>(longest / 2 + 1)) {}
  void add(double frequency, double power) {
    const auto ring = static_cast<std::size_t>(std::lround(frequency * static_cast<double>(longest_)));
    if (ring == 0 || ring >= rings_.size()) return;
    rings_[ring].frequency += frequency;
    rings_[ring].power += power;
    rings_[ring].count += 1;
  }
  std::vector<SpectrumBin> means() const {
    std::vector<SpectrumBin> bins;
    for (const SpectrumBin& ring : rings_)
      if (ring.count > 0) bins.push_back({ring.frequency / ring.count, ring.power / ring.count, ring.count});
    return bins;
  }

 private:
  std::int64_t longest_;
  std::vector<SpectrumBin> rings_;
};

std::size_t centred_index(int kx, int ky, int width, int height) {
  const int x = (kx + width / 2) % width;
  const int y = (ky + height / 2) % height;
  return static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x);
}

PlaneSpectrum empty_spectrum(int width, int height) {
  return {width, height, std::vector<double>(static_cast<std::size_t>(width) * static_cast<std::size_t>(height))};
}

}  // namespace

AxesSpectrum axes_spectrum(const Texture& texture, DistanceKind kind, const std::vector<int>& axes) {
  NOISELOOM_CHECK(!axes.empty() && std::is_sorted(axes.begin(), axes.end()));
  AxesSpectrum spectrum;
  for (const int axis : axes) spectrum.sizes.push_back(texture.extents.size(axis));
  const Signals signals(texture, kind);
  const std::vector<std::size_t> offsets = offsets_along(texture, axes);
  const std::vector<std::size_t> origins = offsets_along(texture, other_axes(texture.extents, axes));
  PowerSum sum(spectrum.sizes);
  for (int signal = 0; signal < signals.count(); ++signal)
    for (const std::size_t origin : origins) {
      const float* const values = texture.values.data() + signals.plane_offset(signal) + origin;
      for (std::size_t i = 0; i < offsets.size(); ++i) sum.values()[i] = signals.centred(signal, values[offsets[i]]);
      sum.add();
    }
  spectrum.power = sum.whole();
  const double scale = static_cast<double>(origins.size()) * static_cast<double>(offsets.size()) * signals.variance();
  for (double& p : spectrum.power) p = scale > 0 ? p / scale : 0;
  spectrum.power[0] = 0;
  return spectrum;
}

PlaneSpectrum plane_spectrum(const Texture& texture, DistanceKind kind, int first, int second) {
  return centred(axes_spectrum(texture, kind, {first, second}));
}

PlaneSpectrum centred(const AxesSpectrum& spectrum) {
  NOISELOOM_CHECK_EQ(spectrum.sizes.size(), 2U);
  const int width = narrow<int>(spectrum.sizes[0]);
  const int height = narrow<int>(spectrum.sizes[1]);
  PlaneSpectrum plane = empty_spectrum(width, height);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      plane.power[centred_index(x, y, width, height)] =
          spectrum.power[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x)];
  return plane;
}

std::vector<SpectrumBin> radial_average(const PlaneSpectrum& spectrum) {
  Rings rings(std::max(spectrum.width, spectrum.height));
  for (int y = 0; y < spectrum.height; ++y)
    for (int x = 0; x < spectrum.width; ++x) {
      const double fx = static_cast<double>(x - spectrum.width / 2) / spectrum.width;
      const double fy = static_cast<double>(y - spectrum.height / 2) / spectrum.height;
      rings.add(std::sqrt(fx * fx + fy * fy), spectrum.at(x, y));
    }
  return rings.means();
}

std::vector<SpectrumBin> radial_average(const AxesSpectrum& spectrum) {
  Rings rings(*std::max_element(spectrum.sizes.begin(), spectrum.sizes.end()));
  for_each_frequency(spectrum, [&](std::size_t i, double f) { rings.add(f, spectrum.power[i]); });
  return rings.means();
}

double power_below(const AxesSpectrum& spectrum, double limit) {
  double sum = 0;
  std::int64_t count = 0;
  for_each_frequency(spectrum, [&](std::size_t i, double f) {
    if (f <= 0 || f >= limit) return;
    sum += spectrum.power[i];
    ++count;
  });
  return count > 0 ? sum / static_cast<double>(count) : std::numeric_limits<double>::quiet_NaN();
}

std::vector<SpectrumBin> row_average(const PlaneSpectrum& spectrum) {
  std::vector<SpectrumBin> bins;
  const int middle = spectrum.height / 2;
  for (int k = 0; k <= middle; ++k) {
    SpectrumBin bin{static_cast<double>(k) / spectrum.height, 0, 0};
    for (int x = 0; x < spectrum.width; ++x) {
      if (k == 0 && x == spectrum.width / 2) continue;  // frequency zero
      bin.power += spectrum.at(x, middle - k);
      ++bin.count;
    }
    if (bin.count == 0) continue;
    bin.power /= bin.count;
    bins.push_back(bin);
  }
  return bins;
}

PlaneSpectrum filter_response(const Footprint& footprint) {
  const int width = narrow<int>(footprint.extents().width());
  const int height = narrow<int>(footprint.extents().height());
  PlaneTransform transform(width, height);
  std::fill(transform.real().begin(), transform.real().end(), 0.0);
  transform.real()[0] = footprint.weight_zero();
  for (const PlaneTap& tap : footprint.slices().front().taps) {
    const std::size_t x = static_cast<std::size_t>((tap.dx + width) % width);
    const std::size_t y = static_cast<std::size_t>((tap.dy + height) % height);
    transform.real()[y * static_cast<std::size_t>(width) + x] += tap.weight;
  }
  transform.forward();
  PlaneSpectrum response = empty_spectrum(width, height);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      response.power[centred_index(x, y, width, height)] = std::max(0.0, transform.at(x, y).real());
  const double largest = *std::max_element(response.power.begin(), response.power.end());
  for (double& p : response.power) p = largest > 0 ? p / largest : 0;
  return response;
}

}  // namespace noiseloom
