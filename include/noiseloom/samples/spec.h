// What a pixel of the texture holds, as plain values: the part of a config that names a sample space.
#pragma once

#include <string>

namespace noiseloom {

enum class SampleKind { uniform, tent, gauss, circle, vector, sphere, hemisphere, hemisphere_cosine, disk, file };
enum class DistanceKind { absolute, circle, euclidean, angle };

struct SampleSpec {
  SampleKind kind = SampleKind::uniform;
  int channels = 1;  // vector: 2..8; file: found in the file; else fixed by the kind
  std::string file;  // file: a .npy of shape [n], [n, C] (one list for all slices), [S, n] or
                     // [S, n, C] (one per slice, in slice order); n = cells per slice
  DistanceKind distance = DistanceKind::euclidean;  // file only: how its samples are compared
};

}  // namespace noiseloom
