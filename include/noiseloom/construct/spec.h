// What void and cluster and construction are asked for, as plain values: the settings of [optimizer] that they alone
// have, and their problems.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "noiseloom/core/extents.h"
#include "noiseloom/samples/sample_space.h"

namespace noiseloom {

// What holds every level equally often: the whole volume, or each slice of it.
enum class Equalize { volume, slice };

struct OrderSpec {
  double density = 0;        // share of the pixels in the initial pattern, [0, 0.5]; the paper has 0.1
  std::vector<int> bounded;  // axes that do not wrap around
  int bits = 0;              // 0: samples as fine as float32 holds them; else 2^bits levels
  Equalize equalize = Equalize::volume;
};

// How samples that can be constructed are compared: by their difference, or by the shorter way round a circle, which
// they divide evenly.
enum class SampleScale { line, circle };

// Nothing where samples of `channels` numbers cannot be constructed. Of a user's list nobody knows how evenly it
// divides a circle. Places along a curve are scalars.
inline std::optional<SampleScale> scale_of(const SampleSpec& samples, int channels) {
  if (samples.curve != Curve::none) return SampleScale::line;
  if (channels != 1) return std::nullopt;
  const DistanceKind distance = distance_kind(samples, 1);
  if (distance == DistanceKind::absolute) return SampleScale::line;
  if (distance == DistanceKind::circle && !samples.is_file()) return SampleScale::circle;
  return std::nullopt;
}

// How construction goes about it (construct/slice_construction.h).
struct ConstructSpec {
  double density = 0.03;  // share of the pixels of a slice in its start pattern, [0, 0.5]; on a circle it is half
  double sharpness = 0;   // exponent of the overlap in space, (0, 8]; 0: found from the problem
};

// What void and cluster solves (construct/void_and_cluster.h).
struct VacGroup {
  std::vector<int> axes;  // indices into Extents, each once
  double sigma_px = 1.9;
  std::vector<int> box_axes = {};  // those of `axes` along which the kernel is a box
  int box_size = 0;
  double weight = 1;                // above 0, at most 1; the largest of all groups is 1
  std::vector<int> tile_axes = {};  // slice axes among `axes`, which then have x and y
  double tail = 0;                  // [0, 1]; 0: none
  double tail_power = 1;            // [0.5, 16]
};

struct VacSpec {
  Extents extents;
  std::vector<VacGroup> groups;
  std::vector<bool> toroidal;  // per axis; empty: all
  double density = 0.10;       // share of the pixels in the initial pattern (rounded down), [0, 0.5]
  std::uint64_t seed = 1;
};

}  // namespace noiseloom
