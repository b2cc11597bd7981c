// The loaders behind load_texture, one for each kind of file.
#pragma once

#include "noiseloom/image/encoding.h"
#include "noiseloom/image/texture_file.h"

namespace noiseloom::loaders {

TextureFile run_file(const std::string& path, const std::optional<RunConfig>& config);
TextureFile images(const std::string& path, const std::optional<RunConfig>& config);
TextureFile npy(const std::string& path, const std::optional<RunConfig>& config);
TextureFile raw(const std::string& path, const std::optional<RunConfig>& config);

// Channels that samples of the config have; 0 where only the file knows.
int config_channels(const RunConfig& config);
// What stored numbers 0..1 stand for.
ValueRange stored_range(const std::optional<RunConfig>& config);
// "128 x 128" of the config's slices and so on, for messages.
std::string expected_size(const RunConfig& config);
// Stored floats of a signed space are either the values themselves or, if none is negative, 0.5 + 0.5 v (images that
// cannot hold negative numbers): decodes the latter and says so in `notes`.
void decode_floats(TextureFile& file);

}  // namespace noiseloom::loaders
