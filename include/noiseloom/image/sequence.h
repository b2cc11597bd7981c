// Numbered files: `noise_0.png`, `noise_1.png`, ... found from a pattern, a folder or the first of them.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace noiseloom {

// True where the text stands for many files: it holds {}, {slice}, %d or %0Nd.
bool is_sequence_pattern(const std::string& path);

// The files of a pattern or a folder, by ascending number, which must run without gaps (from any start). In a folder,
// all images must belong to one sequence, or be a single file. Throws UserError saying what was found.
std::vector<std::string> find_sequence(const std::string& pattern_or_folder);

// The sequence that begins at a numbered file: it and those that follow it without a gap. Just the file itself when its
// name holds no number before the extension.
std::vector<std::string> sequence_from_first(const std::string& path);

// The name of slice `number` by a pattern: {slice} and {} give the number, {slice:03} and %03d pad it with zeros.
std::string fill_pattern(const std::string& pattern, std::int64_t number);

}  // namespace noiseloom
