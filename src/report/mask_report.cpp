#include "report/mask_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "noiseloom/core/decimal.h"
#include "noiseloom/report/number_text.h"
#include "report/report_writer.h"

namespace noiseloom {
namespace {

// White noise, and the limit of low frequencies from the lowest point of the lines upward.
void add_guides(Plot& plot) {
  double lowest = 1;
  for (const PlotLine& line : plot.lines)
    for (const double y : line.y)
      if (y > 0) lowest = std::min(lowest, y);
  plot.lines.push_back(white_noise_line());
  plot.lines.push_back({"", {low_frequency, low_frequency}, {lowest, 1}, PlotLine::Style::dashed});
}

std::string percent(double density) { return number_text(100 * density, 6) + " %"; }

}  // namespace

Plot low_frequency_plot(const SpectralQuality& quality) {
  Plot plot{"Power on a logarithmic scale", "frequency (cycles a pixel)", "power", true, {}};
  for (const GroupQuality& group : quality.groups)
    plot.lines.push_back(line_of(radial_average(group.spectrum), group.name, style_of_line(plot.lines.size())));
  add_guides(plot);
  return plot;
}

ReportTable low_frequency_table(const SpectralQuality& quality) {
  ReportTable table{{"axes", fmt::format("power below {}", low_frequency), "lowest", "2nd", "3rd"}, {}};
  for (const GroupQuality& group : quality.groups) {
    ReportTableRow row{{group.name}, "", false};
    row.cells.push_back(std::isfinite(group.low_frequency_power) ? number_text(group.low_frequency_power, 3)
                                                                 : "no frequency is that low");
    for (std::size_t k = 0; k < 3; ++k)
      row.cells.push_back(k < group.first_bins.size() ? number_text(group.first_bins[k], 3) : "");
    table.rows.push_back(std::move(row));
  }
  return table;
}

std::vector<double> shown_densities(std::int64_t num_pixels) {
  std::vector<double> densities;
  for (const double density : {0.02, 0.1, 0.25, 0.5})
    if (decimal_of(density).floor_of_times(num_pixels) > 0) densities.push_back(density);
  return densities;
}

Picture points_picture(const OrderPlace* places, const Extents& extents, std::int64_t count) {
  Picture picture{narrow<int>(extents.width()), narrow<int>(extents.height()), {}};
  picture.rgb.resize(static_cast<std::size_t>(extents.cells_per_slice()) * 3);
  for (std::size_t i = 0; i < picture.rgb.size(); ++i) picture.rgb[i] = places[i / 3] < OrderPlace(count) ? 0 : 255;
  return picture;
}

Plot points_plot(const std::vector<OrderPlace>& places, const Extents& extents, const std::vector<double>& densities) {
  const auto num_slices = static_cast<std::int64_t>(places.size()) / extents.cells_per_slice();
  Texture pattern = make_texture(Extents({extents.width(), extents.height(), num_slices}), 1);
  Plot plot{"Power of the point sets", "frequency (cycles a pixel)", "power", true, {}};
  for (const double density : densities) {
    const std::int64_t count = decimal_of(density).floor_of_times(extents.num_cells());
    for (std::size_t i = 0; i < places.size(); ++i) pattern.values[i] = places[i] < OrderPlace(count) ? 1.0F : 0.0F;
    plot.lines.push_back(line_of(radial_average(axes_spectrum(pattern, DistanceKind::absolute, {0, 1})),
                                 percent(density), style_of_line(plot.lines.size())));
  }
  add_guides(plot);
  return plot;
}

}  // namespace noiseloom
