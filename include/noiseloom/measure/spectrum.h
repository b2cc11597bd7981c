// Power spectra of textures, scaled so that white noise with the same variance is 1 at every frequency.
//
//   P(k) = sum_c |X_c(k)|^2 / (N sum_c var_c)        X_c: discrete Fourier transform of N values of channel c
//
// averaged over all planes (lines, volumes) of the texture. The mean over all frequencies, zero included, is 1 up to
// what the planes' own means take. Values on a circle are transformed as (cos, sin). Frequency zero is left out: it is
// set to 0.
#pragma once

#include <span>
#include <vector>

#include "noiseloom/image/texture_file.h"
#include "noiseloom/problem/footprint.h"
#include "noiseloom/problem/spec.h"

namespace noiseloom {

// Centred: frequency (i - width/2) / width cycles a pixel at column i, zero at (width/2, height/2). Row-major.
struct PlaneSpectrum {
  int width = 0;
  int height = 0;
  std::vector<double> power;
  double at(int x, int y) const {
    return power[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x)];
  }
};

// Over the plane of axes `first` (columns) and `second` (rows); first < second. {0, 1}: each slice; {0, 2}: x and the
// first slice axis.
PlaneSpectrum plane_spectrum(const Texture& texture, DistanceKind kind, int first, int second);

// Over any axes, one or many, averaged over all positions along the others: X is then the transform of a line, a plane,
// a volume of N values.
struct AxesSpectrum {
  std::vector<std::int64_t> sizes;  // of the axes, in the order given; the first varies fastest in `power`
  std::vector<double> power;        // at frequency k / size along each axis, 0 <= k < size
};
// `axes`: ascending, each once, at least one.
AxesSpectrum axes_spectrum(const Texture& texture, DistanceKind kind, const std::vector<int>& axes);
// A spectrum over two axes with frequency zero in the middle.
PlaneSpectrum centred(const AxesSpectrum& spectrum);

struct SpectrumBin {
  double frequency = 0;  // cycles a pixel: the mean over the bin
  double power = 0;
  int count = 0;
};
// Mean over rings of frequencies of equal width, 1 / max(width, height), up to 1/2; empty rings are left out.
std::vector<SpectrumBin> radial_average(const PlaneSpectrum& spectrum);
// Mean over shells |f| of equal width, 1 / the longest size, up to 1/2. One axis: each frequency up to 1/2.
std::vector<SpectrumBin> radial_average(const AxesSpectrum& spectrum);
// Mean over the frequencies 0 < |f| < limit (cycles a pixel, Euclidean length over the axes); NaN where there is none.
double power_below(const AxesSpectrum& spectrum, double limit);
// Mean over the columns of each row, for frequencies 0 <= f <= 1/2 along the rows' axis: how power is spread over that
// axis, whatever happens along the other.
std::vector<SpectrumBin> row_average(const PlaneSpectrum& spectrum);

// How much of each frequency of a slice the filter lets through: the transform of the footprint's taps inside a slice,
// the largest value 1. Negative values (a footprint that is not an autocorrelation) are set to 0.
PlaneSpectrum filter_response(const Footprint& footprint);

}  // namespace noiseloom
