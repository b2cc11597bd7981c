// Several run files in one texture, channel by channel: two numbers for a lens in R and G, one for time in B.
#pragma once

#include <string>
#include <vector>

#include "noiseloom/files/file_ops.h"
#include "noiseloom/image/export.h"

namespace noiseloom {

// `packing`: "RG=lens,B=time,A=1": channels of the file, and what they hold: all channels of a run file, by its name
// without folder and ending; one of them, counted from 0 ("lens.1"); or a number from 0 to 1. The channels must be R,
// RG, RGB or RGBA. Sizes and slices of the run files must agree. Integers stand for the range of each one's own
// samples. What each channel holds goes into the file, as far as it has room for that.
//
// Throws UserError (nothing was written) or EnvironmentError (nothing is left behind).
ExportResult export_packed(const std::vector<std::string>& paths, const std::string& packing,
                           const ExportOptions& options, FileOps& ops);

}  // namespace noiseloom
