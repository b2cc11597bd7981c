// A filter "with holes" that is guided by the variance of what it filters, as in SVGF [Schied17]: levels of 5 x 5 taps
// that are 1, 2, 4, ... pixels apart, each weighed by how far its brightness lies from that of the middle, in standard
// deviations of the noise, and by edges of surfaces. Behind an average over time the variance is what that leaves of
// it; SVGF takes that of single frames, four to five times the deviation, and blurs the more.
//
// It is not linear: what it does to the mean of a picture is part of the errors behind it, and its truth is the
// unfiltered one.
#pragma once

#include <vector>

#include "render/world/image.h"
#include "render/world/surface.h"

namespace noiseloom::render {

// Brightness: of three channels the luminance (ITU-R BT.709), else the first channel. [pixel]
std::vector<float> brightness_of(const Image& image, int channels);

// The variance of each pixel's brightness among its 7 x 7 neighbours.
std::vector<float> variance_around(const std::vector<float>& brightness, int width, int height, Border border,
                                   Rows rows);

// The first `channels` of the image, filtered; the others as they are. `variance` is that of the brightness of each
// pixel. `hits`: null where the filter knows no edges.
Image a_trous(const Image& image, int channels, std::vector<float> variance, const Hits* hits,
              const SpaceFilterSpec& filter, Border border, Rows rows);

// Taps of a pixel, those of the variance among them.
std::int64_t a_trous_taps(const SpaceFilterSpec& filter);

}  // namespace noiseloom::render
