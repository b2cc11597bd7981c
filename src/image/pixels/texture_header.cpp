#include "image/pixels/texture_header.h"

#include <fmt/format.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <limits>

#include "image/pixels/texel_formats.h"

namespace noiseloom {

void set_format(TextureHeader& header, const TexelFormat& format) {
  const std::string order = format.order;
  header.shape.type = format.type;
  header.is_srgb = format.is_srgb;
  header.numbers_per_texel = static_cast<int>(order.size());
  for (const char* const name : {"R", "G", "B", "A"}) {
    const std::size_t at = order.find(name);
    if (at == std::string::npos) continue;
    header.order.push_back(static_cast<int>(at));
    header.shape.channel_names.emplace_back(name);
  }
  header.shape.channels = static_cast<int>(header.order.size());
  if (header.shape.channels > 1 && header.shape.channel_names.back() == "A")
    header.shape.alpha = header.shape.channels - 1;
}

ImageClaim claim_of(const TextureHeader& header, const std::string& format) {
  ImageClaim claim{format};
  claim.width = header.shape.width;
  claim.height = header.shape.height;
  claim.unreadable = header.unreadable;
  if (!header.unreadable.empty()) return claim;
  const double bytes = static_cast<double>(header.data_offset) +
                       static_cast<double>(header.bytes_per_slice()) * static_cast<double>(header.num_slices);
  claim.least_bytes = bytes < 0x1p62 ? static_cast<std::int64_t>(bytes) : std::numeric_limits<std::int64_t>::max();
  return claim;
}

namespace {

class TextureInput final : public ImageInput {
 public:
  explicit TextureInput(TextureHeader (*read_header)(std::ifstream&)) : read_header_(read_header) {}

  bool open(const std::string& path) override {
    file_.open(path, std::ios::binary);
    if (!file_) return fail(std::strerror(errno));
    header_ = read_header_(file_);
    return header_.unreadable.empty() || fail(header_.unreadable);
  }
  bool seek(int part) override {
    part_ = part;
    return part < header_.num_slices;
  }
  ImagePart part() const override {
    ImagePart part;
    part.shape = header_.shape;
    part.full_width = header_.shape.width;
    part.full_height = header_.shape.height;
    part.is_srgb = header_.is_srgb;
    part.facts = header_.facts;
    return part;
  }
  bool read_all(PixelType type, std::byte* bytes) override { return read_rows(0, header_.shape.height, type, bytes); }
  bool read_rows(int first, int end, PixelType, std::byte* bytes) override {
    const std::size_t number = bytes_per_number(header_.shape.type);
    const std::size_t texel = number * static_cast<std::size_t>(header_.numbers_per_texel);
    const std::size_t row = texel * static_cast<std::size_t>(header_.shape.width);
    const std::size_t texels = static_cast<std::size_t>(header_.shape.width) * static_cast<std::size_t>(end - first);
    stored_.resize(texels * texel);
    file_.clear();
    file_.seekg(header_.data_offset + part_ * header_.bytes_per_slice() +
                static_cast<std::int64_t>(row) * static_cast<std::int64_t>(first));
    file_.read(reinterpret_cast<char*>(stored_.data()), static_cast<std::streamsize>(stored_.size()));
    if (!file_) return fail("the file ends before its last pixel");
    for (std::size_t t = 0; t < texels; ++t)
      for (const int place : header_.order) {
        std::memcpy(bytes, stored_.data() + t * texel + static_cast<std::size_t>(place) * number, number);
        bytes += number;
      }
    return true;
  }
  std::string error() override { return std::exchange(error_, ""); }

 private:
  bool fail(const std::string& why) {
    error_ = why;
    return false;
  }

  TextureHeader (*read_header_)(std::ifstream&);
  std::ifstream file_;
  TextureHeader header_;
  int part_ = 0;
  std::vector<std::byte> stored_;
  std::string error_;
};

}  // namespace

std::unique_ptr<ImageInput> texture_input(const std::string& format) {
  if (format == "ktx2") return std::make_unique<TextureInput>(read_ktx2_header);
  if (format == "dds") return std::make_unique<TextureInput>(read_dds_header);
  return nullptr;
}

}  // namespace noiseloom
