#include "noiseloom/image/consumers.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cctype>
#include <filesystem>

#include "image/containers/source_text.h"
#include "noiseloom/image/naming.h"
#include "noiseloom/samples/space.h"

namespace noiseloom {
namespace {

const Consumer* find_consumer(const std::string& name) {
  const auto found =
      std::find_if(consumers().begin(), consumers().end(), [&](const Consumer& c) { return c.name == name; });
  return found == consumers().end() ? nullptr : &*found;
}

std::string list_of(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : ", ") + word;
  return text;
}

// The power of two that is nearest in ratio, the smaller of two that are.
std::int64_t nearest_power_of_two(std::int64_t size) {
  const auto below =
      static_cast<std::int64_t>(std::bit_floor(static_cast<std::uint64_t>(std::max<std::int64_t>(size, 1))));
  return size * size > 2 * below * below ? 2 * below : below;
}

struct Sizes {
  std::int64_t x, y, slices;
  friend bool operator==(const Sizes&, const Sizes&) = default;
};
std::string text_of(const Sizes& sizes) { return fmt::format("{} x {} x {}", sizes.x, sizes.y, sizes.slices); }

// The nearest sizes that the consumer takes.
Sizes nearest_sizes(const Consumer& consumer, Sizes sizes) {
  if (consumer.size[0] > 0) return {consumer.size[0], consumer.size[1], consumer.size[2]};
  if (consumer.square) sizes.x = sizes.y = std::min(sizes.x, sizes.y);
  if (consumer.powers_of_two) sizes = {nearest_power_of_two(sizes.x), nearest_power_of_two(sizes.y), sizes.slices};
  if (consumer.slices_power_of_two) sizes.slices = nearest_power_of_two(sizes.slices);
  while (consumer.most_rows > 0 && sizes.y * sizes.slices > consumer.most_rows && sizes.slices > 1)
    sizes.slices = (sizes.slices + 1) / 2;
  return sizes;
}

std::string size_rules(const Consumer& consumer) {
  if (consumer.size[0] > 0) return fmt::format("{} x {} x {}", consumer.size[0], consumer.size[1], consumer.size[2]);
  std::string text;
  if (consumer.square) text += "square slices, ";
  if (consumer.powers_of_two) text += consumer.slices_power_of_two ? "powers of two, " : "x, y powers of two, ";
  if (consumer.most_rows > 0) text += fmt::format("at most {} rows, ", consumer.most_rows);
  return text.empty() ? "any" : text.substr(0, text.size() - 2);
}

std::string type_name(const SampleSpec& samples, bool has_order) {
  if (samples.is_file()) return "file";
  const std::string name = space_traits(samples).nvidia_name;
  return has_order && name == "vec1" ? "scalar" : name;
}

std::string capitalised(std::string text) {
  if (!text.empty()) text[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(text[0])));
  return text;
}

std::string file_name(const Consumer& consumer, const ProblemSpec& problem, const std::string& stem, bool has_order) {
  const Extents& extents = problem.extents;
  const std::string type = type_name(problem.samples, has_order);
  const std::string scalar_or_type = type == "vec1" ? "scalar" : type;
  return filled(consumer.naming,
                {{"$TYPE", scalar_or_type},
                 {"$Type", capitalised(type == "scalar" ? "vec1" : type)},
                 {"$SIZE", fmt::format("{}x{}x{}", extents.width(), extents.height(), extents.num_slices())},
                 {"$STEM", stem}});
}

}  // namespace

const std::vector<Consumer>& consumers() {
  using Any = std::array<std::string, 4>;
  static const Any as_is = {"as-is", "as-is", "as-is", "as-is"};
  static const Any scalars = {"as-is", "", "", ""};
  static const Any rgba = {"RGBA", "RGBA", "RGBA", "RGBA"};
  static const std::array<std::int64_t, 3> cube = {128, 128, 64};
  // clang-format off
  static const std::vector<Consumer> rows = {
      {"unreal", "Unreal Engine: FastBlueNoise textures, slice z at row z y", "png", "strip", {"8"}, {"as-is", "as-is", "", ""},
       "FastBlueNoise_$TYPE_$SIZE.png", {}, true, true, true, 16384},
      {"unity", "Unity: slices for a Texture2DArray of R16 or RG32", "png", "slices", {"16", "8"}, as_is, "nvidia", {}},
      {"godot", "Godot 4: an atlas, and the .import that makes a Texture2DArray of it", "godot", "atlas", {"8"}, as_is, "$STEM.png", {}},
      {"bevy", "Bevy: stbn.ktx2 of the feature bluenoise_texture", "ktx2", "array", {"8"}, rgba, "stbn.ktx2", {}, false, true},
      {"three", "three.js: KTX2Loader gives a Data3DTexture; set repeat and nearest", "ktx2", "volume", {"8", "16f", "32f"}, as_is, "$STEM.ktx2", {}},
      {"rtxtf", "NVIDIA RTXTF: rng.hlsli", "png", "strip", {"8"}, {"", "as-is", "", ""}, "STBlueNoise_vec2_128x128x64.PNG", cube},
      {"remix", "dxvk-remix: a layer a slice, 8 bytes in each number", "remix", "array", {"8"}, scalars, "util_blueNoise_128x128x64.h", cube},
      {"nvidia", "what reads NVIDIA's published spatiotemporal blue noise", "png", "slices", {"8", "16"}, as_is, "nvidia", {}},
      {"ea", "what reads the published filter-adapted noise: one strip", "png", "strip", {"8"}, rgba, "ea", {}},
      {"gigi", "Gigi: the same, a file a slice", "png", "slices", {"8"}, rgba, "ea", {}},
      {"mpv", "mpv, libplacebo: a TEXTURE block of a user shader", "mpv", "array", {"8", "16", "16f", "32f"}, {"R", "RG", "RGBA", "RGBA"}, "$STEM.glsl", {}},
      {"imagemagick", "ImageMagick: thresholds.xml, a map a slice for -ordered-dither", "imagemagick", "array", {"32"}, scalars, "thresholds.xml", {}},
      {"ghostscript", "Ghostscript, CUPS: a screen a slice (HalftoneType 16)", "ghostscript", "slices", {"32"}, scalars, "plain", {}},
      {"gimp", "GIMP: a dither matrix a slice, in Script-Fu", "gimp", "slices", {"32"}, scalars, "plain", {}},
      {"pbrt", "pbrt-v4: util/bluenoise.cpp, [texture][x][y], code / 65535", "pbrt", "array", {"16"}, scalars, "bluenoise.cpp", {128, 128, 48}},
      {"iris", "Minecraft packs by Iris: a raw 3D texture", "raw", "array", {"8"}, {"as-is", "as-is", "as-is", ""}, "stbn$TypeTex.bin", cube},
      {"skyrim-cs", "Skyrim Community Shaders: L8A8", "dds", "strip", {"8"}, {"", "as-is", "", ""}, "$STEM.dds", cube},
  };
  // clang-format on
  return rows;
}

std::string consumers_table() {
  std::size_t width = 0;
  for (const Consumer& c : consumers()) width = std::max(width, size_rules(c).size());
  const auto line = [width](const std::string& name, const std::string& format, const std::string& layout,
                            const std::string& depth, const std::string& sizes, const std::string& reader) {
    return fmt::format("{:<12} {:<12} {:<8} {:<16} {:<{}} {}\n", name, format, layout, depth, sizes, width, reader);
  };
  std::string text = line("--for", "format", "layout", "depth", "sizes", "for");
  for (const Consumer& c : consumers())
    text += line(c.name, c.format, c.layout, list_of(c.depths), size_rules(c), c.reader);
  return text + "\nThe first depth is taken where --depth names none.\n";
}

ExportOptions for_consumer(ExportOptions options, const ProblemSpec& problem, int channels, const std::string& stem,
                           bool has_order, std::vector<Fault>& faults) {
  const auto fault = [&faults](const std::string& text) { faults.push_back({"command line", text}); };
  const Consumer* const consumer = find_consumer(options.consumer);
  if (consumer == nullptr) {
    std::vector<std::string> names;
    for (const Consumer& c : consumers()) names.push_back(c.name);
    const std::string nearest = nearest_word(options.consumer, names);
    fault(fmt::format("--for {}: unknown{}; accepted: {} (--for help: a table)", options.consumer,
                      nearest.empty() ? "" : fmt::format("; did you mean \"{}\"?", nearest), list_of(names)));
    return options;
  }
  for (const auto& [option, value] : {std::pair("--format", options.format), std::pair("--layout", options.layout),
                                      std::pair("--channels", options.channels), std::pair("--naming", options.naming),
                                      std::pair("--pdf", options.density), std::pair("--threshold", options.threshold)})
    if (!value.empty())
      fault(fmt::format("{} {}: --for {} decides that; leave one out", option, value, consumer->name));
  if (!options.depth.empty() &&
      std::find(consumer->depths.begin(), consumer->depths.end(), options.depth) == consumer->depths.end())
    fault(fmt::format("--depth {}: {} reads it not; accepted: {}", options.depth, consumer->name,
                      list_of(consumer->depths)));

  const bool taken = channels <= 4 && !consumer->channels[static_cast<std::size_t>(channels - 1)].empty();
  if (!taken) {
    std::string accepted;
    for (std::size_t c = 0; c < 4; ++c)
      if (!consumer->channels[c].empty()) accepted += fmt::format("{}{}", accepted.empty() ? "" : ", ", c + 1);
    fault(fmt::format("--for {}: samples \"{}\" have {} channel{}; accepted: {}", consumer->name, problem.samples.space,
                      channels, channels == 1 ? "" : "s", accepted));
  }
  const Sizes sizes = {problem.extents.width(), problem.extents.height(), problem.extents.num_slices()};
  const Sizes nearest = nearest_sizes(*consumer, sizes);
  if (nearest != sizes)
    fault(fmt::format("--for {}: {} is {}; accepted: {}; the nearest that works: {}", consumer->name, stem,
                      text_of(sizes), size_rules(*consumer), text_of(nearest)));
  if (!options.slices.empty() && consumer->size[0] > 0)
    fault(fmt::format("--slices {}: --for {} takes all slices", options.slices, consumer->name));

  options.format = consumer->format;
  options.layout = consumer->layout;
  if (options.depth.empty()) options.depth = consumer->depths.front();
  if (taken && consumer->channels[static_cast<std::size_t>(channels - 1)] != "as-is")
    options.channels = consumer->channels[static_cast<std::size_t>(channels - 1)];
  const std::filesystem::path output(options.output);
  const bool is_folder =
      options.output.ends_with("/") || std::filesystem::is_directory(output) || output.extension().empty();
  if (!is_folder || options.output == "-") return options;
  if (consumer->naming == "nvidia" || consumer->naming == "ea")
    options.naming = consumer->naming;
  else if (consumer->naming != "plain")
    options.output = (output / file_name(*consumer, problem, stem, has_order)).string();
  return options;
}

}  // namespace noiseloom
