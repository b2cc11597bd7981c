#include "noiseloom/samples/luminance.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "noiseloom/core/error.h"
#include "noiseloom/core/math.h"
#include "noiseloom/files/image_decoder.h"
#include "noiseloom/files/npy.h"

namespace noiseloom {
namespace {

bool ends_in(const std::string& path, std::string_view ending) {
  if (path.size() < ending.size()) return false;
  return std::equal(ending.rbegin(), ending.rend(), path.rbegin(),
                    [](char a, char b) { return a == (b >= 'A' && b <= 'Z' ? b - 'A' + 'a' : b); });
}

InputArrayPtr pixels_of_npy(const std::string& path) {
  NpyArray array = read_npy(path);
  const bool is_code = array.type.kind == NumberType::Kind::unsigned_integer && array.type.bytes <= 2;
  const double largest = !is_code ? 1 : array.type.bytes == 1 ? 255 : 65535;  // as of an image
  std::vector<float> values(array.values.size());
  std::transform(array.values.begin(), array.values.end(), values.begin(),
                 [largest](double value) { return static_cast<float>(value / largest); });
  return std::make_shared<const InputArray>(InputArray{std::move(array.shape), std::move(values)});
}

// IEC 61966-2-1.
double light_of_srgb(double code) {
  if (!(code > 0.04045)) return code / 12.92;
  return math::pow((code + 0.055) / 1.055, 2.4);
}

}  // namespace

InputArrayPtr read_luminance(const SampleSpec& spec) {
  const InputArrayPtr pixels = is_decoded(spec.file) ? decode_image(spec.file) : pixels_of_npy(spec.file);
  const std::vector<std::int64_t>& shape = pixels->shape;
  const auto& values = std::get<SharedValues<float>>(pixels->values);
  const std::int64_t channels = shape.size() == 2 ? 1 : shape.size() == 3 ? shape[2] : 0;
  if (channels < 1 || channels > 4) {
    throw UserError(spec.file,
                    fmt::format("shape {}: accepted: (height, width), or (height, width, channels) of 1 to 4",
                                npy_shape_text(shape)));
  }
  if (shape[0] < 1 || shape[1] < 1 || shape[0] > max_image_side || shape[1] > max_image_side) {
    throw UserError(spec.file, fmt::format("shape {}: a density has 1 to {} rows and columns", npy_shape_text(shape),
                                           max_image_side));
  }
  if (spec.encoding == ImageEncoding::srgb) {
    const auto outside = std::find_if(values.begin(), values.end(), [](float v) { return v > 1; });
    if (outside != values.end()) {
      throw UserError(spec.file, fmt::format("holds {}, but codes of sRGB are from 0 to 1; with numbers that are light "
                                             "themselves, encoding = \"linear\"",
                                             *outside));
    }
  }
  const auto light = [&](float number) {
    return spec.encoding == ImageEncoding::srgb ? light_of_srgb(static_cast<double>(number))
                                                : static_cast<double>(number);
  };
  const auto stride = static_cast<std::size_t>(channels);
  std::vector<float> luminance(static_cast<std::size_t>(shape[0] * shape[1]));
  for (std::size_t i = 0; i < luminance.size(); ++i) {
    const float* const p = &values[i * stride];
    const double exact = channels < 3 ? light(*p) : 0.2126 * light(p[0]) + 0.7152 * light(p[1]) + 0.0722 * light(p[2]);
    luminance[i] = static_cast<float>(exact);
  }
  return std::make_shared<const InputArray>(InputArray{{shape[0], shape[1]}, std::move(luminance)});
}

bool is_decoded(const std::string& path) { return !ends_in(path, ".npy"); }

bool may_hold_codes(const std::string& path) {
  const auto has = [&path](std::string_view ending) { return ends_in(path, ending); };
  return !has(".npy") && !has(".exr") && !has(".hdr") && !has(".pfm");
}

}  // namespace noiseloom
