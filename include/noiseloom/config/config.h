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

enum class StartPattern { none, lattice };

// The arrangement that a run begins with.
struct StartSpec {
  std::string file;  // a run file or a .npy
  StartPattern pattern = StartPattern::none;
  bool is_given() const { return !file.empty() || pattern != StartPattern::none; }
};

// File names in `problem` can be opened as they are: the config's folder is part of them.
struct RunConfig {
  ProblemSpec problem;
  OptimizerSpec optimizer = {.method = Method::automatic};
  OrderSpec order;          // of void and cluster
  ConstructSpec construct;  // of construct
  StartSpec start;          // of anneal
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

// Puts the method that `auto` stands for in its place: construct for scalars that are compared by their difference and
// begin with no arrangement of their own, else anneal; with what follows from it where there is no stop rule. Of a list
// of samples, `channels` says how many it has. Leaves every other method alone.
void settle_method(RunConfig& config, int channels);
// The same where the list is at hand, or its file is. Reads its header; throws UserError as reading it would.
void settle_method(RunConfig& config);

// The problem of a config whose method is void-and-cluster.
VacSpec vac_spec(const RunConfig& config);

// The reference of all settings for --help and README.
std::string describe_settings();

}  // namespace noiseloom
