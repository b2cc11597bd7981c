// Headerless numbers and the .json beside them, both anything: a byte chooses the config, one the type; then the length
// of the .json in two bytes, the .json, and the numbers.
#include "fuzz/fuzz_configs.h"
#include "fuzz/reader_fuzz.h"
#include "noiseloom/image/texture_file.h"

namespace noiseloom::fuzz::raw {

void try_input(const std::uint8_t* data, std::size_t size) {
  if (size < 4) return;
  const std::size_t length = std::min(size - 4, data[2] + 256 * static_cast<std::size_t>(data[3]));
  folder().write("a.json", text_of(data + 4, length));
  const std::string path = folder().write("a.raw", text_of(data + 4 + length, size - 4 - length));
  const char* const types[] = {"", "", "", "uint8x4", "uint16be", "float16", "float64x2"};
  TextureReading reading;
  reading.type = types[data[1] % 7];
  expect_reason([&] { load_texture(path, config_number(data[0]), reading); });
}

namespace {

std::string seed(int config, int type, const std::string& json, std::size_t bytes) {
  std::string input{static_cast<char>(config), static_cast<char>(type), static_cast<char>(json.size() % 256),
                    static_cast<char>(json.size() / 256)};
  input += json;
  for (std::size_t i = 0; i < bytes; ++i) input += static_cast<char>(i * 11 % 63);
  return input;
}

std::string description(const std::string& type, const std::string& shape, const std::string& range) {
  return "{\"type\": \"" + type + "\", \"shape\": " + shape + ", \"encoded\": true, \"range\": " + range +
         ", \"config\": \"[texture]\\nsize = { x = 4, y = 3, t = 2 }\\nsamples = \\\"vector2\\\"\\n[filter]\\ngroups = "
         "[ { "
         "axes = \\\"xy\\\", kernel = \\\"box\\\", size = 3 } ]\\n\"}";
}

}  // namespace

std::vector<std::string> seeds() {
  return {seed(4, 0, description("uint8", "[2, 3, 4, 2]", "[0, 1]"), 48),
          seed(4, 0, description("float32", "[2, 3, 4, 2]", "[-1, 1]"), 192),
          seed(1, 0, "{\"other\": [1, 2]}", 96),
          seed(0, 4, "", 24),
          seed(0, 0, "", 12),
          seed(2, 6, "", 1024)};
}

}  // namespace noiseloom::fuzz::raw
