#include "report/spectrum_sections.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "noiseloom/measure/autocorrelation.h"
#include "noiseloom/problem/footprint.h"
#include "noiseloom/report/number_text.h"
#include "report/mask_report.h"

namespace noiseloom {
namespace {

constexpr const char* power_label = "power, white noise = 1";

class Sections {
 public:
  Sections(ReportWriter& writer, const SpectrumSource& source)
      : writer_(writer), source_(source), extents_(source.texture.extents) {}

  void add_all() {
    add_slice();
    for (int axis = 2; axis < extents_.num_axes(); ++axis)
      if (extents_.size(axis) > 1) add_slice_axis(axis);
    for (const GroupQuality& group : source_.quality.groups)
      if (group.axes.size() > 1 && group.axes != std::vector<int>{0, 1} && !is_x_with_slice_axis(group))
        add_group(group);
    add_low_frequencies();
  }

 private:
  void add(ReportSection section) { writer_.report.sections.push_back(std::move(section)); }

  const GroupQuality* group_over(const std::vector<int>& axes) const {
    for (const GroupQuality& group : source_.quality.groups)
      if (group.axes == axes) return &group;
    return nullptr;
  }
  static bool is_x_with_slice_axis(const GroupQuality& group) {
    return group.axes.size() == 2 && group.axes[0] == 0 && group.axes[1] >= 2;
  }

  static std::string along(const std::string& axis) { return fmt::format("frequency along {} (cycles a pixel)", axis); }

  static Plot power_plot(const std::string& title, const std::string& x_label, const std::vector<SpectrumBin>& bins) {
    return {
        title, x_label, power_label, false, {line_of(bins, "this texture", PlotLine::Style::main), white_noise_line()}};
  }

  void add_slice() {
    const GroupQuality* const group = group_over({0, 1});
    const PlaneSpectrum spectrum =
        group != nullptr ? centred(group->spectrum) : plane_spectrum(source_.texture, source_.kind, 0, 1);
    const std::vector<SpectrumBin> rings = radial_average(spectrum);
    writer_.write_csv("spectrum_xy.csv", rings);
    Plot plot = power_plot("Power over the frequencies of a slice", "frequency (cycles a pixel)", rings);
    std::string text = "A blur removes high frequencies; power at low ones stays in the image as error.";
    if (source_.filter != nullptr) {
      const Footprint footprint(extents_, *source_.filter);
      plot.lines.push_back(
          line_of(radial_average(filter_response(footprint)), "filter lets through", PlotLine::Style::second));
      text = "Where the filter lets much through, power should be low: that error stays in the image.";
    }
    const std::string svg = plot_svg(plot);
    writer_.write("spectrum_xy.svg", svg);
    const ReportFigure picture =
        writer_.spectrum_figure("spectrum_xy.png", spectrum, {"Spectrum of a slice", along("x"), along("y")},
                                "Mean over slices and channels. Black: none; light grey: as white noise; white: twice "
                                "that or more.");
    add({"Spectrum of a slice", text, {picture, {svg, "The same, averaged over rings."}}});
    add_autocorrelation(spectrum);
  }

  // How far apart the reads of a pixel must lie to be as from textures of their own.
  void add_autocorrelation(const PlaneSpectrum& spectrum) {
    const Autocorrelation correlation = autocorrelation_of(spectrum, extents_.num_slices());
    const std::vector<CorrelationRing> rings = correlation_rings(correlation);
    if (rings.empty()) return;
    std::string csv = "distance,mean,largest_magnitude\n";
    PlotLine mean{"mean over the ring", {}, {}, PlotLine::Style::main};
    PlotLine largest{"largest, whatever its sign", {}, {}, PlotLine::Style::second};
    constexpr int most_shown = 32;
    for (const CorrelationRing& ring : rings) {
      csv += fmt::format("{},{},{}\n", ring.distance, ring.mean, ring.largest);
      if (ring.distance > most_shown) continue;
      for (const auto& [line, value] : {std::pair(&mean, ring.mean), std::pair(&largest, ring.largest)}) {
        line->x.push_back(ring.distance);
        line->y.push_back(value);
      }
    }
    writer_.write("autocorrelation.csv", csv);
    const int from = uncorrelated_from(rings, correlation.chance);
    const std::string text =
        from <= rings.back().distance
            ? fmt::format(
                  "Reads that lie {} pixel{} apart or more are uncorrelated: no offset from there on has a "
                  "correlation above {}. So far apart, one texture serves as several.",
                  from, from == 1 ? "" : "s", number_text(std::max(uncorrelated_limit, 5 * correlation.chance), 2))
            : fmt::format("There is no distance in this texture from which on reads are uncorrelated (below {}).",
                          number_text(std::max(uncorrelated_limit, 5 * correlation.chance), 2));
    const Plot plot{"Autocorrelation of a slice", "distance (pixels)", "correlation", false, {mean, largest}};
    add({"Autocorrelation of a slice",
         text,
         {{plot_svg(plot), "How alike values are to those some pixels away, over rings of offsets; alike: 1.",
           plot_width}}});
  }

  // Where the filter groups just these two axes, how the power depends on the length of the frequency is shown too.
  void add_slice_axis(int axis) {
    const std::string& name = extents_.name(axis);
    const PlaneSpectrum spectrum = plane_spectrum(source_.texture, source_.kind, 0, axis);
    const std::vector<SpectrumBin> rows = row_average(spectrum);
    writer_.write_csv(fmt::format("spectrum_{}.csv", name), rows);
    ReportSection section{fmt::format("Spectrum over x and {}", name), "", {}};
    section.figures.push_back(writer_.spectrum_figure(
        fmt::format("spectrum_x{}.png", name), spectrum,
        {"Spectrum over x and " + name, along("x"), fmt::format("frequency along {} (cycles a slice)", name)},
        "Greys as above."));
    section.figures.push_back(
        {plot_svg(power_plot("Power over the frequencies along " + name,
                             fmt::format("frequency along {} (cycles a slice)", name), rows)),
         fmt::format("How each pixel changes along {}: the mean over all frequencies along x.", name)});
    if (const GroupQuality* const group = group_over({0, axis}))
      section.figures.push_back(shells(*group, "x and " + name));
    add(std::move(section));
  }

  ReportFigure shells(const GroupQuality& group, const std::string& names) {
    const std::vector<SpectrumBin> bins = radial_average(group.spectrum);
    writer_.write_csv(fmt::format("spectrum_{}.csv", group.name), bins);
    return {plot_svg(power_plot("Power over the frequencies of " + names, "frequency (cycles a pixel)", bins)),
            fmt::format("Averaged over frequencies of equal length in {}.", names)};
  }

  // Axes that the filter groups, other than x with y or x with a slice axis. More than two have no picture.
  void add_group(const GroupQuality& group) {
    std::string names;
    for (std::size_t a = 0; a < group.axes.size(); ++a)
      names += (a == 0 ? "" : a + 1 == group.axes.size() ? " and " : ", ") + extents_.name(group.axes[a]);
    ReportSection section{fmt::format("Spectrum over {}", names), "", {}};
    if (group.axes.size() == 2)
      section.figures.push_back(writer_.spectrum_figure(
          fmt::format("spectrum_{}.png", group.name), centred(group.spectrum),
          {"Spectrum over " + names, along(extents_.name(group.axes[0])), along(extents_.name(group.axes[1]))},
          "Greys as above."));
    section.figures.push_back(shells(group, names));
    add(std::move(section));
  }

  void add_low_frequencies() {
    const std::string svg = plot_svg(low_frequency_plot(source_.quality));
    writer_.write("spectra.svg", svg);
    add({"Low frequencies",
         fmt::format("What a blur leaves, and what the eye sees first. The table holds the mean power over all "
                     "frequencies below {} cycles a pixel, and the power at the three lowest ones along each slice "
                     "axis. White noise has 1.",
                     low_frequency),
         {{svg,
           "Power on a logarithmic scale, averaged over frequencies of equal length; a line for each set of axes. The "
           "dashed line upward: the limit of the table.",
           plot_width}},
         {low_frequency_table(source_.quality)}});
  }

  ReportWriter& writer_;
  const SpectrumSource& source_;
  const Extents& extents_;
};

}  // namespace

void add_spectrum_sections(ReportWriter& writer, const SpectrumSource& source) { Sections(writer, source).add_all(); }

}  // namespace noiseloom
