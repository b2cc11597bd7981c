// How blue a texture is: what is left at low frequencies, for every set of axes that its filter groups and for each
// slice axis alone.
//
//   low-frequency power   mean of P over the frequencies 0 < |f| < 0.05 cycles a pixel            white noise: 1
//   first bins            one axis of n slices: P at 1/n, 2/n and 3/n
//
// P as in spectrum.h: |FFT|^2 of a line, plane or volume over those axes, averaged over all positions along the others,
// over what white noise of the same variance has.
#pragma once

#include <string>
#include <vector>

#include "noiseloom/image/texture_file.h"
#include "noiseloom/measure/spectrum.h"
#include "noiseloom/problem/spec.h"

namespace noiseloom {

inline constexpr double low_frequency = 0.05;  // cycles a pixel

struct GroupQuality {
  std::string name;  // of the axes: "xy", "t", "zw"
  std::vector<int> axes;
  AxesSpectrum spectrum;
  double low_frequency_power = 0;  // NaN where no frequency is that low
  std::vector<double> first_bins;  // one slice axis alone: up to three
};

struct SpectralQuality {
  std::vector<GroupQuality> groups;   // xy, the slice axes, then the filter's other groups
  std::vector<std::string> left_out;  // groups over so many positions that a transform would not fit
};

// `filter` may be null. Axes of length 1 are left out, and groups over more than `most_positions`: the default is a
// transform of 4 GiB.
SpectralQuality spectral_quality(const Texture& texture, DistanceKind kind, const FilterSpec* filter,
                                 std::int64_t most_positions = std::int64_t{1} << 27);

// For people: a line with the low-frequency power of every group, and one with the first bins of each slice axis.
std::string quality_text(const SpectralQuality& quality);
// Members of a JSON object: "low_frequency_power": {"xy": ..., "t": null}, "first_bins": {"t": [...]}.
std::string quality_json(const SpectralQuality& quality);

}  // namespace noiseloom
