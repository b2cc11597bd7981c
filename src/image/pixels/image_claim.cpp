#include "image/pixels/image_claim.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <string_view>

#include "image/pixels/texture_header.h"

namespace noiseloom {
namespace {

std::uint64_t big_endian(std::string_view bytes) {
  std::uint64_t value = 0;
  for (const char byte : bytes) value = value << 8 | static_cast<unsigned char>(byte);
  return value;
}

// Numbers at places of a file; what lies beyond its end reads as zero.
class Bytes {
 public:
  explicit Bytes(std::ifstream& file) : file_(file) {}

  std::string text(std::int64_t at, std::size_t count) {
    std::string bytes(count, '\0');
    file_.clear();
    file_.seekg(at);
    file_.read(bytes.data(), static_cast<std::streamsize>(count));
    bytes.resize(static_cast<std::size_t>(std::max<std::streamsize>(0, file_.gcount())));
    return bytes;
  }
  std::uint64_t number(std::int64_t at, std::size_t count, bool is_big_endian) {
    std::string bytes = text(at, count);
    bytes.resize(count, '\0');
    if (!is_big_endian) std::ranges::reverse(bytes);
    return big_endian(bytes);
  }
  std::int64_t size() {
    file_.clear();
    file_.seekg(0, std::ios::end);
    return static_cast<std::int64_t>(file_.tellg());
  }
  std::int64_t signed_number(std::int64_t at, std::size_t count) {
    const std::uint64_t value = number(at, count, false);
    return count == 4 ? static_cast<std::int32_t>(static_cast<std::uint32_t>(value)) : static_cast<std::int64_t>(value);
  }

 private:
  std::ifstream& file_;
};

// Of chunks and attributes no image has more, and to look at so many takes seconds.
constexpr int most_pieces = 1 << 20;

// The library takes as much memory for a chunk of text or of colours as it is said to have bytes, and fills it.
std::string unreadable_png(Bytes& bytes) {
  const std::int64_t size = bytes.size();
  std::int64_t at = 8;
  for (int k = 0; at + 8 <= size; ++k) {
    if (k == most_pieces) return fmt::format("a PNG of more than {} chunks", most_pieces);
    const std::string head = bytes.text(at, 8);
    const auto length = static_cast<std::int64_t>(big_endian(head.substr(0, 4)));
    const std::string type = head.substr(4);
    if (type == "IEND") break;
    if (type != "IDAT" && length > size - at - 8) {
      const bool has_name = std::ranges::all_of(type, [](unsigned char c) { return std::isalpha(c) != 0; });
      return fmt::format("a PNG whose chunk {}at byte {} is said to have {} bytes, and {} follow; is it cut off?",
                         has_name ? type + " " : "", at, length, size - at - 8);
    }
    at += 12 + length;
  }
  return "";
}

ImageClaim png_claim(Bytes& bytes) {
  if (bytes.text(12, 4) != "IHDR") return {"png"};
  ImageClaim claim{"png", static_cast<std::int64_t>(bytes.number(16, 4, true)),
                   static_cast<std::int64_t>(bytes.number(20, 4, true))};
  claim.unreadable = unreadable_png(bytes);
  return claim;
}

// The library trusts runs of compressed files and indices into short palettes, and reads past its buffers for others.
std::string unreadable_bmp(std::uint64_t bits, std::uint64_t compression, std::uint64_t colours) {
  if (compression != 0) return "a compressed BMP; accepted: uncompressed BMP, or PNG";
  if (bits <= 8 && colours != 0 && colours != std::uint64_t{1} << bits) {
    return "a BMP whose palette has fewer colours than its pixels can name; accepted: BMP with a whole palette or "
           "without one, or PNG";
  }
  return "";
}

ImageClaim bmp_claim(Bytes& bytes) {
  if (bytes.number(14, 4, false) == 12)
    return {"bmp", static_cast<std::int64_t>(bytes.number(18, 2, false)),
            static_cast<std::int64_t>(bytes.number(20, 2, false))};
  const std::int64_t height = bytes.signed_number(22, 4);
  ImageClaim claim{"bmp", bytes.signed_number(18, 4), height < 0 ? -height : height};
  claim.unreadable = unreadable_bmp(bytes.number(28, 2, false), bytes.number(30, 4, false), bytes.number(46, 4, false));
  return claim;
}

ImageClaim tga_claim(Bytes& bytes) {
  return {"targa", static_cast<std::int64_t>(bytes.number(12, 2, false)),
          static_cast<std::int64_t>(bytes.number(14, 2, false))};
}

// The number at the front of `text`, which is then cut; 0 where there is none.
std::int64_t take_number(std::string_view& text) {
  std::int64_t value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{}) return 0;
  text.remove_prefix(static_cast<std::size_t>(end - text.data()));
  return value;
}

// "P5 width height": separated by blanks, with comments from # to the end of the line.
ImageClaim pnm_claim(Bytes& bytes) {
  constexpr std::size_t longest_header = 65536;
  const std::string head = bytes.text(2, longest_header);
  std::string_view text = head;
  const auto skip_blanks = [&] {
    while (!text.empty() && (std::isspace(static_cast<unsigned char>(text.front())) != 0 || text.front() == '#')) {
      if (text.front() == '#') text.remove_prefix(std::min(text.find('\n'), text.size() - 1));
      text.remove_prefix(1);
    }
  };
  ImageClaim claim{"pnm"};
  skip_blanks();
  claim.width = take_number(text);
  skip_blanks();
  claim.height = take_number(text);
  return claim;
}

// A blank line ends the header; then "-Y height +X width", in any orientation.
ImageClaim hdr_claim(Bytes& bytes) {
  constexpr std::size_t longest_header = 65536;
  const std::string head = bytes.text(0, longest_header);
  ImageClaim claim{"hdr"};
  const std::size_t end = head.find("\n\n");
  if (end == std::string::npos) return claim;
  std::string_view text = std::string_view(head).substr(end + 2);
  for (int axis = 0; axis < 2; ++axis) {
    if (text.size() < 4 || (text[0] != '-' && text[0] != '+') || text[2] != ' ') return claim;
    const char name = text[1];
    text.remove_prefix(3);
    const std::int64_t size = take_number(text);
    if (name != 'X' && name != 'Y') return claim;
    (name == 'X' ? claim.width : claim.height) = size;
    if (!text.empty()) text.remove_prefix(1);
  }
  return claim;
}

// The first directory of a TIFF: classic has 2 byte counts and 12 byte entries, BigTIFF 8 and 20.
ImageClaim tiff_claim(Bytes& bytes, bool big_endian) {
  const bool big = bytes.number(2, 2, big_endian) == 43;
  const std::size_t offset_size = big ? 8 : 4;
  const std::int64_t directory = static_cast<std::int64_t>(bytes.number(big ? 8 : 4, offset_size, big_endian));
  ImageClaim claim{"tiff"};
  if (directory <= 0) return claim;
  constexpr std::uint64_t most_entries = 4096;
  const std::uint64_t count = std::min(most_entries, bytes.number(directory, big ? 8 : 2, big_endian));
  for (std::uint64_t i = 0; i < count; ++i) {
    const std::int64_t entry = directory + (big ? 8 : 2) + static_cast<std::int64_t>(i) * (big ? 20 : 12);
    const std::uint64_t tag = bytes.number(entry, 2, big_endian);
    const std::uint64_t type = bytes.number(entry + 2, 2, big_endian);
    const std::size_t size = type == 3 ? 2 : type == 4 ? 4 : type == 16 && big ? 8 : 0;  // SHORT, LONG, LONG8
    if ((tag != 256 && tag != 257) || size == 0) continue;
    const std::uint64_t value = bytes.number(entry + (big ? 12 : 8), size, big_endian);
    (tag == 256 ? claim.width : claim.height) = static_cast<std::int64_t>(std::min<std::uint64_t>(value, 1ULL << 40));
  }
  return claim;
}

// The attributes of OpenEXR headers, one header a part: name, type, size, value; a name of no length ends a header, and
// a header without attributes those of several parts. The library takes as much memory for an attribute as it is said
// to have bytes, and fills it.
ImageClaim exr_claim(Bytes& bytes) {
  ImageClaim claim{"openexr"};
  constexpr std::uint64_t has_parts = 0x1000;
  constexpr std::size_t longest_name = 256;
  const std::int64_t file_size = bytes.size();
  const bool is_one_part = (bytes.number(4, 4, false) & has_parts) == 0;
  std::int64_t tile_width = 0;
  std::int64_t tile_height = 0;
  std::int64_t at = 8;
  bool is_first_part = true;
  for (int k = 0;; ++k) {
    if (k == most_pieces) {
      claim.unreadable = fmt::format("an OpenEXR file of more than {} attributes", most_pieces);
      break;
    }
    const std::string head = bytes.text(at, 2 * longest_name + 4);
    if (head.empty()) break;
    if (head[0] == '\0') {
      if (is_one_part || head.size() < 2 || head[1] == '\0') break;
      is_first_part = false;
      ++at;
      continue;
    }
    const std::size_t name_end = head.find('\0');
    if (name_end == std::string::npos) break;
    const std::size_t type_end = head.find('\0', name_end + 1);
    if (type_end == std::string::npos) break;
    const std::string name = head.substr(0, name_end);
    const std::int64_t value_at = at + static_cast<std::int64_t>(type_end) + 5;
    const auto size = static_cast<std::int64_t>(bytes.number(value_at - 4, 4, false));
    if (size > file_size - value_at) {
      claim.unreadable = fmt::format(
          "an OpenEXR file whose attribute at byte {} is said to have {} bytes, and {} "
          "follow; is it cut off?",
          at, size, std::max<std::int64_t>(0, file_size - value_at));
      break;
    }
    const auto number_at = [&](std::int64_t place) { return bytes.signed_number(value_at + place, 4); };
    if (is_first_part && name == "dataWindow" && size == 16) {
      claim.width = number_at(8) - number_at(0) + 1;
      claim.height = number_at(12) - number_at(4) + 1;
    } else if (is_first_part && name == "tiles" && size == 9) {
      tile_width = number_at(0);
      tile_height = number_at(4);
    }
    at = value_at + size;
  }
  // One offset of 8 bytes for each block: at most 256 rows, or a tile.
  double blocks = static_cast<double>(claim.height) / 256;
  if (tile_width > 0 && tile_height > 0)
    blocks = std::max(1.0, static_cast<double>(claim.width) / static_cast<double>(tile_width)) *
             std::max(1.0, static_cast<double>(claim.height) / static_cast<double>(tile_height));
  claim.least_bytes = static_cast<std::int64_t>(8 * std::clamp(blocks, 0.0, 0x1p60 / 8));
  return claim;
}

}  // namespace

ImageClaim read_image_claim(std::ifstream& file, const std::string& extension) {
  Bytes bytes(file);
  const std::string mark = bytes.text(0, 8);
  using namespace std::string_view_literals;
  if (mark == "\x89PNG\r\n\x1a\n"sv) return png_claim(bytes);
  if (mark.starts_with("\x76\x2f\x31\x01"sv)) return exr_claim(bytes);
  if (mark.starts_with("II*\0"sv) || mark.starts_with("II+\0"sv)) return tiff_claim(bytes, false);
  if (mark.starts_with("MM\0*"sv) || mark.starts_with("MM\0+"sv)) return tiff_claim(bytes, true);
  if (mark.starts_with("#?"sv)) return hdr_claim(bytes);
  if (mark == "\xABKTX 20\xBB"sv) return claim_of(read_ktx2_header(file), "ktx2");
  if (mark.starts_with("\xABKTX"sv)) return {"ktx", 1, 1, 0, "a file of KTX 1; accepted: KTX2"};
  if (mark.starts_with("DDS "sv)) return claim_of(read_dds_header(file), "dds");
  if (mark.starts_with("BM"sv)) return bmp_claim(bytes);
  if (mark.size() > 2 && mark[0] == 'P' && mark[1] >= '1' && mark[1] <= '6') return pnm_claim(bytes);
  if (extension == ".tga") return tga_claim(bytes);
  return {};
}

}  // namespace noiseloom
