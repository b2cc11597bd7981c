// Passes that look at what is left of the noise: errors, pictures, spectra of the error.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "noiseloom/render/noise.h"
#include "noiseloom/render/passes.h"
#include "noiseloom/render/scene.h"
#include "render/jobs/job.h"

namespace noiseloom::render {

void measure(Job& job);
void keep(Job& job);
// Notes which pixels have had a sample.
void see(Job& job);
void stack(Job& job);

Counts work_of_errors(const Scene& scene, std::span<const Noise> noises);
std::int64_t bytes_of_errors(const Scene& scene, std::span<const Noise> noises);
std::int64_t bytes_of_pictures(const Scene& scene, std::span<const Noise> noises);
Counts work_of_spectra(const Scene& scene, std::span<const Noise> noises);
std::int64_t bytes_of_spectra(const Scene& scene, std::span<const Noise> noises);

// 1 - the mean structural similarity [Wang04] of the brightness of two pictures of so many channels, their values being
// of 0 to 1: windows are Gaussian, of deviation 1.5 and 11 pixels across.
double structural_error(const Image& a, const Image& b, int channels, Border border, Rows rows);

// The mean squares of what a difference of pictures holds at frequencies below 0.05 cycles a pixel, from there to 0.15,
// and above. The mean is left out.
std::array<double, 3> powers_in_bands(const Image& difference);

// Of the errors of pixels, each the root of the mean square of its channels: the median, what 99 % of them stay below,
// and the largest.
std::array<double, 3> quantiles_of_error(const Image& difference);

}  // namespace noiseloom::render
