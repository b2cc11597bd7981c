// The config that a run file holds.
#pragma once

#include <string>
#include <vector>

#include "noiseloom/config/config.h"
#include "noiseloom/files/run_file.h"

namespace noiseloom {

// The folder that paths in a run file's config are relative to: that of the config, if it is still there, else the run
// file's.
std::string config_folder(const RunFileContent& content, const std::string& run_file);

// The config of a run file at `path`: what it describes is in the file, so files that it names need not be there.
// `overrides` are applied as those of load_config. Throws UserError where it cannot be read.
RunConfig stored_config(const RunFileContent& content, const std::string& path,
                        const std::vector<std::string>& overrides = {});

}  // namespace noiseloom
