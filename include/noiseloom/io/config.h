// Configs: TOML text to values and back. One table (src/io/settings.cpp) describes every setting: key, type, default,
// range, unit, sentence; the parser, --help, the documented default config and the stored text all come from it.
#pragma once

#include <string>
#include <vector>

#include "noiseloom/optimize/spec.h"
#include "noiseloom/problem/spec.h"

namespace noiseloom {

struct RunConfig {
  ProblemSpec problem;
  OptimizerSpec optimizer;
};

// Reads a config and applies overrides ("optimizer.stop.iterations=200"; the value is TOML, a bare word is taken as a
// string). Paths inside a config are relative to the config's folder. Throws UserError with every fault found;
// EnvironmentError if the file cannot be read for another reason than not existing.
RunConfig load_config(const std::string& path, const std::vector<std::string>& overrides);
// The same for text; `name` stands for the path in messages, `folder` is what relative paths are relative to.
RunConfig parse_config(const std::string& text, const std::string& name, const std::string& folder,
                       const std::vector<std::string>& overrides);

// The effective config: every setting that applies, in a fixed order, with full precision. parse_config(to_toml(c)) ==
// c.
std::string to_toml(const RunConfig& config);

// The keys whose values differ between two effective configs, one line each: `texture.seed: 1 in the file, 2 here`.
std::vector<std::string> config_differences(const std::string& stored, const std::string& current);

// The reference of all settings for --help and README.
std::string describe_settings();

}  // namespace noiseloom
