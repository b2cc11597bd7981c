// Where the numbers of an exported file come from, as pairs of a key and a text that the file carries along.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "noiseloom/config/config.h"
#include "noiseloom/files/run_file.h"

namespace noiseloom {

using Facts = std::vector<std::pair<std::string, std::string>>;

// samples, seed, filter, relative_error (where it is known), checksum of /samples, config.
Facts facts_of(const RunFileContent& content, const RunConfig& config);

// All but the config, on one line: "samples vector2; seed 1; ...".
std::string facts_line(const Facts& facts);

}  // namespace noiseloom
