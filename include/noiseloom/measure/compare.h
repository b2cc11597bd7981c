// Textures side by side: R under the same filters, how blue they are, whether one holds the samples of another.
#pragma once

#include <string>
#include <vector>

#include "noiseloom/core/parallel.h"
#include "noiseloom/image/texture_file.h"
#include "noiseloom/measure/score_file.h"

namespace noiseloom {

struct ComparedTexture {
  std::string name;  // of the file; of several seeds, what their names share
  std::vector<std::string> files;
  // Of each row: a filter, or the power at low frequencies over a group of axes. Mean over the files, and the standard
  // error of the mean (0 for one file).
  std::vector<double> means;
  std::vector<double> errors;
};

struct Comparison {
  std::vector<std::string> rows;  // "R, gauss 1 over xy", "power below 0.05 over xy"
  std::vector<ComparedTexture> textures;
  // Of each texture after the first: how many slices hold the very samples of the first one's, in any order; none where
  // sizes differ.
  std::vector<std::string> permutations;
};

// A column for each of `columns`, whose textures are of several seeds. All are measured under the filters of the first
// texture and the usual ones; throws UserError where their axes or samples differ.
struct CompareColumn {
  std::string name;
  std::vector<TextureFile> textures;
  std::vector<std::string> files;
};
Comparison compare(const std::vector<CompareColumn>& columns, ThreadPool& pool);

// A table for a paper: "markdown", "latex" or "csv".
std::string comparison_table(const Comparison& comparison, const std::string& format);
std::string comparison_json(const Comparison& comparison);

}  // namespace noiseloom
