#include "noiseloom/report/picture.h"

#include <algorithm>
#include <cmath>

#include "noiseloom/image/image_io.h"

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

Picture spectrum_picture(const PlaneSpectrum& spectrum, int most_pixels) {
  const int across = (spectrum.width + most_pixels - 1) / most_pixels;
  const int down = (spectrum.height + most_pixels - 1) / most_pixels;
  Picture picture = blank((spectrum.width + across - 1) / across, (spectrum.height + down - 1) / down);
  for (int y = 0; y < picture.height; ++y)
    for (int x = 0; x < picture.width; ++x) {
      double sum = 0;
      int count = 0;
      for (int v = y * down; v < std::min((y + 1) * down, spectrum.height); ++v)
        for (int u = x * across; u < std::min((x + 1) * across, spectrum.width); ++u, ++count) sum += spectrum.at(u, v);
      std::fill_n(picture.rgb.begin() + offset_of(picture, x, y), 3,
                  static_cast<std::uint8_t>(quantise(std::sqrt(sum / count / 2), 8)));
    }
  return picture;
}

Picture cropped(const Picture& picture, int width, int height) {
  Picture part = blank(std::min(width, picture.width), std::min(height, picture.height));
  for (int y = 0; y < part.height; ++y)
    std::copy_n(picture.rgb.begin() + offset_of(picture, 0, y), 3 * part.width,
                part.rgb.begin() + offset_of(part, 0, y));
  return part;
}

Picture enlarged(const Picture& picture, int across, int down) {
  Picture large = blank(picture.width * across, picture.height * down);
  for (int y = 0; y < large.height; ++y)
    for (int x = 0; x < large.width; ++x)
      std::copy_n(picture.rgb.begin() + offset_of(picture, x / across, y / down), 3,
                  large.rgb.begin() + offset_of(large, x, y));
  return large;
}

int factor_to_fill(int length, int size) { return std::max(1, size / length); }

void write_picture(const std::string& path, const Picture& picture, const std::string& description) {
  ImageJob job;
  job.block = {picture.width, picture.height, 3, PixelType::uint8, {"R", "G", "B"}, -1};
  job.description = description;
  write_image(path, job, [&](int) { return std::as_bytes(std::span(picture.rgb)); });
}

}  // namespace noiseloom
