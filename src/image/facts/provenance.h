// Where the numbers of an exported file come from, as pairs of a key and a text that the file carries along.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "noiseloom/config/config.h"
#include "noiseloom/files/run_file.h"
#include "noiseloom/image/container.h"

namespace noiseloom {

using Facts = std::vector<std::pair<std::string, std::string>>;

// samples, seed, filter, relative_error (where it is known), checksum of /samples, config.
Facts facts_of(const RunFileContent& content, const RunConfig& config);

// How an image or texture is to be read: "layout", as --layout takes it, "slices", those in this file as A:B, and
// "range", as --range takes it ("values": the samples themselves). For files whose numbers are samples.
Facts reading_facts(const ContainerJob& job);

// What a file says of itself by such facts, where it says enough: the config of its run, with a slice axis as long as
// the file has slices, and how to read it.
struct OwnFacts {
  RunConfig config;
  std::string layout;
  std::optional<ValueRange> range;  // none: the samples themselves
};
// Throws UserError, naming `name`, where the facts are there but make no sense.
std::optional<OwnFacts> own_facts(const Facts& facts, const std::string& name,
                                  const std::vector<std::string>& overrides);

// All but the config, on one line: "samples vector2; seed 1; ...".
std::string facts_line(const Facts& facts);

}  // namespace noiseloom
