// The arguments that commands on textures share.
#include <fmt/format.h>

#include <filesystem>

#include "noiseloom/config/stored_config.h"
#include "noiseloom/core/error.h"
#include "noiseloom/core/parallel.h"
#include "noiseloom/files/generations.h"
#include "noiseloom/files/run_file.h"
#include "noiseloom/image/image_reader.h"
#include "noiseloom/samples/sample_space.h"
#include "noiseloom_study.h"

namespace noiseloom {
namespace {

constexpr const char* file_help =
    "Run file; image, first of numbered images, folder of them, or pattern (noise_{}.png, %d, ####, *); .npy; .raw;\n"
    "FILE.h5:/DATASET of any HDF5 file";

// Those that set `key` or something below it.
std::vector<std::string> overrides_of(const std::string& key, const std::vector<std::string>& overrides) {
  std::vector<std::string> found;
  for (const std::string& text : overrides)
    if (text.starts_with(key) && text.find_first_of(" =.[", key.size()) == key.size()) found.push_back(text);
  return found;
}

// A config of this size that leaves the rest to `overrides`; the filter is gauss 1.0 unless they choose its kernel.
RunConfig config_around(const Extents& extents, const std::vector<std::string>& overrides) {
  std::string size;
  for (int axis = 0; axis < extents.num_axes(); ++axis)
    size += fmt::format("{}{} = {}", axis == 0 ? "" : ", ", extents.name(axis), extents.size(axis));
  const bool has_kernel = !overrides_of("filter.groups[0].kernel", overrides).empty();
  return parse_config(fmt::format("[texture]\nsize = {{ {} }}\nsamples = \"uniform\"\n[filter]\ngroups = [ {{ axes = "
                                  "\"xy\"{} }} ]\n",
                                  size, has_kernel ? "" : ", kernel = \"gauss\", sigma = 1.0"),
                      "what --set leaves open", "", overrides);
}

RunConfig config_from_set(const TextureArguments& arguments, const std::string& file) {
  const std::vector<std::string>& overrides = arguments.overrides;
  const std::vector<std::string> samples = overrides_of("texture.samples", overrides);
  if (samples.empty())
    throw UserError("command line",
                    "--set without --config must say what the values are: --set texture.samples=uniform "
                    "(or vector2, sphere, ...)");
  if (!overrides_of("texture.size", overrides).empty()) return config_around(Extents({1, 1}), overrides);
  const RunConfig meaning = config_around(Extents({1, 1}), samples);
  const bool from_list = meaning.problem.samples.is_file();
  return config_around(
      suggested_extents(file, from_list ? 0 : num_channels(meaning.problem.samples), arguments.reading), overrides);
}

bool is_of_images(const std::string& file) { return has_image_extension(file) || std::filesystem::is_directory(file); }

}  // namespace

void add_texture_arguments(CLI::App& command, TextureArguments& arguments) {
  command.add_option("FILE", arguments.files, file_help)->required();
  command.add_option("--config", arguments.config,
                     "What the values mean: size, samples and filter. Of a run file, which knows the rest, the filter\n"
                     "alone is taken, its axes by their names. PNG, EXR, TIFF and KTX2 of our own need none");
  command
      .add_option(
          "--set", arguments.overrides,
          "Change a key of the config (or of the run file's own): filter.groups[0].size=3. Alone, it says what\n"
          "the values of another file are: texture.samples=sphere; the size is then the file's")
      ->allow_extra_args(false);
  command.add_option(
      "--type", arguments.reading.type,
      "Headerless numbers: uint8, uint16, float16, float32, float64, \"be\" behind it for big-endian, xN "
      "for N\nnumbers a pixel: uint16be, uint8x4");
  command.add_option("--channels", arguments.reading.channels,
                     "Which channels of the file hold the samples: RG, A, or numbers from 0: 0,2");
  command.add_option(
      "--layout", arguments.reading.layout,
      "Slices in one image: image (one slice), strip (downward), row (to the right), atlas:CxR (C columns,\n"
      "R rows; left to right, then down), atlas-down:CxR; found from the size where it can be");
  command.add_option("--axes", arguments.reading.axes,
                     "Dimensions of an array, slowest first, a letter each (c: channel) or names: tyx, yxtc, "
                     "time,y,x,channel");
  command.add_option("--threads", arguments.threads, "Threads; all processors if not given")
      ->check(CLI::PositiveNumber);
}

std::optional<RunConfig> config_of(const TextureArguments& arguments, const std::string& file) {
  if (!arguments.config.empty()) return load_config(arguments.config, arguments.overrides);
  if (arguments.overrides.empty()) return std::nullopt;
  if (!looks_like_run_file(file)) {
    // What the file says of its run is changed by --set, unless that says what the values are.
    if (is_of_images(file) && overrides_of("texture.samples", arguments.overrides).empty())
      if (std::optional<RunConfig> own = config_in_images(file, arguments.overrides)) return own;
    return config_from_set(arguments, file);
  }
  const RunFileReader reader = open_to_look_at(file);
  return stored_config(reader.content(), file, arguments.overrides);
}

TextureFile load_argument(const TextureArguments& arguments, const std::string& file) {
  return load_texture(file, config_of(arguments, file), arguments.reading);
}

int threads_of(const TextureArguments& arguments) {
  return arguments.threads > 0 ? arguments.threads : num_available_processors();
}

}  // namespace noiseloom
