// The arguments that commands on textures share.
#include <fmt/format.h>

#include "noiseloom/config/stored_config.h"
#include "noiseloom/core/error.h"
#include "noiseloom/core/parallel.h"
#include "noiseloom/files/run_file.h"
#include "noiseloom_study.h"

namespace noiseloom {
namespace {

constexpr const char* file_help =
    "Run file; image, first of numbered images, folder of them, or pattern (noise_{}.png); .npy; .raw";

}  // namespace

void add_texture_arguments(CLI::App& command, TextureArguments& arguments) {
  command.add_option("FILE", arguments.file, file_help)->required();
  command.add_option(
      "--config", arguments.config,
      "What the values mean: size, samples and filter. For a run file, only the filter is taken from it");
  command
      .add_option("--set", arguments.overrides,
                  "Change a key of the config (or of the run file's own): filter.groups[0].size=3")
      ->allow_extra_args(false);
  command.add_option("--threads", arguments.threads, "Threads; all processors if not given")
      ->check(CLI::PositiveNumber);
}

std::optional<RunConfig> config_of(const TextureArguments& arguments) {
  if (!arguments.config.empty()) return load_config(arguments.config, arguments.overrides);
  if (arguments.overrides.empty()) return std::nullopt;
  if (!looks_like_run_file(arguments.file))
    throw UserError("command line", "--set changes a config: give one with --config");
  const RunFileReader reader(arguments.file);
  return stored_config(reader.content(), arguments.file, arguments.overrides);
}

int threads_of(const TextureArguments& arguments) {
  return arguments.threads > 0 ? arguments.threads : num_available_processors();
}

}  // namespace noiseloom
