// What a pixel of the texture holds, as plain values: the part of a config that names a sample space.
#pragma once

#include <string>
#include <vector>

#include "noiseloom/files/input_array.h"

namespace noiseloom {

// axis: of unit vectors of which each and its opposite are the same, such as unit quaternions that stand for rotations:
// the sine of the angle between them, |a - b| |a + b| / 2. It is the distance between the matrices a a^T and b b^T over
// sqrt(2), and so of negative type, as R must have it to be an error; the angle itself is not [Gangolli67].
//
// manhattan: the sum over the channels of |a - b|; chebyshev: the largest of them. The latter is of negative type for
// two channels, as a quarter turn of it is the former, and for no more [Misiewicz89]: R of three channels is a measure
// of how unlike neighbours are, and no error. cosine: of unit vectors, 1 - a b, which is half the square of the chord;
// only the mean of the vectors counts.
enum class DistanceKind { absolute, circle, euclidean, angle, axis, manhattan, chebyshev, cosine };

constexpr bool is_between_unit_vectors(DistanceKind kind) {
  return kind == DistanceKind::angle || kind == DistanceKind::axis || kind == DistanceKind::cosine;
}

// How samples of a built-in space are compared; own: as the space has it. cosine is for spaces of unit vectors.
enum class ComparedBy { own, euclidean, manhattan, chebyshev, cosine };

// A space-filling curve (src/samples/curve.h) that samples of two to four numbers are listed along, so that they can be
// constructed as scalars are. none: in the order of the strata.
enum class Curve { none, hilbert, morton };

// What an image of a density covers (README, "Any density", says which pixel lies where).
enum class ImageDomain { square, disk, sphere, hemisphere };

// How the numbers of an image stand for light. unstated: as linear does, but whoever begins a run is told.
enum class ImageEncoding { unstated, linear, srgb };

struct SampleSpec {
  std::string space = "uniform";   // a name of sample_spaces() (samples/space.h); "file": the user's own list;
                                   // "image": the density is the luminance of an image
  std::vector<double> parameters;  // of the space, in the order of its SpaceTraits::parameters; none: as it has them
  int channels = 1;                // file: as found in the file; else that of the space
  std::string file;                // file: a .npy of shape [n], [n, C] (one list for all slices), [S, n] or
                                   // [S, n, C] (one per slice, in slice order); n = cells per slice.
                                   // image: a picture, or a .npy of shape [height, width] or [height, width, C]
  InputArrayPtr array;             // file: its contents where they are known; else whoever needs them reads the file.
                                   // image: its luminance, [height, width]
  SharedValues<std::uint64_t> masses;  // image: what make_image_masses() (samples/luminance.h) makes of it, where ranks
                                       // share that; else whoever needs it makes it
  DistanceKind distance = DistanceKind::euclidean;   // file only: how its samples are compared
  ComparedBy compared_by = ComparedBy::own;          // built-in spaces that are compared by length or angle
  ImageDomain onto = ImageDomain::square;            // image only
  ImageEncoding encoding = ImageEncoding::unstated;  // image only

  Curve curve = Curve::none;  // vector2 to vector4 only

  bool is_file() const { return space == "file"; }
  bool is_image() const { return space == "image"; }
};

}  // namespace noiseloom
