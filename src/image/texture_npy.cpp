// .npy arrays: [slice axes..., y, x] or [slice axes..., y, x, channel]; the slice axes may be flattened into one.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "image/texture_loaders.h"
#include "noiseloom/files/npy.h"

namespace noiseloom::loaders {
namespace {

std::string shape_text(const std::vector<std::int64_t>& shape) {
  std::string text;
  for (const std::int64_t n : shape) text += fmt::format("{}{}", text.empty() ? "" : ", ", n);
  return "[" + text + "]";
}

std::int64_t product(const std::vector<std::int64_t>& shape, std::size_t begin, std::size_t end) {
  std::int64_t n = 1;
  for (std::size_t i = begin; i < end; ++i) n *= shape[i];
  return n;
}

// Channels of an array of this shape, 0 where it does not fit the extents.
int fitting_channels(const std::vector<std::int64_t>& shape, const Extents& extents, int wanted) {
  const auto fits = [&](std::size_t axes) {  // `axes` dimensions before the channel
    return axes >= 2 && shape[axes - 1] == extents.width() && shape[axes - 2] == extents.height() &&
           product(shape, 0, axes - 2) == extents.num_slices();
  };
  if (wanted <= 1 && fits(shape.size())) return 1;
  if (shape.size() >= 3 && fits(shape.size() - 1) && (wanted == 0 || shape.back() == wanted))
    return static_cast<int>(std::min<std::int64_t>(shape.back(), 1 << 16));
  return 0;
}

// [y, x] and [slice, y, x] mean one channel; where the last of three or more dimensions is at most 8, it is the
// channel.
Extents suggested_extents(const std::vector<std::int64_t>& shape) {
  std::size_t axes = shape.size();
  if (axes >= 3 && shape.back() <= 8) --axes;
  const std::int64_t slices = product(shape, 0, axes - 2);
  const std::vector<std::int64_t> plane = {shape[axes - 1], shape[axes - 2]};
  return slices == 1 ? Extents(plane) : Extents({plane[0], plane[1], slices});
}

// Values that are all integers are codes of 8 or 16 bits; true if so.
bool decode_codes(std::vector<double>& values, const ValueRange& range, std::vector<std::string>& notes) {
  const double largest = values.empty() ? 0 : *std::max_element(values.begin(), values.end());
  const bool codes = largest > 1 && largest < 65536 &&
                     std::all_of(values.begin(), values.end(), [](double v) { return v >= 0 && v == std::floor(v); });
  if (!codes) return false;
  const int bits = largest < 256 ? 8 : 16;
  for (double& v : values) v = from_unit(range, dequantise(static_cast<std::uint16_t>(v), bits));
  notes.push_back(fmt::format("All values are integers: they were decoded as {} bit codes.", bits));
  return true;
}

}  // namespace

TextureFile npy(const std::string& path, const std::optional<RunConfig>& config) {
  NpyArray array = read_npy(path);
  TextureFile file;
  file.source = "NumPy array";
  file.config = config;
  const std::vector<std::int64_t>& shape = array.shape;
  if (shape.size() < 2 || product(shape, 0, shape.size()) == 0)
    throw UserError(path, fmt::format("shape {}: must be [slice axes..., y, x] or [slice axes..., y, x, channel]",
                                      shape_text(shape)));
  const Extents extents = config ? config->problem.extents : suggested_extents(shape);
  const int wanted = config ? config_channels(*config) : 0;
  const int channels = fitting_channels(shape, extents, wanted);
  if (channels == 0) {
    std::vector<std::int64_t> expected = extents.file_dimensions();
    if (wanted != 1) expected.push_back(wanted);
    throw UserError(path, fmt::format("shape {}, but the config says {}{}", shape_text(shape), shape_text(expected),
                                      wanted == 0 ? " (the last of any size)" : ""));
  }
  const bool decoded = decode_codes(array.values, stored_range(config), file.notes);
  file.texture = make_texture(extents, channels);
  NOISELOOM_CHECK_EQ(array.values.size(), file.texture.values.size());
  std::vector<float> slice(file.texture.floats_per_slice());
  for (SliceIndex s = 0; s < extents.num_slices(); ++s) {
    const auto from = array.values.begin() + static_cast<std::ptrdiff_t>(s) * static_cast<std::ptrdiff_t>(slice.size());
    std::transform(from, from + static_cast<std::ptrdiff_t>(slice.size()), slice.begin(),
                   [](double v) { return static_cast<float>(v); });
    interleaved_to_planar(slice, channels, file.texture.slice(s));
  }
  if (!decoded) decode_floats(file);
  return file;
}

}  // namespace noiseloom::loaders
