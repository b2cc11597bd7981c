// Shader code in HLSL, GLSL and WGSL that gives the value of a pixel in a frame (texture_read.h): with the numbers as
// an array, or as a function that reads them from a texture of layers.
//
// The three languages share their expressions but for the names of types. Numbers of 8 and 16 bits are packed into
// unsigned integers of 32, the first in the lowest bits, as shader languages have no smaller ones.
#include <fmt/format.h>

#include <cstring>

#include "image/containers/container_writers.h"
#include "image/containers/source_text.h"
#include "noiseloom/core/error.h"
#include "noiseloom/image/texture_read.h"

namespace noiseloom {
namespace {

struct Language {
  const char* name;
  const char* constants;      // sizes
  const char* numbers_begin;  // before the array
  const char* numbers_end;
  const char* unit;  // of an array: the number at a place, 0 to 1 or the value itself
  const char* load_array;
  const char* load_texture;
  const char* place;  // the lines that find where a pixel of a frame is read
  const char* scalar;
  const char* vector;        // {} stands for its size
  std::size_t most_numbers;  // of an array; 0: any
};

// Where a pixel of a frame is read.
constexpr const char* place_hlsl = R"(    uint2 size = uint2($NAME_width, $NAME_height);
    uint2 offset = ((uint2(3242174889u, 2447445414u) * index >> 16) * size) >> 16;
    uint round = frame / $NAME_slices;
    offset += uint2($SXu * (round % size.x) % size.x, $SYu * ((round / size.x + round % size.x) % size.y) % size.y);
    uint2 place = (pixel + offset) % size;
)";
constexpr const char* place_glsl = R"(    uvec2 size = uvec2($NAME_width, $NAME_height);
    uvec2 offset = ((uvec2(3242174889u, 2447445414u) * index >> 16) * size) >> 16;
    uint round = frame / $NAME_slices;
    offset += uvec2($SXu * (round % size.x) % size.x, $SYu * ((round / size.x + round % size.x) % size.y) % size.y);
    uvec2 place = (pixel + offset) % size;
)";
constexpr const char* place_wgsl = R"(    let size = vec2<u32>($NAME_width, $NAME_height);
    var offset = (((vec2<u32>(3242174889u, 2447445414u) * index) >> vec2<u32>(16u, 16u)) * size) >> vec2<u32>(16u, 16u);
    let round = frame / $NAME_slices;
    offset += vec2<u32>($SXu * (round % size.x) % size.x, $SYu * ((round / size.x + round % size.x) % size.y) % size.y);
    let place = (pixel + offset) % size;
)";

constexpr Language hlsl = {
    "HLSL",
    "static const uint $NAME_width = $Wu;\nstatic const uint $NAME_height = $Hu;\nstatic const uint $NAME_slices = "
    "$Zu;\n",
    "static const $WORD $NAME_numbers[$N] = {\n",
    "};\n",
    "float $NAME_unit(uint place)\n{\n    return $UNIT;\n}\n",
    "$FLOATS $NAME_load(uint2 pixel, uint frame, uint index)\n{\n$PLACE"
    "    uint first = ((frame % $NAME_slices * size.y + place.y) * size.x + place.x) * $Cu;\n"
    "    return $DECODED;\n}\n",
    "$FLOATS $NAME_load(Texture2DArray<float4> noise, uint2 pixel, uint frame, uint index)\n{\n$PLACE"
    "    float4 stored = noise.Load(int4(place, frame % $NAME_slices, 0));\n"
    "    return $DECODED;\n}\n",
    place_hlsl,
    "float",
    "float{}",
    0};
constexpr Language glsl = {
    "GLSL",
    "const uint $NAME_width = $Wu;\nconst uint $NAME_height = $Hu;\nconst uint $NAME_slices = $Zu;\n",
    "const $WORD $NAME_numbers[$N] = $WORD[$N](\n",
    ");\n",
    "float $NAME_unit(uint place)\n{\n    return $UNIT;\n}\n",
    "$FLOATS $NAME_load(uvec2 pixel, uint frame, uint index)\n{\n$PLACE"
    "    uint first = ((frame % $NAME_slices * size.y + place.y) * size.x + place.x) * $Cu;\n"
    "    return $DECODED;\n}\n",
    "$FLOATS $NAME_load(sampler2DArray noise, uvec2 pixel, uint frame, uint index)\n{\n$PLACE"
    "    vec4 stored = texelFetch(noise, ivec3(place, frame % $NAME_slices), 0);\n"
    "    return $DECODED;\n}\n",
    place_glsl,
    "float",
    "vec{}",
    0};
// The language promises room for no more than 2047 elements of an array that is written out.
constexpr Language wgsl = {
    "WGSL",
    "const $NAME_width = $Wu;\nconst $NAME_height = $Hu;\nconst $NAME_slices = $Zu;\n",
    "var<private> $NAME_numbers: array<$WORD, $N> = array<$WORD, $N>(\n",
    ");\n",
    "fn $NAME_unit(place: u32) -> f32 {\n    return $UNIT;\n}\n",
    "fn $NAME_load(pixel: vec2<u32>, frame: u32, index: u32) -> $FLOATS {\n$PLACE"
    "    let first = ((frame % $NAME_slices * size.y + place.y) * size.x + place.x) * $Cu;\n"
    "    return $DECODED;\n}\n",
    "fn $NAME_load(noise: texture_2d_array<f32>, pixel: vec2<u32>, frame: u32, index: u32) -> $FLOATS {\n$PLACE"
    "    let stored = textureLoad(noise, vec2<i32>(place), i32(frame % $NAME_slices), 0);\n"
    "    return $DECODED;\n}\n",
    place_wgsl,
    "f32",
    "vec{}<f32>",
    2047};

// A float as all three languages take it: WGSL and GLSL want the point, and no letter behind.
std::string float_text(double value) {
  std::string text = fmt::format("{}", value);
  return text.find_first_of(".e") == std::string::npos ? text + ".0" : text;
}

class ShaderWriter : public ContainerWriter {
 public:
  ShaderWriter(OutputFiles& files, const Language& language) : files_(files), language_(language) {}

  void begin(const std::string& target, const ContainerJob& job) override {
    job_ = &job;
    bits_ = static_cast<int>(8 * bytes_per_number(job.slice.type));
    is_float_ = !is_integer(job.slice.type);
    with_numbers_ = job.layout == ExportLayout::array;
    const std::size_t bytes = job.slice.num_bytes() * static_cast<std::size_t>(job.num_slices);
    num_words_ = (bytes + 3) / 4;
    if (with_numbers_ && language_.most_numbers > 0 && num_words_ > language_.most_numbers)
      throw UserError(target,
                      fmt::format("{} numbers of 32 bits; {} has room for {}: export the numbers as ktx2 and the "
                                  "function that reads them with --layout function",
                                  num_words_, language_.name, language_.most_numbers));
    name_ = identifier_of(target);
    stream_ = files_.open(target);
    stream_->append(
        comment_lines(job.description + (with_numbers_ ? "" : "\nRead from a texture with a layer a slice.")));
    stream_->append(fill(language_.constants));
    if (with_numbers_) stream_->append("\n" + fill(language_.numbers_begin));
    written_ = 0;
    pending_.clear();
  }

  void slice(SliceIndex, std::span<const std::byte> bytes) override {
    if (!with_numbers_) return;
    pending_.insert(pending_.end(), bytes.begin(), bytes.end());
    append_words(pending_.size() / 4);
  }

  void end() override {
    if (with_numbers_) {
      pending_.resize((pending_.size() + 3) / 4 * 4);
      append_words(pending_.size() / 4);
      stream_->append(std::string(language_.numbers_end) + "\n");
      stream_->append("// The number that is stored at a place" + std::string(is_float_ ? "" : ", as 0 to 1") + ".\n");
      stream_->append(fill(language_.unit));
    }
    stream_->append(
        "\n// The value of a pixel in a frame. `index` counts the samples of a pixel within a frame, from 0: each is "
        "read at\n"
        "// an offset of the R2 sequence. When all slices have been used, the whole texture moves on.\n");
    stream_->append(fill(with_numbers_ ? language_.load_array : language_.load_texture));
    stream_->close();
  }

 private:
  void append_words(std::size_t count) {
    constexpr std::size_t words_a_line = 12;
    std::string text;
    for (std::size_t w = 0; w < count; ++w) {
      std::uint32_t word = 0;
      float number = 0;
      std::memcpy(&word, pending_.data() + 4 * w, sizeof word);
      std::memcpy(&number, &word, sizeof number);
      text += is_float_ ? float_text_of(number) : fmt::format("{}u", word);
      if (++written_ < num_words_) text += written_ % words_a_line == 0 ? ",\n" : ",";
    }
    if (written_ == num_words_) text += "\n";
    stream_->append(text);
    pending_.erase(pending_.begin(), pending_.begin() + static_cast<std::ptrdiff_t>(4 * count));
  }
  static std::string float_text_of(float number) {
    std::string text = fmt::format("{}", number);
    return text.find_first_of(".e") == std::string::npos ? text + ".0" : text;
  }

  // One number of an array, from the word that holds it.
  std::string unit_text() const {
    if (is_float_) return "$NAME_numbers[place]";
    const std::string levels = float_text(std::exp2(bits_));
    const std::string to_float = std::string(language_.scalar) + "($BITS)";
    const std::string word = bits_ == 32
                                 ? "$NAME_numbers[place]"
                                 : fmt::format("(($NAME_numbers[place / {0}u] >> ({1}u * (place % {0}u))) & {2}u)",
                                               32 / bits_, bits_, (1U << bits_) - 1);
    return filled("(" + to_float + " + 0.5) / " + levels, {{"$BITS", word}});
  }

  // All channels, from 0 to 1 or as the values themselves.
  std::string stored_text() const {
    const int channels = job_->slice.channels;
    if (with_numbers_) {
      std::string list;
      for (int c = 0; c < channels; ++c) list += fmt::format("{}$NAME_unit(first + {}u)", c == 0 ? "" : ", ", c);
      return channels == 1 ? list : vector_type() + "(" + list + ")";
    }
    const std::string letters = std::string("rgba").substr(0, static_cast<std::size_t>(channels));
    if (is_float_) return "stored." + letters;
    // A sampler gives b / (2^n - 1).
    return fmt::format("(stored.{} * {} + 0.5) / {}", letters, float_text(std::exp2(bits_) - 1),
                       float_text(std::exp2(bits_)));
  }

  std::string decoded_text() const {
    std::string text = stored_text();
    if (job_->range && *job_->range != ValueRange{})
      text = fmt::format("({}) * {} + {}", text, float_text(job_->range->hi - job_->range->lo),
                         float_text(job_->range->lo));
    return job_->directions ? "normalize(" + text + ")" : text;
  }

  std::string vector_type() const {
    const int channels = job_->slice.channels;
    return channels == 1 ? language_.scalar : fmt::format(fmt::runtime(language_.vector), channels);
  }

  std::string fill(const std::string& text) const {
    const std::string with_parts =
        filled(text, {{"$PLACE", language_.place}, {"$UNIT", unit_text()}, {"$DECODED", decoded_text()}});
    const bool is_wgsl = language_.most_numbers > 0;
    const std::string word = is_float_ ? language_.scalar : is_wgsl ? "u32" : "uint";
    return filled(with_parts, {{"$NAME", name_},
                               {"$FLOATS", vector_type()},
                               {"$WORD", word},
                               {"$W", std::to_string(job_->slice.width)},
                               {"$H", std::to_string(job_->slice.height)},
                               {"$Z", std::to_string(job_->num_slices)},
                               {"$C", std::to_string(job_->slice.channels)},
                               {"$N", std::to_string(num_words_)},
                               {"$SX", std::to_string(round_step(job_->slice.width))},
                               {"$SY", std::to_string(round_step(job_->slice.height))}});
  }

  OutputFiles& files_;
  const Language& language_;
  const ContainerJob* job_ = nullptr;
  std::unique_ptr<OutputStream> stream_;
  std::string name_;
  int bits_ = 8;
  bool is_float_ = false;
  bool with_numbers_ = true;
  std::size_t num_words_ = 0;
  std::size_t written_ = 0;
  std::vector<std::byte> pending_;  // bytes that make no whole word yet
};

}  // namespace

std::unique_ptr<ContainerWriter> make_hlsl_writer(OutputFiles& files) {
  return std::make_unique<ShaderWriter>(files, hlsl);
}
std::unique_ptr<ContainerWriter> make_glsl_writer(OutputFiles& files) {
  return std::make_unique<ShaderWriter>(files, glsl);
}
std::unique_ptr<ContainerWriter> make_wgsl_writer(OutputFiles& files) {
  return std::make_unique<ShaderWriter>(files, wgsl);
}

}  // namespace noiseloom
