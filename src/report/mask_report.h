// The parts of a report that show how blue a texture is, and the point sets that a mask holds.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "noiseloom/core/extents.h"
#include "noiseloom/files/pixel_order.h"
#include "noiseloom/measure/quality.h"
#include "noiseloom/report/picture.h"
#include "noiseloom/report/plot.h"
#include "noiseloom/report/report.h"

namespace noiseloom {

// Power on a logarithmic scale against frequency, a line for each group, and the limit of low frequencies.
Plot low_frequency_plot(const SpectralQuality& quality);
ReportTable low_frequency_table(const SpectralQuality& quality);

// The densities that a report shows; those that give no point are left out.
std::vector<double> shown_densities(std::int64_t num_pixels);

// Pixels whose place is below `count` black, the others white. places: [y][x] of one slice.
Picture points_picture(const OrderPlace* places, const Extents& extents, std::int64_t count);

// Power of the black and white patterns at those densities over the rings of a slice, averaged over the slices in
// `places` ([slice][y][x]).
Plot points_plot(const std::vector<OrderPlace>& places, const Extents& extents, const std::vector<double>& densities);

}  // namespace noiseloom
