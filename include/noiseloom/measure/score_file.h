// R of a texture that is in memory: under the filter of its config and under others (problem/score.h has the formula).
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "noiseloom/core/parallel.h"
#include "noiseloom/image/texture_file.h"
#include "noiseloom/problem/spec.h"

namespace noiseloom {

struct FilterScore {
  std::string filter;  // in words
  double relative_error = 1;
};

struct TextureScore {
  double relative_error = 1;      // under the config's filter; white noise: 1
  bool exact = true;              // false where the mean distance is taken from a part of all pairs
  std::vector<double> per_slice;  // what each slice contributes: R is their mean
  std::vector<FilterScore> others;
};

// Filters over x and y alone that textures are commonly compared by: box 3 and 5, gauss 1.0, binomial 3x3; and, where
// there is a slice axis, ema 0.1 along the first one alone.
std::vector<FilterSpec> standard_filters(const Extents& extents);

// The R that the textures published with [FAST24] reach for these samples under a filter, as describe_filter names it:
// 8 bit, 128 x 128, with time 128 x 128 x 64. None where none was published.
std::optional<double> published_score(const SampleSpec& samples, const std::string& filter);

// Requires distance `kind` to fit the texture's channels.
TextureScore score_texture(const Texture& texture, DistanceKind kind, const FilterSpec& filter,
                           const std::vector<FilterSpec>& others, ThreadPool& pool);

// m of the score: the mean distance of all pairs of samples. Swaps inside slices do not change it, so textures of the
// same samples may share it. Throws UserError where all values are equal.
double mean_distance_of(const Texture& texture, DistanceKind kind, ThreadPool& pool);

// R alone, with an m that is known.
double relative_error_of(const Texture& texture, DistanceKind kind, const FilterSpec& filter, double mean_distance,
                         ThreadPool& pool);

}  // namespace noiseloom
