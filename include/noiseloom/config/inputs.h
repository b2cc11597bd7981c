// What a run is made from beside the text of its config: the files that the config names (lists of samples, tables of
// taps). They are read once, when the run begins, and kept in the run file (/inputs); a run that goes on and whoever
// measures its texture take them from there, whatever has become of the files.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "noiseloom/config/config.h"
#include "noiseloom/files/run_file.h"

namespace noiseloom {

// Reads the files that the config names and whose contents it does not hold yet. Throws UserError with the faults of
// all of them.
void read_inputs(RunConfig& config);

// What the config holds of its files, in the order of its keys, for the run file.
std::vector<RunFileInput> inputs_of(const RunConfig& config);

// How many bytes these take in a run file: of what the config holds, else of what the headers of its files say. Throws
// UserError as reading them does.
std::uint64_t inputs_bytes(const RunConfig& config);

// How many bytes of memory they take while a run lasts, on each node: the same, and the table of a density.
double inputs_memory(const RunConfig& config);

// Gives the config what a run file holds of the files that it names; a file is known by the name that the config
// spells. What the run file does not hold (another name; an older run file) is left as it is. Throws UserError, naming
// the run file's `path`, for contents of another type.
void take_inputs(RunConfig& config, const std::vector<RunFileInput>& inputs, const std::string& path);

// What the config holds of each file that it names, in the order of its keys; null where it holds nothing.
void for_each_input(RunConfig& config, const std::function<void(InputArrayPtr&)>& visit);

// What a user should know of a file's contents: a sentence, and what it is about, in a word or two.
struct InputNote {
  std::string subject;
  std::string text;
};

// Of taps that are negative, and of images that may hold sRGB codes. Tables that the config does not hold are read.
// Filters that sharpen have negative taps, so they are no fault; but far more often a table has them by mistake, and R
// would not show it.
std::vector<InputNote> notes_on_inputs(const RunConfig& config);

// Those files whose contents are not (or no longer) what the config holds of them, as the config spells them. A file
// that is not there or cannot be read is none of them.
std::vector<std::string> changed_inputs(const RunConfig& config);

}  // namespace noiseloom
