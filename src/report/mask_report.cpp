#include "report/mask_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace noiseloom {
namespace {

constexpr PlotLine::Style line_styles[] = {PlotLine::Style::main, PlotLine::Style::second, PlotLine::Style::third,
                                           PlotLine::Style::fourth, PlotLine::Style::fifth};

PlotLine::Style style_of(std::size_t line) { return line_styles[line % std::size(line_styles)]; }

PlotLine line_of(const std::vector<SpectrumBin>& bins, const std::string& label, PlotLine::Style style) {
  PlotLine line{label, {}, {}, style};
  for (const SpectrumBin& bin : bins) {
    line.x.push_back(bin.frequency);
    line.y.push_back(bin.power);
  }
  return line;
}

// White noise, and the limit of low frequencies from the lowest point of the lines upward.
void add_guides(Plot& plot) {
  double lowest = 1;
  for (const PlotLine& line : plot.lines)
    for (const double y : line.y)
      if (y > 0) lowest = std::min(lowest, y);
  plot.lines.push_back({"white noise", {0, 0.5}, {1, 1}, PlotLine::Style::dashed});
  plot.lines.push_back({"", {low_frequency, low_frequency}, {lowest, 1}, PlotLine::Style::dashed});
}

std::string percent(double density) { return fmt::format("{:g} %", 100 * density); }

}  // namespace

std::int64_t num_points(double density, std::int64_t num_pixels) {
  return static_cast<std::int64_t>(density * static_cast<double>(num_pixels));
}

Plot low_frequency_plot(const SpectralQuality& quality) {
  Plot plot{"Power on a logarithmic scale", "frequency (cycles a pixel)", "power", true, {}};
  for (const GroupQuality& group : quality.groups)
    plot.lines.push_back(line_of(radial_average(group.spectrum), group.name, style_of(plot.lines.size())));
  add_guides(plot);
  return plot;
}

ReportTable low_frequency_table(const SpectralQuality& quality) {
  ReportTable table{{"axes", fmt::format("power below {}", low_frequency), "lowest", "2nd", "3rd"}, {}};
  for (const GroupQuality& group : quality.groups) {
    ReportTableRow row{{group.name}, "", false};
    row.cells.push_back(std::isfinite(group.low_frequency_power) ? fmt::format("{:.3g}", group.low_frequency_power)
                                                                 : "no frequency is that low");
    for (std::size_t k = 0; k < 3; ++k)
      row.cells.push_back(k < group.first_bins.size() ? fmt::format("{:.3g}", group.first_bins[k]) : "");
    table.rows.push_back(std::move(row));
  }
  return table;
}

std::vector<double> shown_densities(std::int64_t num_pixels) {
  std::vector<double> densities;
  for (const double density : {0.02, 0.1, 0.25, 0.5})
    if (num_points(density, num_pixels) > 0) densities.push_back(density);
  return densities;
}

Picture points_picture(const std::uint64_t* ranks, const Extents& extents, std::int64_t count) {
  Picture picture{narrow<int>(extents.width()), narrow<int>(extents.height()), {}};
  picture.rgb.resize(static_cast<std::size_t>(extents.cells_per_slice()) * 3);
  for (std::size_t i = 0; i < picture.rgb.size(); ++i)
    picture.rgb[i] = static_cast<std::int64_t>(ranks[i / 3]) < count ? 0 : 255;
  return picture;
}

Plot points_plot(const std::vector<std::uint64_t>& ranks, const Extents& extents,
                 const std::vector<double>& densities) {
  const auto num_slices = static_cast<std::int64_t>(ranks.size()) / extents.cells_per_slice();
  Texture pattern = make_texture(Extents({extents.width(), extents.height(), num_slices}), 1);
  Plot plot{"Power of the point sets", "frequency (cycles a pixel)", "power", true, {}};
  for (const double density : densities) {
    const std::int64_t count = num_points(density, extents.num_cells());
    for (std::size_t i = 0; i < ranks.size(); ++i)
      pattern.values[i] = static_cast<std::int64_t>(ranks[i]) < count ? 1.0F : 0.0F;
    plot.lines.push_back(line_of(radial_average(axes_spectrum(pattern, DistanceKind::absolute, {0, 1})),
                                 percent(density), style_of(plot.lines.size())));
  }
  add_guides(plot);
  return plot;
}

}  // namespace noiseloom
