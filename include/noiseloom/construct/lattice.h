// Rank-1 lattices: scalars in the most regular arrangement there is, which under small boxes has a smaller error than
// any noise, and under most other filters a larger one.
//
// The pixel at n has the phase theta(n) = sum_i h_i n_i / size_i mod 1, h_i being whole numbers, so that the pattern
// closes around the torus. The samples of a slice lie in the order of the phases of its pixels. Of these only L are
// different (at most lcm(width, height)); a second lattice, theta', orders the pixels of equal phase, and a slice that
// is ahead of another by a part of a turn has its samples turned by as many places. Uniform samples then have
//
//   R = sum_d F(d) (1/3 - D(d)) / (F(0) / 3)
//   D(d) = (1 - u) ((1 - p) a + p (1 - a)) + u ((1 - q) b + q (1 - b))
//   a = theta(d) + u / L mod 1,   b = theta(d) - (1 - u) / L mod 1,   u = theta'(d)
//
// D being the mean distance of the samples of pixels d apart, and 1/3 that of independent ones. Such pixels are a of a
// turn apart or, a share u of them, b, as theta' passes its end; p and q are the shares of either that pass the end of
// the turn, where samples begin anew: all but a and b, in the mean over slices, for each of which the turn ends at
// another place between two of the L phases. (Where L is large, 1/3 - D is twice the second Bernoulli polynomial,
// theta^2 - theta + 1/6, by which lattices are judged in quasi-Monte Carlo integration.) Pixels that both lattices have
// at the same phases follow each other in the order of memory; their D is taken to be a third of what they span, and
// where such pixels are left R is but estimated. Else this is R in the limit of many pixels. What find_lattice() found
// for 120 filters over slices of 30x30 to 64x64 had R within 3 % of it, for some of 10x10 twice as much.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "noiseloom/core/extents.h"
#include "noiseloom/core/index.h"
#include "noiseloom/problem/footprint.h"

namespace noiseloom {

struct Lattice {
  std::vector<std::int64_t> cycles;   // h_i, of each axis, in [0, size_i)
  std::vector<std::int64_t> between;  // of the second lattice, along x and y
  double relative_error;              // R by the equation above
};

// A lattice with as low an R as a search of seconds finds: over x and y by the taps within a slice, of which there must
// be one, then along one slice axis after the other. Depends on the overlap alone. Calls goes_on() once a second or
// more often; nothing once that returns false.
std::optional<Lattice> find_lattice(
    const Footprint& overlap, const std::function<bool()>& goes_on = [] { return true; });

// [y][x] of the first slice: how many of its pixels come before each. The seed says where in x and y the lattice
// begins.
std::vector<std::uint32_t> lattice_places(const Lattice& lattice, const Extents& extents, std::uint64_t seed);
// By how many places, modulo the pixels of a slice, those of `slice` are ahead of the first one's.
std::uint32_t places_ahead(const Lattice& lattice, const Extents& extents, SliceIndex slice);

}  // namespace noiseloom
