#include "report/error_spectra.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "noiseloom/core/quantity_text.h"

namespace noiseloom {
namespace {

PlaneSpectrum scaled(PlaneSpectrum spectrum, double factor) {
  for (double& power : spectrum.power) power *= factor;
  return spectrum;
}

double sum_of(const std::array<double, 3>& powers) { return powers[0] + powers[1] + powers[2]; }

// A row for each noise: the error in each band, over the picture and over time.
ReportTable table_of_bands(const render::Result& result, std::size_t effect, std::size_t time) {
  ReportTable table{{"error at frequencies", "below 0.05 c/px", "0.05 to 0.15", "above", "below 0.05 c/frame",
                     "0.05 to 0.15", "above"},
                    {}};
  for (std::size_t noise = 0; noise < result.noises.size(); ++noise) {
    const render::ErrorSpectrum& one = result.spectrum(effect, noise, time);
    ReportTableRow row{{result.noises[noise]}, ""};
    for (const auto& powers : {one.bands, one.in_time})
      for (const double power : powers) row.cells.push_back(digits_text(std::sqrt(power)));
    table.rows.push_back(row);
  }
  return table;
}

}  // namespace

void add_error_spectra(const render::Result& result, std::size_t effect, ReportWriter& writer) {
  const std::string name = render::name_of(result.effects[effect]);
  const std::size_t spaces = result.stages.size() / result.num_times();
  for (std::size_t time = 0; time < result.num_times(); ++time) {
    double largest = 0;
    for (std::size_t noise = 0; noise < result.noises.size(); ++noise)
      largest = std::max(largest, sum_of(result.spectrum(effect, noise, time).bands));
    if (!(largest > 0)) continue;
    const std::string& after = result.stages[time * spaces].time;
    ReportSection section{
        fmt::format("{}: frequencies of the error, {}", name, time == 0 ? "each frame alone" : "after " + after),
        fmt::format("Over the picture (x and y) and over time (x and frames), {}. One scale for all noises: light grey "
                    "is the power of white noise with the largest mean square among them. A filter over space removes "
                    "what lies far from the middle to all sides, one over time what lies far above and below it.",
                    time == 0 ? "of all frames" : "of the later half of the frames"),
        {},
        {}};
    for (std::size_t noise = 0; noise < result.noises.size(); ++noise) {
      const render::ErrorSpectrum& one = result.spectrum(effect, noise, time);
      if (one.is_empty()) continue;
      const std::string& of = result.noises[noise];
      const auto file = [&](const char* plane) { return fmt::format("page/{}_{}_{}_{}.png", name, after, of, plane); };
      section.figures.push_back(writer.spectrum_figure(file("xy"), scaled(one.across, 1 / largest),
                                                       {of + " over x and y", "x", "y"}, of + ", over the picture"));
      section.figures.push_back(writer.spectrum_figure(file("xt"), scaled(one.over_time, 1 / largest),
                                                       {of + " over x and time", "x", "frames"}, of + ", over time"));
    }
    section.tables.push_back(table_of_bands(result, effect, time));
    writer.report.sections.push_back(section);
  }
}

}  // namespace noiseloom
