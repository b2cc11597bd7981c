// Numbered files: `noise_0.png`, `noise_1.png`, ... found from a pattern, a folder or the first of them.
//
// A pattern is a file name with one place for the number: {}, {slice}, {slice:03}, %d, %i, %u, %03d, or a row of # as
// long as the number is wide (####). When reading, * stands for any text, as in a shell. Only the last part of a path
// is looked at: a folder's name may hold any of these signs.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace noiseloom {

// Where the number stands in a pattern, and how wide it is written at least, zeros in front.
struct NumberPlace {
  std::size_t begin = 0;
  std::size_t size = 0;
  int width = 1;
};

// None where the name holds no place for a number. Throws UserError where it holds several, or a * together with one.
std::optional<NumberPlace> number_place(const std::string& pattern);

// True where the text stands for many files: it has a place for the number, or a *.
bool is_sequence_pattern(const std::string& path);

// The name of slice `number` by a pattern. Throws UserError for a * (it says nothing about how the number is written)
// and for several places; a text without any is returned as it is.
std::string fill_pattern(const std::string& pattern, std::int64_t number);

// The files of a pattern or a folder, by ascending number, which must run without gaps (from any start). In a folder,
// and of those that a * stands for, all images must belong to one sequence, or be a single file. Throws UserError
// saying what was found, and of files that are no images that are read here, why not.
std::vector<std::string> find_sequence(const std::string& pattern_or_folder);

// What the name of one numbered file suggests: that it and those that follow it without a gap belong together.
struct Sequence {
  std::string pattern;             // "noise_{}.png"
  std::vector<std::string> files;  // that file, and those that follow
  std::string gap;                 // "number 17 is missing, 18 to 31 are there"; empty where none follows the last one
};

// One for each run of digits in the name before the extension that has further files, the last run first. Just the file
// itself, with an empty pattern, when there is none.
std::vector<Sequence> sequences_from_first(const std::string& path);

// True where these are all files of one sequence, in its order.
bool is_one_sequence(const std::vector<std::string>& files);

}  // namespace noiseloom
