#include "noiseloom/study/spectrum.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "study/plane_transform.h"

namespace noiseloom {
namespace {

// The real-valued signals that stand for a texture: its channels, or cos and sin of a circle's.
class Signals {
 public:
  Signals(const Texture& texture, DistanceKind kind) : texture_(texture), circle_(kind == DistanceKind::circle) {
    const std::size_t cells = static_cast<std::size_t>(texture.extents.cells_per_slice());
    const double n = static_cast<double>(texture.extents.num_cells());
    for (int c = 0; c < count(); ++c) {
      double sum = 0;
      double squares = 0;
      for (SliceIndex s = 0; s < texture.extents.num_slices(); ++s)
        for (std::size_t cell = 0; cell < cells; ++cell) sum += value(c, s, cell);
      for (SliceIndex s = 0; s < texture.extents.num_slices(); ++s)
        for (std::size_t cell = 0; cell < cells; ++cell) {
          const double d = value(c, s, cell) - sum / n;
          squares += d * d;
        }
      means_.push_back(sum / n);
      variance_ += squares / n;
    }
  }
  int count() const { return circle_ ? 2 : texture_.channels; }
  double variance() const { return variance_; }  // summed over the signals
  double centred(int signal, SliceIndex slice, std::size_t cell) const {
    return value(signal, slice, cell) - means_[static_cast<std::size_t>(signal)];
  }

 private:
  double value(int signal, SliceIndex slice, std::size_t cell) const {
    const std::size_t cells = static_cast<std::size_t>(texture_.extents.cells_per_slice());
    const std::size_t channel = circle_ ? 0 : static_cast<std::size_t>(signal);
    const double v = static_cast<double>(texture_.slice(slice)[channel * cells + cell]);
    if (!circle_) return v;
    const double angle = 2 * std::numbers::pi * v;
    return signal == 0 ? std::cos(angle) : std::sin(angle);
  }

  const Texture& texture_;
  bool circle_;
  std::vector<double> means_;
  double variance_ = 0;
};

// Flat index of a cell of the whole texture as slice and cell.
struct Position {
  SliceIndex slice;
  std::size_t cell;
};

Position split(const Extents& extents, std::int64_t flat) {
  return {static_cast<SliceIndex>(flat / extents.cells_per_slice()),
          static_cast<std::size_t>(flat % extents.cells_per_slice())};
}

std::int64_t stride_of(const Extents& extents, int axis) {
  std::int64_t stride = 1;
  for (int a = 0; a < axis; ++a) stride *= extents.size(a);
  return stride;
}

// Flat indices of the first cells of all planes over two axes.
std::vector<std::int64_t> plane_origins(const Extents& extents, int first, int second) {
  std::vector<std::int64_t> origins;
  const std::int64_t stride_1 = stride_of(extents, first);
  const std::int64_t stride_2 = stride_of(extents, second);
  for (std::int64_t flat = 0; flat < extents.num_cells(); ++flat)
    if (flat / stride_1 % extents.size(first) == 0 && flat / stride_2 % extents.size(second) == 0)
      origins.push_back(flat);
  return origins;
}

std::size_t centred_index(int kx, int ky, int width, int height) {
  const int x = (kx + width / 2) % width;
  const int y = (ky + height / 2) % height;
  return static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x);
}

PlaneSpectrum empty_spectrum(int width, int height) {
  return {width, height, std::vector<double>(static_cast<std::size_t>(width) * static_cast<std::size_t>(height))};
}

}  // namespace

PlaneSpectrum plane_spectrum(const Texture& texture, DistanceKind kind, int first, int second) {
  const Extents& extents = texture.extents;
  const int width = narrow<int>(extents.size(first));
  const int height = narrow<int>(extents.size(second));
  const std::int64_t step_x = stride_of(extents, first);
  const std::int64_t step_y = stride_of(extents, second);
  const Signals signals(texture, kind);
  const std::vector<std::int64_t> origins = plane_origins(extents, first, second);
  PlaneTransform transform(width, height);
  PlaneSpectrum spectrum = empty_spectrum(width, height);
  for (int signal = 0; signal < signals.count(); ++signal)
    for (const std::int64_t origin : origins) {
      std::size_t i = 0;
      for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
          const Position p = split(extents, origin + x * step_x + y * step_y);
          transform.real()[i++] = signals.centred(signal, p.slice, p.cell);
        }
      transform.forward();
      for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
          spectrum.power[centred_index(x, y, width, height)] += std::norm(transform.at(x, y));
    }
  const double scale = static_cast<double>(origins.size()) * width * height * signals.variance();
  for (double& p : spectrum.power) p = scale > 0 ? p / scale : 0;
  spectrum.power[centred_index(0, 0, width, height)] = 0;
  return spectrum;
}

std::vector<SpectrumBin> radial_average(const PlaneSpectrum& spectrum) {
  const int longest = std::max(spectrum.width, spectrum.height);
  std::vector<SpectrumBin> rings(static_cast<std::size_t>(longest / 2 + 1));
  for (int y = 0; y < spectrum.height; ++y)
    for (int x = 0; x < spectrum.width; ++x) {
      const double fx = static_cast<double>(x - spectrum.width / 2) / spectrum.width;
      const double fy = static_cast<double>(y - spectrum.height / 2) / spectrum.height;
      const double f = std::sqrt(fx * fx + fy * fy);
      const std::size_t ring = static_cast<std::size_t>(std::lround(f * longest));
      if (ring == 0 || ring >= rings.size()) continue;
      rings[ring].frequency += f;
      rings[ring].power += spectrum.at(x, y);
      rings[ring].count += 1;
    }
  std::vector<SpectrumBin> bins;
  for (const SpectrumBin& ring : rings)
    if (ring.count > 0) bins.push_back({ring.frequency / ring.count, ring.power / ring.count, ring.count});
  return bins;
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
