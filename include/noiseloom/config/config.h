// The config of a run: TOML text to values and back. One table (src/config/run_settings_table.cpp) describes every
// setting: key, type, default, range, unit, sentence; the reader, --help and the stored text all come from it.
#pragma once

#include <string>
#include <vector>

#include "noiseloom/anneal/spec.h"
#include "noiseloom/config/file_names.h"
#include "noiseloom/construct/spec.h"
#include "noiseloom/core/text.h"
#include "noiseloom/problem/spec.h"

namespace noiseloom {

// File names in `problem` can be opened as they are: the config's folder is part of them.
struct RunConfig {
  ProblemSpec problem;
  OptimizerSpec optimizer;
  OrderSpec order;          // of void and cluster
  ConstructSpec construct;  // of construct
  WrittenPaths written_paths;
};

// Reads a config and applies overrides ("optimizer.stop.iterations=200", "filter.groups[0].size=3"; the value is TOML,
// a bare word is taken as a string; a stop rule replaces that of the file). Paths inside a config are relative to the
// config's folder. Throws UserError with every fault found; EnvironmentError if the file cannot be read for another
// reason than not existing.
RunConfig load_config(const std::string& path, const std::vector<std::string>& overrides,
                      MissingFiles missing = MissingFiles::refused);
// The same for text; `name` stands for the path in messages, `folder` is what relative paths are relative to ("" for
// the working directory).
RunConfig parse_config(const std::string& text, const std::string& name, const std::string& folder,
                       const std::vector<std::string>& overrides, MissingFiles missing = MissingFiles::refused);

// The effective config: every setting that applies, in a fixed order, with full precision. parse_config(to_toml(c)) ==
// c.
std::string to_toml(const RunConfig& config);

// The keys whose values differ between two effective configs, one line each: `texture.seed: 1 in the file, 2 here`.
// Throws UserError if `stored` is not TOML.
std::vector<std::string> config_differences(const std::string& stored, const std::string& current);

// The problem of a config whose method is void-and-cluster.
VacSpec vac_spec(const RunConfig& config);

// The reference of all settings for --help and README.
std::string describe_settings();

}  // namespace noiseloom
