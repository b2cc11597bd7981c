// The eye as a filter over frames: how much of a flicker it sees, at the spatial frequencies of noise.
//
// [Kelly79]: sensitivity to a grating of spatial frequency s (cycles a degree) that moves over the retina at v degrees
// a second,
//
//   G(s, v) = (6.1 + 7.3 |log10(v / 3)|^3) v a^2 exp(-2 a (v + 2) / 45.9),   a = 2 pi s
//
// A flicker of w cycles a second is two gratings that move at v = w / s in opposite directions. The eye is never still:
// v is at least the 0.15 degrees a second of its drift [Daly98]. Noise that is blue lies between a quarter of a cycle
// and half a cycle a pixel: s is taken in the middle, at 3/8 of the pixels a degree.
#pragma once

#include <vector>

namespace noiseloom {

// Sensitivity to a flicker of `hertz` >= 0, over the largest one at any frequency up to half of frames_per_second.
double eye_response(double hertz, double frames_per_second, double pixels_per_degree);

// Taps of frames, symmetric: their transform is the response up to half of frames_per_second. An odd number of them;
// cut where all that follow are below 5/1000 of the middle one.
std::vector<double> eye_taps(double frames_per_second, double pixels_per_degree);

}  // namespace noiseloom
