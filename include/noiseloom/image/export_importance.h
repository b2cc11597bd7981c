// Adaptive sampling: which pixels of which frame a scalar mask samples under an importance map, and how many have been
// sampled so far ([STBN22s], 4.4).
//
// A pixel is sampled in a frame if its importance is above the mask's value there. A mask that is blue over time
// samples other pixels in each frame, so that fewer are sampled twice while others wait.
#pragma once

#include <string>
#include <vector>

#include "noiseloom/files/file_ops.h"

namespace noiseloom {

struct ImportanceOptions {
  std::string map;     // an image or .npy of importance, 0 to 1; the mask tiles it
  std::string output;  // a folder
  std::string frames;  // how many; else as many as the mask has slices
  bool overwrite = false;
};

// Shares of all pixels, after each frame.
struct Coverage {
  double now = 0;           // sampled in this frame
  double so_far = 0;        // sampled at least once
  double white = 0;         // the same for white noise
  double slices_alone = 0;  // and for the mask's own slices, each shifted at random: blue each, unrelated to each other
};

struct ImportanceResult {
  std::vector<std::string> images;  // sampled_0.png, ...: white where a pixel is sampled
  std::string table;                // coverage.csv: a row a frame
  std::vector<Coverage> coverage;
};

// Reads the map through decode_image() or as .npy. Throws UserError (nothing was written) for a run file whose samples
// are no scalars that are uniform in [0, 1), and for a map that is none; EnvironmentError (nothing is left behind).
ImportanceResult export_importance(const std::string& path, const ImportanceOptions& options, FileOps& ops);

}  // namespace noiseloom
