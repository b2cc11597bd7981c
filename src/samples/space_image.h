// Samples whose density is the luminance of an image.
#pragma once

#include <memory>
#include <string>

#include "samples/spaces.h"

namespace noiseloom {

// What is known of it without the image.
SpaceTraits image_space_traits(ImageDomain onto);

// luminance: float, [height, width]. Throws UserError naming `path`, with the pixel, for what is no density: a value
// that is negative, NaN or infinite; no light at all where the space lies.
// `masses` is its table where that is there already (samples/luminance.h).
std::shared_ptr<const SampleSpace> image_space(InputArrayPtr luminance, ImageDomain onto, const std::string& path,
                                               SharedValues<std::uint64_t> masses = {});

// The space of a spec that is_image(); the same object as long as one of the same contents is in use. Reads the image
// where the spec does not hold it.
std::shared_ptr<const SampleSpace> shared_image_space(const SampleSpec& spec);

}  // namespace noiseloom
