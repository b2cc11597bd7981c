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

// The config of a run file at `path`, with the contents of the files that it names as the run file holds them, so that
// these files need not be there (run files from before hold none). `overrides` are applied as those of load_config.
// Throws UserError where it cannot be read, or where /samples is not of the size and kind that it says.
RunConfig stored_config(const RunFileContent& content, const std::string& path,
                        const std::vector<std::string>& overrides = {});

}  // namespace noiseloom
