#include "noiseloom/config/config.h"

#include <utility>

#include "config/run_settings.h"
#include "noiseloom/config/settings_file.h"

namespace noiseloom {
namespace {

RunConfig parsed(const settings::Source& source, const std::vector<std::string>& overrides, MissingFiles missing) {
  auto result = settings::parse<RunConfig>(settings::run_config_kind(), source, overrides, missing);
  result.value.written_paths = std::move(result.written_paths);
  return std::move(result.value);
}

}  // namespace

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
  for (const GroupSpec& group : config.problem.filter.groups) spec.groups.push_back({group.axes, group.kernel.sigma});
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
