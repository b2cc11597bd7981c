// What members.cpp compares: members of one size, and the spectrum of each, half of which says all, as the values are
// real.
#pragma once

#include <complex>
#include <memory>
#include <string>
#include <vector>

#include "noiseloom/image/texture_file.h"
#include "noiseloom/measure/members.h"
#include "noiseloom/problem/spec.h"

namespace noiseloom::members {

inline constexpr int num_bands = 8;

// The members whose spectra have the same frequencies.
struct OfOneSize {
  Extents extents;
  int channels = 0;
  bool circle = false;
  std::vector<std::size_t> numbers;

  bool is_same(const OfOneSize& other) const {
    return extents == other.extents && channels == other.channels && circle == other.circle;
  }
};

DistanceKind kind_of(const StoredTexture& stored);
OfOneSize size_of(const StoredTexture& stored);
StoredTexture load(const MemberFile& file);

// Members of the same settings have the same size: the first of them is asked for it.
std::vector<OfOneSize> by_size(const std::vector<MemberFile>& files, ThreadPool& pool);

struct MemberSpectrum {
  std::size_t number = 0;                     // of the member
  std::string seed;                           // "" where nobody knows
  std::vector<std::complex<float>> spectrum;  // [signal][...][ky][kx <= width / 2], frequency 0 set to 0
  double power = 0;                           // of all frequencies
  double band_power[num_bands] = {};
  std::vector<float> values;  // [signal], each sorted
};

// Transforms of one shape, for any number of threads.
class Transforms {
 public:
  explicit Transforms(const Extents& extents);
  ~Transforms();
  Transforms(const Transforms&) = delete;
  Transforms& operator=(const Transforms&) = delete;

  std::size_t cells() const { return cells_; }
  std::size_t half() const { return half_; }  // frequencies of a half spectrum
  // How often a frequency of the half spectrum stands for itself and its mirror image: 1 or 2. And its band.
  double weight(std::size_t k) const;
  int band(std::size_t k) const { return bands_[k]; }
  double frequencies_in_band(int band) const;
  std::string shift_text(std::size_t cell) const;

  void forward(std::vector<double>& values, std::vector<std::complex<double>>& spectrum) const;
  void inverse(std::vector<std::complex<double>>& spectrum, std::vector<double>& values) const;

 private:
  struct Plans;
  Extents extents_;
  std::size_t cells_;
  std::size_t half_;
  std::size_t row_;  // frequencies of a row
  std::vector<int> bands_;
  std::unique_ptr<Plans> plans_;
};

MemberSpectrum spectrum_of(const Texture& texture, DistanceKind kind, std::size_t number, const Transforms& transforms);

}  // namespace noiseloom::members
