// Reading the header of DDS (DirectDraw Surface): "DDS ", 124 bytes with sizes and the old description of pixels (bit
// masks, or a four-letter code), and after the code "DX10" 20 bytes more with a DXGI format and the size of the array.
#include <fmt/format.h>

#include <cstring>

#include "image/pixels/texel_formats.h"
#include "image/pixels/texture_bytes.h"
#include "image/pixels/texture_header.h"

namespace noiseloom {
namespace {

constexpr std::size_t old_size = 128;
constexpr std::size_t dx10_size = 148;

// Old descriptions by masks: bits of a texel, those of red (or luminance), green, blue and alpha.
struct MaskedFormat {
  std::uint32_t bits, red, green, blue, alpha;
  TexelFormat format;
};
constexpr MaskedFormat masked_formats[] = {
    {8, 0xff, 0, 0, 0, {PixelType::uint8, "R"}},
    {16, 0xff, 0, 0, 0xff00, {PixelType::uint8, "RG"}},  // luminance and alpha: two channels that are no colours
    {16, 0xff, 0xff00, 0, 0, {PixelType::uint8, "RG"}},
    {16, 0xffff, 0, 0, 0, {PixelType::uint16, "R"}},
    {32, 0xffff, 0xffff0000, 0, 0, {PixelType::uint16, "RG"}},
    {32, 0xff, 0xff00, 0xff0000, 0xff000000, {PixelType::uint8, "RGBA"}},
    {32, 0xff, 0xff00, 0xff0000, 0, {PixelType::uint8, "RGBX"}},
    {32, 0xff0000, 0xff00, 0xff, 0xff000000, {PixelType::uint8, "BGRA"}},
    {32, 0xff0000, 0xff00, 0xff, 0, {PixelType::uint8, "BGRX"}},
    {24, 0xff0000, 0xff00, 0xff, 0, {PixelType::uint8, "BGR"}},
};
// Old descriptions by a number in the place of the four letters (D3DFORMAT).
struct NumberedFormat {
  std::uint32_t number;
  TexelFormat format;
};
constexpr NumberedFormat numbered_formats[] = {
    {36, {PixelType::uint16, "RGBA"}},   {111, {PixelType::float16, "R"}}, {112, {PixelType::float16, "RG"}},
    {113, {PixelType::float16, "RGBA"}}, {114, {PixelType::float32, "R"}}, {115, {PixelType::float32, "RG"}},
    {116, {PixelType::float32, "RGBA"}},
};

// "DXT5", or the number.
std::string code_name(std::uint32_t code) {
  std::string name(4, '\0');
  for (std::size_t i = 0; i < 4; ++i) name[i] = static_cast<char>(code >> (8 * i) & 255);
  const bool letters = std::all_of(name.begin(), name.end(), [](char c) { return c > 32 && c < 127; });
  return letters ? name : fmt::format("number {}", code);
}

void set_old_format(TextureHeader& header, std::span<const char> bytes) {
  constexpr std::uint32_t has_code = 4;
  const std::uint32_t flags = u32_at(bytes, 80);
  const std::uint32_t code = u32_at(bytes, 84);
  if ((flags & has_code) != 0) {
    for (const NumberedFormat& known : numbered_formats)
      if (known.number == code) set_format(header, known.format);
    if (header.order.empty())
      header.unreadable = fmt::format(
          "format {} is not read (DXT and BC are blocks, which are lossy: they change noise)", code_name(code));
    return;
  }
  const std::uint32_t masks[] = {u32_at(bytes, 88), u32_at(bytes, 92), u32_at(bytes, 96), u32_at(bytes, 100),
                                 u32_at(bytes, 104)};
  // Without the flag the mask of alpha means nothing; of luminance only red's does.
  const std::uint32_t alpha = (flags & 1) != 0 ? masks[4] : 0;
  const bool luminance = (flags & 0x20000) != 0;
  for (const MaskedFormat& known : masked_formats)
    if (known.bits == masks[0] && known.red == masks[1] && known.alpha == alpha &&
        (luminance || (known.green == masks[2] && known.blue == masks[3])) && header.order.empty())
      set_format(header, known.format);
  if (header.order.empty())
    header.unreadable = fmt::format("{} bits a pixel with masks {:x}, {:x}, {:x}, {:x} are not read", masks[0],
                                    masks[1], masks[2], masks[3], alpha);
}

}  // namespace

TextureHeader read_dds_header(std::ifstream& file) {
  const auto bytes = header_bytes<dx10_size>(file, 0);
  const std::uint32_t height = u32_at(bytes, 12);
  const std::uint32_t width = u32_at(bytes, 16);
  const std::uint32_t depth = u32_at(bytes, 24);
  const std::uint32_t levels = u32_at(bytes, 28);
  const std::uint32_t code = u32_at(bytes, 84);
  const std::uint32_t further = u32_at(bytes, 112);
  const bool is_dx10 = (u32_at(bytes, 80) & 4) != 0 && code == 0x30315844;  // "DX10"
  constexpr std::uint32_t cube = 0x200;
  constexpr std::uint32_t volume = 0x200000;

  TextureHeader header;
  const auto refused = [&header](const std::string& why) {
    header.unreadable = "a DDS file with " + why;
    return header;
  };
  header.shape.width = fits_a_slice(width, height) ? static_cast<int>(width) : 1;
  header.shape.height = fits_a_slice(width, height) ? static_cast<int>(height) : 1;
  if (!fits_a_slice(width, height)) return refused(fmt::format("a size of {} x {}", width, height));
  std::uint32_t array = 1;
  if (is_dx10) {
    const std::uint32_t dxgi = u32_at(bytes, 128);
    array = std::max(u32_at(bytes, 140), 1U);
    for (const TexelFormat& format : texel_formats())
      if (format.dxgi == dxgi && dxgi != 0) set_format(header, format);
    if (header.order.empty()) header.unreadable = why_dxgi_format_not_read(dxgi);
  } else {
    set_old_format(header, bytes);
  }
  if (!header.unreadable.empty()) return header;
  if (levels > 1) return refused(fmt::format("{} levels (mip maps); accepted: one", levels));
  if ((further & cube) != 0 || (is_dx10 && (u32_at(bytes, 136) & 4) != 0)) return refused("a cube map");
  const bool is_volume = (further & volume) != 0 || (is_dx10 && u32_at(bytes, 132) == 4);
  if (is_volume && array > 1) return refused("an array of volumes; accepted: an array or a volume");
  header.num_slices = is_volume ? std::max(depth, 1U) : array;
  if (header.num_slices > most_slices_of_a_texture)
    return refused(fmt::format("{} slices; accepted: at most {}", header.num_slices, most_slices_of_a_texture));
  header.data_offset = static_cast<std::int64_t>(is_dx10 ? dx10_size : old_size);
  return header;
}

}  // namespace noiseloom
