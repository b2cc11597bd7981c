#include "noiseloom/study/picture.h"

#include <algorithm>
#include <cmath>

#include "noiseloom/study/image_io.h"

namespace noiseloom {
namespace {

Picture blank(int width, int height) {
  return {width, height,
          std::vector<std::uint8_t>(static_cast<std::size_t>(width) * static_cast<std::size_t>(height) * 3, 255)};
}

// Where the pixel begins in `rgb`.
std::ptrdiff_t offset_of(const Picture& picture, int x, int y) {
  return 3 * (static_cast<std::ptrdiff_t>(y) * picture.width + x);
}

}  // namespace

ValueRange shown_range(const TextureFile& file) {
  if (file.config)
    if (const auto range = natural_range(file.config->problem.samples)) return *range;
  const auto [least, largest] = std::minmax_element(file.texture.values.begin(), file.texture.values.end());
  if (!file.config && *least >= 0 && *largest <= 1) return {};
  return *least < *largest ? ValueRange{static_cast<double>(*least), static_cast<double>(*largest)} : ValueRange{};
}

Picture slice_picture(const Texture& texture, const ValueRange& range, SliceIndex slice) {
  Picture picture = blank(narrow<int>(texture.extents.width()), narrow<int>(texture.extents.height()));
  const std::size_t cells = static_cast<std::size_t>(texture.extents.cells_per_slice());
  const float* const planes = texture.slice(slice);
  for (std::size_t cell = 0; cell < cells; ++cell)
    for (std::size_t c = 0; c < 3; ++c) {
      const std::size_t channel = texture.channels == 1 ? 0 : c;
      const bool there = channel < static_cast<std::size_t>(texture.channels);
      const double value = there ? static_cast<double>(planes[channel * cells + cell]) : 0;
      picture.rgb[3 * cell + c] =
          there ? static_cast<std::uint8_t>(quantise(to_unit(range, value), 8)) : std::uint8_t{0};
    }
  return picture;
}

Picture spectrum_picture(const PlaneSpectrum& spectrum) {
  Picture picture = blank(spectrum.width, spectrum.height);
  for (std::size_t i = 0; i < spectrum.power.size(); ++i)
    std::fill_n(picture.rgb.begin() + static_cast<std::ptrdiff_t>(3 * i), 3,
                static_cast<std::uint8_t>(quantise(std::sqrt(spectrum.power[i] / 2), 8)));
  return picture;
}

Picture enlarged(const Picture& picture, int factor) {
  Picture large = blank(picture.width * factor, picture.height * factor);
  for (int y = 0; y < large.height; ++y)
    for (int x = 0; x < large.width; ++x)
      std::copy_n(picture.rgb.begin() + offset_of(picture, x / factor, y / factor), 3,
                  large.rgb.begin() + offset_of(large, x, y));
  return large;
}

int factor_to_fill(const Picture& picture, int size) {
  return std::max(1, size / std::max(picture.width, picture.height));
}

Picture side_by_side(const std::vector<Picture>& pictures, int gap) {
  int width = -gap;
  for (const Picture& picture : pictures) width += picture.width + gap;
  Picture row = blank(width, pictures.front().height);
  int left = 0;
  for (const Picture& picture : pictures) {
    NOISELOOM_CHECK_EQ(picture.height, row.height);
    for (int y = 0; y < picture.height; ++y)
      std::copy_n(picture.rgb.begin() + offset_of(picture, 0, y), 3 * picture.width,
                  row.rgb.begin() + offset_of(row, left, y));
    left += picture.width + gap;
  }
  return row;
}

void write_picture(const std::string& path, const Picture& picture, const std::string& description) {
  ImageJob job;
  job.block = {picture.width, picture.height, 3, PixelType::uint8, {"R", "G", "B"}, -1};
  job.description = description;
  write_image(path, job, [&](int) { return std::as_bytes(std::span(picture.rgb)); });
}

}  // namespace noiseloom
