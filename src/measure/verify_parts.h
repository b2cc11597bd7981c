// The parts of verify_texture. Each appends what it finds.
#pragma once

#include <string>
#include <vector>

#include "noiseloom/measure/verify.h"

namespace noiseloom::verify {

constexpr double odds = 1e-6;  // of a false alarm of one test

struct Subject {
  const StoredTexture& stored;
  std::vector<std::size_t> channels;  // of the file, that hold the samples
  SampleSpec samples;
  Texture texture;  // the samples, decoded
  double step = 0;  // between neighbouring values
};

// Which space the numbers are samples of, and why (verify_meaning.cpp).
Subject meaning_of(const StoredTexture& stored, bool is_given, std::string& why);

// Of the numbers alone (verify_values.cpp): range and support, distribution of all and of each slice, gamma, levels,
// alpha.
void check_values(const Subject& subject, Verification& found);
// Of slices beside each other (verify_slices.cpp): repeated, mirrored, out of order; of pixels beside each other: edges
// that do not meet, repeats inside.
void check_slices(const Subject& subject, Verification& found);
void check_edges(const Subject& subject, Verification& found);
// Behind which slices others are missing, as far as the spectra tell (verify_gaps.cpp); the last one: at an end.
std::vector<SliceIndex> gaps_behind(const Texture& texture);
// Of the spectra (verify_spectrum.cpp): peaks, seen as patterns.
void check_spectra(const Subject& subject, Verification& found);
// White or blue along the slices. `space`, `joint`: R under a Gauss over x and y, and with an exponential average
// behind it. Requires the spectra of check_spectra.
void check_time(const Subject& subject, const std::string& path, double space, double joint, Verification& found);

// A slice as a texture of its own.
Texture slice_of(const Texture& texture, SliceIndex slice);

// Of at least one value; of an even number, the upper one in the middle.
double median_of(std::vector<double> values);
// Whether the file says that the texture ends along that axis and does not begin again there.
bool ends_along(const Subject& subject, int axis);
// Whether the file says that its slices are a series with two ends, not a loop.
bool ends_along_slices(const Subject& subject);
// "3", "3 and 5", "3, 5, 7 and 12 more"
std::string list_text(const std::vector<SliceIndex>& numbers);

}  // namespace noiseloom::verify
