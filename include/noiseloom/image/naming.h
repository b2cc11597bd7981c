// Names of exported images, as renderers that already read the published textures expect them.
//
//   plain   quick_07.png                              the run file's name, numbers padded to equal length
//   nvidia  stbn_vec2_2Dx1D_128x128x64_0.png          type, axes of each group, size
//   ea      real_uniform_gauss_1.0_exponential_0.1_0.1_product_0.png
//                                                     space, distribution, a filter for each group, how they combine
//   pattern noise.{slice:04}.png                      {slice}, {slice:0N} or %0Nd; slices along several axes count on
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

// The name of the whole texture, without number and extension. `stem` is what the run file is called.
std::string texture_name(const Naming& naming, const ProblemSpec& problem, const std::string& stem);
// The file name of one slice, with the extension (".png"). `name` comes from texture_name.
std::string slice_file_name(const Naming& naming, const std::string& name, std::int64_t slice, std::int64_t num_slices,
                            const std::string& extension);

// The filter in words: "box 5 over xy x ema 0.1 (rejection 0.1) over t".
std::string describe_filter(const Extents& extents, const FilterSpec& filter);

}  // namespace noiseloom
