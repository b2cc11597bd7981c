// KTX2 and DDS: textures as graphics APIs take them, one level, no compression. Layers of an array, slices of a volume,
// or a slice a file follow the header one after the other, x fastest. (texture_header.h reads them.)
#include <fmt/format.h>

#include <numeric>

#include "image/containers/container_writers.h"
#include "image/facts/provenance.h"
#include "image/pixels/texel_formats.h"
#include "image/pixels/texture_bytes.h"
#include "noiseloom/core/error.h"

namespace noiseloom {
namespace {

struct TextureSizes {
  std::uint32_t width = 1;
  std::uint32_t height = 1;
  std::uint32_t slices = 1;
  std::size_t texel_bytes = 1;
  std::uint64_t data_bytes = 1;
};

TextureSizes sizes_of(const ContainerJob& job) {
  TextureSizes sizes;
  const bool strip = job.layout == ExportLayout::strip;
  const auto slices = static_cast<std::uint32_t>(job.num_slices);
  sizes.width = static_cast<std::uint32_t>(job.slice.width);
  sizes.height = static_cast<std::uint32_t>(job.slice.height) * (strip ? slices : 1);
  sizes.slices = strip ? 1 : slices;
  sizes.texel_bytes = bytes_per_number(job.slice.type) * static_cast<std::size_t>(job.slice.channels);
  sizes.data_bytes = std::uint64_t{sizes.width} * sizes.height * sizes.slices * sizes.texel_bytes;
  return sizes;
}

const TexelFormat& format_of(const ContainerJob& job) {
  const TexelFormat* const format = texel_format(job.slice.type, job.slice.channels);
  NOISELOOM_CHECK(format != nullptr);
  return *format;
}

// The basic descriptor block of the Khronos Data Format Specification, version 1.3: linear numbers of RGBA, a sample a
// channel.
std::string data_format_descriptor(const ImageShape& shape) {
  constexpr std::uint32_t model_rgbsda = 1;
  constexpr std::uint32_t primaries_bt709 = 1;
  constexpr std::uint32_t transfer_linear = 1;
  constexpr std::uint32_t channel_ids[] = {0, 1, 2, 15};  // red, green, blue, alpha
  constexpr std::uint32_t is_signed_float = 0xC0;
  const auto channels = static_cast<std::uint32_t>(shape.channels);
  const auto bits = static_cast<std::uint32_t>(8 * bytes_per_number(shape.type));
  const bool integer = is_integer(shape.type);
  const std::uint32_t block_size = 24 + 16 * channels;
  std::string bytes;
  append_u32(bytes, 4 + block_size);
  append_u32(bytes, 0);  // Khronos, a basic block
  append_u16(bytes, 2);
  append_u16(bytes, block_size);
  append_u32(bytes, model_rgbsda | primaries_bt709 << 8 | transfer_linear << 16);
  append_u32(bytes, 0);  // blocks of one texel
  append_u64(bytes, bits / 8 * channels);
  for (std::uint32_t c = 0; c < channels; ++c) {
    append_u32(bytes, c * bits | (bits - 1) << 16 | (channel_ids[c] | (integer ? 0 : is_signed_float)) << 24);
    append_u32(bytes, 0);
    append_u32(bytes, integer ? 0 : 0xBF800000);  // -1 and 1 as floats
    append_u32(bytes, integer ? (1U << bits) - 1 : 0x3F800000);
  }
  return bytes;
}

std::string key_values(std::vector<std::pair<std::string, std::string>> pairs) {
  std::sort(pairs.begin(), pairs.end());  // by the code points of the key
  std::string bytes;
  for (const auto& [key, value] : pairs) {
    append_u32(bytes, key.size() + value.size() + 2);
    bytes += key + '\0' + value + '\0';
    pad_to(bytes, 4);
  }
  return bytes;
}

// A header, which follows from the job alone, and then the bytes of all slices.
class HeadedWriter : public ContainerWriter {
 public:
  explicit HeadedWriter(OutputFiles& files) : files_(files) {}

  void begin(const std::string& target, const ContainerJob& job) final {
    stream_ = files_.open(target);
    stream_->append(header(job));
  }
  void slice(SliceIndex, std::span<const std::byte> bytes) final { stream_->append(bytes); }
  void end() final { stream_->close(); }

 private:
  virtual std::string header(const ContainerJob& job) const = 0;

  OutputFiles& files_;
  std::unique_ptr<OutputStream> stream_;
};

class Ktx2Writer : public HeadedWriter {
  using HeadedWriter::HeadedWriter;

  std::string header(const ContainerJob& job) const override {
    constexpr std::size_t index_end = 104;
    const TextureSizes sizes = sizes_of(job);
    const bool volume = job.layout == ExportLayout::volume;
    const bool array = job.layout == ExportLayout::array;
    const std::string descriptor = data_format_descriptor(job.slice);
    std::vector<std::pair<std::string, std::string>> pairs = {{"KTXorientation", volume ? "rdi" : "rd"},
                                                              {"KTXwriter", "noiseloom"},
                                                              {"noiseloom.description", job.description},
                                                              {"noiseloom.value", job.decoding}};
    if (job.holds_samples)
      for (const auto& [key, value] : reading_facts(job)) pairs.emplace_back("noiseloom." + key, value);
    for (const auto& [key, value] : job.facts) pairs.emplace_back("noiseloom." + key, value);
    const std::string keys = key_values(std::move(pairs));
    const std::size_t keys_at = index_end + descriptor.size();
    const std::size_t alignment = std::lcm(sizes.texel_bytes, std::size_t{4});
    const std::size_t data_at = (keys_at + keys.size() + alignment - 1) / alignment * alignment;

    std::string bytes("\xABKTX 20\xBB\r\n\x1A\n", 12);
    const bool packed = job.slice.type == PixelType::uint8;
    append_u32(bytes, format_of(job).vulkan);
    append_u32(bytes, packed ? 1 : bytes_per_number(job.slice.type));
    append_u32(bytes, sizes.width);
    append_u32(bytes, sizes.height);
    append_u32(bytes, volume ? sizes.slices : 0);
    append_u32(bytes, array ? sizes.slices : 0);
    append_u32(bytes, 1);  // face
    append_u32(bytes, 1);  // level
    append_u32(bytes, 0);  // no supercompression
    append_u32(bytes, index_end);
    append_u32(bytes, descriptor.size());
    append_u32(bytes, keys_at);
    append_u32(bytes, keys.size());
    append_u64(bytes, 0);  // no global data of a supercompression
    append_u64(bytes, 0);
    append_u64(bytes, data_at);
    append_u64(bytes, sizes.data_bytes);
    append_u64(bytes, sizes.data_bytes);
    bytes += descriptor + keys;
    bytes.resize(data_at, '\0');
    return bytes;
  }
};

// Flags and masks of the header's old description of pixels; red stands for luminance too.
struct OldPixelFormat {
  std::uint32_t flags, bits, red, green, blue, alpha;
};
constexpr OldPixelFormat old_pixel_formats[] = {
    {0x20000, 8, 0xff, 0, 0, 0},                     // L8
    {0x20001, 16, 0xff, 0, 0, 0xff00},               // L8A8
    {0x41, 32, 0xff, 0xff00, 0xff0000, 0xff000000},  // RGBA8
};

class DdsWriter : public HeadedWriter {
  using HeadedWriter::HeadedWriter;

  // A strip of 8 bits has the old header, which readers of single images know; all else the new one.
  std::string header(const ContainerJob& job) const override {
    constexpr std::uint32_t caps_height_width_pitch_format = 0x100F;
    constexpr std::uint32_t has_depth = 0x800000;
    constexpr std::uint32_t is_texture = 0x1000;
    constexpr std::uint32_t is_complex = 8;
    constexpr std::uint32_t is_volume = 0x200000;
    const TextureSizes sizes = sizes_of(job);
    const bool volume = job.layout == ExportLayout::volume;
    const bool old = job.layout == ExportLayout::strip && job.slice.type == PixelType::uint8;
    std::string bytes = "DDS ";
    append_u32(bytes, 124);
    append_u32(bytes, caps_height_width_pitch_format | (volume ? has_depth : 0));
    append_u32(bytes, sizes.height);
    append_u32(bytes, sizes.width);
    append_u32(bytes, sizes.width * sizes.texel_bytes);
    append_u32(bytes, volume ? sizes.slices : 0);
    append_u32(bytes, 1);  // level
    bytes.resize(76, '\0');
    append_u32(bytes, 32);
    if (old) {
      const OldPixelFormat& format = old_pixel_formats[job.slice.channels == 4 ? 2 : job.slice.channels - 1];
      append_u32(bytes, format.flags);
      append_u32(bytes, 0);
      for (const std::uint32_t field : {format.bits, format.red, format.green, format.blue, format.alpha})
        append_u32(bytes, field);
    } else {
      append_u32(bytes, 4);
      bytes += "DX10";
    }
    bytes.resize(108, '\0');
    append_u32(bytes, is_texture | (volume ? is_complex : 0));
    append_u32(bytes, volume ? is_volume : 0);
    bytes.resize(128, '\0');
    if (old) return bytes;
    append_u32(bytes, format_of(job).dxgi);
    append_u32(bytes, volume ? 4 : 3);  // dimension: three, two
    append_u32(bytes, 0);
    append_u32(bytes, volume ? 1 : sizes.slices);
    append_u32(bytes, 0);
    return bytes;
  }
};

}  // namespace

std::unique_ptr<ContainerWriter> make_ktx2_writer(OutputFiles& files) { return std::make_unique<Ktx2Writer>(files); }
std::unique_ptr<ContainerWriter> make_dds_writer(OutputFiles& files) { return std::make_unique<DdsWriter>(files); }

}  // namespace noiseloom
