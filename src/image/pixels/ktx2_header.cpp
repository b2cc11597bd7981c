// Reading the header of KTX 2.0 (Khronos Texture Format, version 2.0): identifier of 12 bytes, thirteen fields of 32
// bits (format, sizes, offsets of the descriptor and of the key/value data), two of 64, and the index of levels.
#include <fmt/format.h>

#include "image/pixels/texel_formats.h"
#include "image/pixels/texture_bytes.h"
#include "image/pixels/texture_header.h"

namespace noiseloom {
namespace {

constexpr std::size_t header_size = 104;  // with the index of one level

std::string supercompression_name(std::uint32_t scheme) {
  constexpr const char* names[] = {"none", "BasisLZ", "Zstandard", "zlib"};
  return scheme < std::size(names) ? names[scheme] : fmt::format("scheme {}", scheme);
}

using KeyValues = std::vector<std::pair<std::string, std::string>>;

KeyValues read_key_values(std::ifstream& file, std::int64_t offset, std::int64_t length) {
  KeyValues pairs;
  constexpr std::int64_t longest = std::int64_t{1} << 20;
  std::string bytes(static_cast<std::size_t>(std::min(length, longest)), '\0');
  file.clear();
  file.seekg(offset);
  file.read(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  bytes.resize(static_cast<std::size_t>(std::max<std::streamsize>(file.gcount(), 0)));
  for (std::size_t at = 0; at + 4 <= bytes.size();) {
    const std::size_t size = u32_at(bytes, at);
    if (size > bytes.size() - at - 4) break;
    const std::string entry = bytes.substr(at + 4, size);
    const std::size_t zero = entry.find('\0');
    if (zero != std::string::npos) {
      const std::string value = entry.substr(zero + 1);
      pairs.emplace_back(entry.substr(0, zero), value.substr(0, value.find('\0')));
    }
    at += 4 + (size + 3) / 4 * 4;
  }
  return pairs;
}

// What stands behind a key, "" where it is missing.
std::string value_of_key(const KeyValues& pairs, const std::string& key) {
  for (const auto& [name, value] : pairs)
    if (name == key) return value;
  return "";
}

}  // namespace

TextureHeader read_ktx2_header(std::ifstream& file) {
  const auto bytes = header_bytes<header_size>(file, 0);
  const std::uint32_t vulkan = u32_at(bytes, 12);
  const std::uint32_t width = u32_at(bytes, 20);
  const std::uint32_t height = u32_at(bytes, 24);
  const std::uint32_t depth = u32_at(bytes, 28);
  const std::uint32_t layers = u32_at(bytes, 32);
  const std::uint32_t faces = u32_at(bytes, 36);
  const std::uint32_t levels = u32_at(bytes, 40);
  const std::uint32_t supercompression = u32_at(bytes, 44);
  const std::uint64_t level_offset = u64_at(bytes, 80);
  const std::uint64_t level_length = u64_at(bytes, 88);

  TextureHeader header;
  const auto refused = [&header](const std::string& why) {
    header.unreadable = "a KTX2 file with " + why;
    return header;
  };
  header.shape.width = fits_a_slice(width, height) ? static_cast<int>(width) : 1;
  header.shape.height = fits_a_slice(width, height) ? static_cast<int>(height) : 1;
  if (!fits_a_slice(width, height)) return refused(fmt::format("a size of {} x {}", width, height));
  if (supercompression != 0)
    return refused(fmt::format("supercompression ({}); accepted: none", supercompression_name(supercompression)));
  for (const TexelFormat& format : texel_formats())
    if (format.vulkan == vulkan && vulkan != 0) set_format(header, format);
  if (header.order.empty()) {
    header.unreadable = why_vulkan_format_not_read(vulkan);
    return header;
  }
  if (levels > 1) return refused(fmt::format("{} levels (mip maps); accepted: one", levels));
  if (faces != 1) return refused(fmt::format("{} faces (a cube map); accepted: one", faces));
  if (depth > 1 && layers > 1)
    return refused(fmt::format("{} layers of volumes; accepted: layers or a volume", layers));
  header.num_slices = std::max({depth, layers, 1U});
  if (header.num_slices > most_slices_of_a_texture)
    return refused(fmt::format("{} slices; accepted: at most {}", header.num_slices, most_slices_of_a_texture));
  const KeyValues pairs = read_key_values(file, u32_at(bytes, 56), u32_at(bytes, 60));
  const std::string own = "noiseloom.";
  for (const auto& [name, value] : pairs)
    if (name.starts_with(own)) header.facts.emplace_back(name.substr(own.size()), value);
  const std::string orientation = value_of_key(pairs, "KTXorientation");
  if (orientation.size() > 1 && (orientation[0] != 'r' || orientation[1] != 'd'))
    return refused(fmt::format("orientation \"{}\"; accepted: \"rd\" (x to the right, rows downward)", orientation));
  constexpr std::uint64_t most_offset = std::uint64_t{1} << 40;
  if (level_offset < header_size || level_offset > most_offset ||
      level_length !=
          static_cast<std::uint64_t>(header.bytes_per_slice()) * static_cast<std::uint64_t>(header.num_slices))
    return refused(fmt::format("{} bytes of pixels at {}, which do not fit its size of {} x {} x {}", level_length,
                               level_offset, width, height, header.num_slices));
  header.data_offset = static_cast<std::int64_t>(level_offset);
  return header;
}

}  // namespace noiseloom
