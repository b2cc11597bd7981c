// Names of exported images, as renderers that already read the published textures expect them.
//
//   plain    quick_07.png    the run file's name, numbers padded to equal length
//   nvidia   the names of the published spatiotemporal blue noise:
//              stbn_scalar_2Dx1Dx1D_128x128x64x1_0.png    scalars with a sequence (void and cluster); a mask of fewer
//                                                         than four axes is named as one whose other axes have length 1
//              stbn_vec1_2Dx1D_128x128x64_0.png           scalars without one; vec2 to vec8; unitvec3, ...
//            PNGs of two and three channels are RGBA there, opaque.
//   ea       the names of the published filter-adapted noise:
//              real_uniform_gauss1_0_exp0101_separate05_0.png
//            {real|circle|vector2..|sphere}_{uniform|tent|gauss|coshemi}, then each group's filter, then how they
//            combine. Over x and y: box3x3, gauss1_0, binomial3x3 (N + 1 taps); over other axes: exp0101 (alpha 0.1,
//            rejection 0.1), Gauss10, Box3, Binomial2. A decimal point is _ over x and y, and left out elsewhere.
//   pattern  noise.{slice:04}.png    a place for the number (sequence.h); slices along several axes count on
#pragma once

#include <cstdint>
#include <string>

#include "noiseloom/problem/spec.h"

namespace noiseloom {

enum class NamingScheme { plain, nvidia, ea, pattern };

struct Naming {
  NamingScheme scheme = NamingScheme::plain;
  std::string pattern;  // pattern only; without extension or with it
};

// "plain", "nvidia", "ea", or a pattern with a place for the number. Throws UserError otherwise.
Naming parse_naming(const std::string& text);

// Why files cannot be written under that name: it holds something like a place for a number that is none, such as * or
// %x. "" where they can.
std::string why_no_file_name(const std::string& name);

// The name of the whole texture, without number and ending. `stem` is what the run file is called; `has_order`: it
// holds the sequence of its pixels.
std::string texture_name(const Naming& naming, const ProblemSpec& problem, const std::string& stem, bool has_order);
// The file name of one slice, with its ending (".png"). `name` comes from texture_name.
std::string slice_file_name(const Naming& naming, const std::string& name, std::int64_t slice, std::int64_t num_slices,
                            const std::string& ending);

// The filter in words: "box 5 over xy x ema 0.1 (rejection 0.1) over t".
std::string describe_filter(const Extents& extents, const FilterSpec& filter);

}  // namespace noiseloom
