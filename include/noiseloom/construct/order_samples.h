// From the order in which the pixels of a scalar mask are turned on to its samples.
//
// The pixel at place r of N gets (r + 0.5) / N, or with n bits the middle of level floor(r 2^n / N). N is the number of
// pixels of the volume, or with Equalize::slice that of a slice and r the place among the slice's own pixels: then
// every slice has the same histogram, which single slices of a volume's order have only nearly.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "noiseloom/construct/spec.h"
#include "noiseloom/files/order_codec.h"

namespace noiseloom {

// bits = 0: the float32 nearest to (place + 0.5) / num_places of those in the same 2^16th of [0, 1). So it is never 1,
// and floor(2^n v) for n <= 16 is the level that the exact value has. bits = n: exactly (level + 0.5) / 2^n; the counts
// of any two levels differ by at most one. Requires place < num_places <= 2^48 and bits in [0, 16].
float sample_of_place(std::uint64_t place, std::uint64_t num_places, int bits);

// The samples of one slice. `order`: its bytes in the /order of a texture of `num_pixels`. Pixels without a place yet
// get NaN. Samples of pixels with a place are final in every phase of void and cluster.
std::vector<float> samples_of_order(std::span<const std::byte> order, const OrderCodec& codec, std::int64_t num_pixels,
                                    const OrderSpec& spec);

// The same of a list along a curve, with Equalize::slice: the pixel at place r among the slice's own gets the r-th
// sample of `list`, [sample][channel], which has as many as the slice has pixels. The result is [pixel][channel].
std::vector<float> samples_along_curve(std::span<const std::byte> order, const OrderCodec& codec,
                                       std::int64_t num_pixels, std::span<const float> list);

}  // namespace noiseloom
