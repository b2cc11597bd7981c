// The coordinates of a point set as tables.
#pragma once

#include <string>

#include "noiseloom/files/output_files.h"
#include "noiseloom/files/pixel_order.h"
#include "noiseloom/image/export.h"

namespace noiseloom {

// Writes plan.points_csv and, where named, plan.points_npy (int64 [points][axes + 1]): a row for each point that lies
// in the plan's slices, in the order of the sequence; columns are the coordinates (x, y, slice axes) and the rank in
// the whole sequence. Returns how many points there are, in words. Throws as PixelOrder::first_pixels does.
std::string write_points(OutputFiles& files, const ExportPlan& plan, const Extents& extents, const PixelOrder& order);

}  // namespace noiseloom
