// How alike the values of a slice are to those some pixels away ([STBN22s], figure 10), and so how far apart reads of
// one texture must lie to act as reads of several.
//
//   A(d) = sum over pixels and channels of (s(p) - mean) (s(p + d) - mean), over the same at d = 0
//
// around the edges, averaged over slices: the transform of the power spectrum. White noise has 0 up to chance.
#pragma once

#include <cstddef>
#include <vector>

#include "noiseloom/measure/spectrum.h"

namespace noiseloom {

struct Autocorrelation {
  int width = 0;
  int height = 0;
  std::vector<double> values;  // [dy][dx], 0 <= dx < width: A at that offset, around the edges
  double chance = 0;           // standard deviation of A in white noise of as many values

  double at(int dx, int dy) const {
    return values[static_cast<std::size_t>(dy) * static_cast<std::size_t>(width) + static_cast<std::size_t>(dx)];
  }
};

// Of a spectrum over x and y (centred, as plane_spectrum makes it) that is the mean over `num_planes` slices.
Autocorrelation autocorrelation_of(const PlaneSpectrum& spectrum, double num_planes);

// |A| over the offsets whose length, rounded, is each whole number of pixels from 1 to half the shorter side.
struct CorrelationRing {
  int distance = 0;
  double mean = 0;     // of A
  double largest = 0;  // of |A|
};
std::vector<CorrelationRing> correlation_rings(const Autocorrelation& correlation);

// At this distance and every larger one no |A| is above `limit` or, where that is more, five times what chance gives.
// One more than the last ring where there is none.
inline constexpr double uncorrelated_limit = 0.02;
int uncorrelated_from(const std::vector<CorrelationRing>& rings, double chance);

}  // namespace noiseloom
