// A header for C (from C11 on) and C++ (from C++11 on): the numbers as an array [slice][y][x][channel], and its sizes.
#include <fmt/format.h>

#include "image/containers/container_writers.h"
#include "image/containers/source_text.h"
#include "noiseloom/core/extents.h"

namespace noiseloom {
namespace {

const char* c_type(PixelType type) {
  switch (type) {
    case PixelType::uint8:
      return "uint8_t";
    case PixelType::uint16:
    case PixelType::float16:
      return "uint16_t";
    case PixelType::uint32:
      return "uint32_t";
    case PixelType::float32:
      return "float";
  }
  return "";
}

class HeaderWriter : public ContainerWriter {
 public:
  explicit HeaderWriter(OutputFiles& files) : files_(files) {}

  void begin(const std::string& target, const ContainerJob& job) override {
    shape_ = job.slice;
    stream_ = files_.open(target);
    stream_->append(comment_lines(job.description));
    stream_->append(filled(R"(#pragma once

#include <stdint.h>

#ifdef __cplusplus
#define $NAME_array alignas(16) static constexpr
#else
#define $NAME_array static _Alignas(16) const
#endif

enum { $NAME_width = $W, $NAME_height = $H, $NAME_slices = $Z, $NAME_channels = $C };

// [slice][y][x]$INDEX; value = $VALUE
$NAME_array $TYPE $NAME[$Z][$H][$W]$DIMENSION = {
)",
                           {{"$NAME", identifier_of(target)},
                            {"$W", std::to_string(shape_.width)},
                            {"$H", std::to_string(shape_.height)},
                            {"$Z", std::to_string(job.num_slices)},
                            {"$C", std::to_string(shape_.channels)},
                            {"$INDEX", shape_.channels > 1 ? "[channel]" : ""},
                            {"$DIMENSION", shape_.channels > 1 ? fmt::format("[{}]", shape_.channels) : ""},
                            {"$TYPE", c_type(shape_.type)},
                            {"$VALUE", job.decoding}}));
    end_ = filled("};\n\n#undef $NAME_array\n", {{"$NAME", identifier_of(target)}});
  }
  void slice(SliceIndex, std::span<const std::byte> bytes) override {
    std::string text = "{\n";
    std::size_t index = 0;
    for (int y = 0; y < shape_.height; ++y) {
      text += "{";
      for (int x = 0; x < shape_.width; ++x) {
        if (shape_.channels > 1) text += "{";
        for (int c = 0; c < shape_.channels; ++c) text += stored_number_text(bytes, shape_.type, index++) + ",";
        text.pop_back();
        text += shape_.channels > 1 ? "}," : ",";
      }
      text.back() = '}';
      text += ",\n";
    }
    stream_->append(text + "},\n");
  }
  void end() override {
    stream_->append(end_);
    stream_->close();
  }

 private:
  OutputFiles& files_;
  std::unique_ptr<OutputStream> stream_;
  ImageShape shape_;
  std::string end_;
};

}  // namespace

std::unique_ptr<ContainerWriter> make_header_writer(OutputFiles& files) {
  return std::make_unique<HeaderWriter>(files);
}

}  // namespace noiseloom
