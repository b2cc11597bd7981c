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

struct Pixels {
  std::vector<std::int64_t> shape;
  std::vector<double> values;
};

Pixels pixels_of_npy(const std::string& path) {
  NpyArray array = read_npy(path);
  Pixels pixels = {std::move(array.shape), std::move(array.values)};
  const auto over = [&](double largest) {
    for (double& value : pixels.values) value /= largest;
  };
  if (array.type.kind == NumberType::Kind::unsigned_integer && array.type.bytes <= 2) {
    over(array.type.bytes == 1 ? 255 : 65535);  // as of an image
  }
  return pixels;
}

Pixels pixels_of_image(const std::string& path) {
  const InputArrayPtr array = decode_image(path);
  const auto& values = std::get<std::vector<float>>(array->values);
  return {array->shape, {values.begin(), values.end()}};
}

// [IEC61966-2-1]
double light_of_srgb(double code) {
  if (!(code > 0.04045)) return code / 12.92;
  return math::pow((code + 0.055) / 1.055, 2.4);
}

}  // namespace

InputArrayPtr read_luminance(const SampleSpec& spec) {
  Pixels pixels = is_decoded(spec.file) ? pixels_of_image(spec.file) : pixels_of_npy(spec.file);
  std::vector<std::int64_t>& shape = pixels.shape;
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
    const auto outside = std::find_if(pixels.values.begin(), pixels.values.end(), [](double v) { return v > 1; });
    if (outside != pixels.values.end()) {
      throw UserError(spec.file, fmt::format("holds {}, but codes of sRGB are from 0 to 1; with numbers that are light "
                                             "themselves, encoding = \"linear\"",
                                             *outside));
    }
    std::transform(pixels.values.begin(), pixels.values.end(), pixels.values.begin(), light_of_srgb);
  }
  const auto stride = static_cast<std::size_t>(channels);
  std::vector<float> luminance(static_cast<std::size_t>(shape[0] * shape[1]));
  for (std::size_t i = 0; i < luminance.size(); ++i) {
    const double* const p = &pixels.values[i * stride];
    const double exact = channels < 3 ? *p : 0.2126 * p[0] + 0.7152 * p[1] + 0.0722 * p[2];
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
