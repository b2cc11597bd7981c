#include "noiseloom/config/config.h"

#include <algorithm>
#include <filesystem>
#include <system_error>
#include <utility>

#include "config/run_settings.h"
#include "noiseloom/config/settings_file.h"
#include "noiseloom/core/error.h"
#include "noiseloom/samples/sample_space.h"

namespace noiseloom {
namespace {

RunConfig parsed(const settings::Source& source, const std::vector<std::string>& overrides, MissingFiles missing) {
  auto result = settings::parse<RunConfig>(settings::run_config_kind(), source, overrides, missing);
  RunConfig& config = result.value;
  config.written_paths = std::move(result.written_paths);
  // That a list is not what its texture needs is said, with all that is wrong with it, by whoever reads it.
  const std::string& list = config.problem.samples.file;
  std::error_code absent;
  if (config.problem.samples.is_file() && std::filesystem::is_regular_file(list, absent)) {
    try {
      settle_method(config);
    } catch (const UserError&) {
    }
  }
  return std::move(config);
}

}  // namespace

void settle_method(RunConfig& config, int channels) {
  OptimizerSpec& optimizer = config.optimizer;
  if (optimizer.method != Method::automatic) return;
  const ProblemSpec& problem = config.problem;
  const bool constructs = scale_of(problem.samples, channels).has_value() &&
                          problem.value_kernel.kind == ValueKernelKind::distance && !config.start.is_given() &&
                          problem.stratify == Stratify::slice;
  const ConstructSpec defaults;
  const bool asks_for_construction =
      config.construct.sharpness != defaults.sharpness || config.construct.density != defaults.density;
  if (!constructs && problem.samples.is_file() && asks_for_construction) {
    throw UserError(
        problem.samples.file,
        "these samples are annealed by method = \"auto\", but optimizer.density and optimizer.sharpness are "
        "for construction alone");
  }
  optimizer.method = constructs ? Method::construct : Method::anneal;
  if (!constructs && optimizer.stop.is_none()) optimizer.stop = StopSpec{};
}

void settle_method(RunConfig& config) {
  if (config.optimizer.method != Method::automatic) return;
  const ProblemSpec& problem = config.problem;
  settle_method(config, num_channels(problem.samples, problem.extents.cells_per_slice(), problem.extents.num_slices()));
}

RunConfig parse_config(const std::string& text, const std::string& name, const std::string& folder,
                       const std::vector<std::string>& overrides, MissingFiles missing) {
  return parsed({.text = text, .name = name, .folder = folder}, overrides, missing);
}

RunConfig load_config(const std::string& path, const std::vector<std::string>& overrides, MissingFiles missing) {
  return parsed(settings::load_source(path, settings::run_config_kind().noun), overrides, missing);
}

std::string to_toml(const RunConfig& config) {
  return settings::to_toml(settings::run_config_kind(), config, config.written_paths);
}

VacSpec vac_spec(const RunConfig& config) {
  VacSpec spec;
  spec.extents = config.problem.extents;
  const std::vector<GroupSpec>& groups = config.problem.filter.groups;
  const auto [least, largest] = std::minmax_element(
      groups.begin(), groups.end(), [](const GroupSpec& a, const GroupSpec& b) { return a.weight < b.weight; });
  for (const GroupSpec& group : groups) {
    // Shares of three groups and of many more cannot be written as equal numbers that add up to 1.
    const bool equal = largest->weight - least->weight < 2e-6;
    spec.groups.push_back({group.axes, group.kernel.sigma, group.kernel.box_axes, group.kernel.box_size,
                           equal ? 1 : group.weight / largest->weight, group.kernel.tile_axes, group.kernel.tail,
                           group.kernel.tail_power > 0 ? group.kernel.tail_power : 1});
  }
  if (!config.order.bounded.empty()) {
    spec.toroidal.assign(static_cast<std::size_t>(spec.extents.num_axes()), true);
    for (const int axis : config.order.bounded) spec.toroidal[static_cast<std::size_t>(axis)] = false;
  }
  spec.density = config.order.density;
  spec.seed = config.problem.seed;
  return spec;
}

std::string describe_settings() { return settings::describe(settings::run_config_kind()); }

}  // namespace noiseloom
