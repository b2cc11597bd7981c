// Whether the values of a texture have the distribution of its samples: gamma, stretched contrast and two tones change
// it, and R alone does not tell, as it asks only how values lie beside each other.
#pragma once

#include <string>

#include "noiseloom/image/texture_file.h"
#include "noiseloom/samples/spec.h"

namespace noiseloom {

// One sentence, or nothing where the distribution fits or is not known (samples of a file).
//
// Kolmogorov's distance between the values of each channel and the marginal distribution of the space, against the
// bound of Dvoretzky, Kiefer and Wolfowitz in Massart's form: for n independent samples P(D > e) <= 2 exp(-2 n e^2). A
// texture drawn at random from the space is warned of with odds below one in a million, a stratified one less often
// still. Values may besides be off by 1/256 of the range, as codes of 8 bits are. gauss is compared after shift and
// scale, where all values lie in [0, 1], as those of images do.
std::string distribution_warning(const Texture& texture, const SampleSpec& samples);

// The largest distance over the bound: at most 1 where the distribution fits. 0 for samples of a file.
double distribution_distance(const Texture& texture, const SampleSpec& samples);

}  // namespace noiseloom
