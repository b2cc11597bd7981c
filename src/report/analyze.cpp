#include "noiseloom/report/analyze.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "noiseloom/image/naming.h"
#include "noiseloom/measure/score_file.h"
#include "noiseloom/measure/spectrum.h"
#include "noiseloom/report/filtered.h"
#include "noiseloom/report/picture.h"
#include "noiseloom/report/plot.h"
#include "noiseloom/report/report.h"
#include "noiseloom/samples/sample_space.h"
#include "report/mask_report.h"

namespace noiseloom {
namespace {

constexpr int shown_size = 384;   // CSS pixels of a picture's longer side
constexpr int most_pixels = 768;  // of a picture; larger textures are cut, larger spectra averaged
constexpr int page_width = 954;
constexpr int shown_small = 288;
constexpr int slices_shown = 4;
constexpr int shown_quarter = 210;  // CSS pixels: four pictures in a row
constexpr int shown_points = 70;    // pixels of a point set, so that they are large enough to be seen one by one
constexpr int shown_plot = 640;

class Analysis {
 public:
  Analysis(const std::string& name, const TextureFile& file, const std::string& folder, OutputFiles& output,
           ThreadPool& pool)
      : file_(file),
        texture_(file.texture),
        extents_(file.texture.extents),
        folder_(folder),
        output_(output),
        pool_(pool) {
    report_.title = std::filesystem::path(name).filename().string();
    if (report_.title.empty()) report_.title = name;
    kind_ = file.config                  ? distance_kind(file.config->problem.samples, file.texture.channels)
            : file.texture.channels == 1 ? DistanceKind::absolute
                                         : DistanceKind::euclidean;
  }

  SpectralQuality run() {
    quality_ = spectral_quality(texture_, kind_, file_.config ? &file_.config->problem.filter : nullptr);
    summarise();
    if (file_.config) score();
    show_low_frequency_figure();
    show_slices();
    if (!file_.ranks.empty()) show_points();
    if (file_.config) show_filtered_error();
    show_plane_spectrum();
    for (int axis = 2; axis < extents_.num_axes(); ++axis)
      if (extents_.size(axis) > 1) show_slice_axis_spectrum(axis);
    for (const GroupQuality& group : quality_.groups)
      if (group.axes.size() > 1 && group.axes != std::vector<int>{0, 1}) show_group_spectrum(group);
    show_low_frequencies();
    if (!file_.history.empty()) show_convergence();
    if (file_.config) report_.config = to_toml(*file_.config);
    output_.write(path("report.html"), report_html(report_));
    return std::move(quality_);
  }

 private:
  std::string path(const std::string& file) const { return (std::filesystem::path(folder_) / file).string(); }

  // Writes the picture and returns it for the page, at most `widest` CSS pixels wide.
  ReportFigure figure(const std::string& file, const Picture& picture, const std::string& caption, int widest) {
    const std::string temporary = output_.add(path(file));
    write_picture(temporary, picture, caption);
    std::ifstream in(temporary, std::ios::binary);
    const std::vector<char> bytes{std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
    return {embedded_png(std::as_bytes(std::span(bytes)), caption), caption, std::min(picture.width, widest)};
  }

  void summarise() {
    const std::string samples =
        file_.config ? sample_space_name(file_.config->problem.samples) : "not given (taken as values from 0 to 1)";
    report_.subtitle = fmt::format("{} pixels, {} value{} each", extents_.to_string(), texture_.channels,
                                   texture_.channels == 1 ? "" : "s");
    std::vector<ReportRow>& rows = report_.summary;
    rows.push_back({"Source", file_.source});
    rows.push_back({"Size", axes_text()});
    rows.push_back({"Samples", samples});
    if (file_.config) rows.push_back({"Filter", describe_filter(extents_, file_.config->problem.filter)});
    if (!file_.checksum.empty()) rows.push_back({"Checksum of samples", file_.checksum});
    for (const std::string& name : quality_.left_out)
      rows.push_back({"Note", fmt::format("The group {} is too large for its spectrum to be shown.", name)});
    for (const std::string& note : file_.notes) rows.push_back({"Note", note});
  }

  std::string axes_text() const {
    std::string text;
    for (int axis = 0; axis < extents_.num_axes(); ++axis)
      text += fmt::format("{}{} = {}", axis == 0 ? "" : ", ", extents_.name(axis), extents_.size(axis));
    return text;
  }

  void score() {
    const TextureScore score =
        score_texture(texture_, kind_, file_.config->problem.filter, standard_filters(extents_), pool_);
    report_.headline.emplace_back(fmt::format("{:.4f}", score.relative_error),
                                  "relative error R after its filter; white noise has 1");
    if (score.relative_error > 0)
      report_.headline.emplace_back(fmt::format("{:.1f} x", 1 / score.relative_error),
                                    "as many white-noise samples are needed for the same error");
    if (extents_.num_slices() > 1) {
      const auto [least, largest] = std::minmax_element(score.per_slice.begin(), score.per_slice.end());
      report_.summary.push_back({"R, slice by slice", fmt::format("{:.4f} to {:.4f}", *least, *largest)});
    }
    for (const FilterScore& other : score.others) report_.scores.push_back({other.filter, other.relative_error});
  }

  // Of the first group that reaches so low: xy for all but the smallest slices.
  void show_low_frequency_figure() {
    for (const GroupQuality& group : quality_.groups)
      if (std::isfinite(group.low_frequency_power)) {
        report_.headline.emplace_back(
            fmt::format("{:.2g}", group.low_frequency_power),
            fmt::format("power over {} below {} cycles a pixel; white noise has 1", group.name, low_frequency));
        return;
      }
  }

  void show_points() {
    const std::vector<double> densities = shown_densities(extents_.num_cells());
    if (densities.empty()) return;
    ReportSection section{
        "Point sets",
        "The pixels that come first in the sequence; every density holds all points of those below it. "
        "noiseloom export --threshold writes them.",
        {}};
    for (const double density : densities) {
      const std::int64_t count = num_points(density, extents_.num_cells());
      const Picture part = cropped(points_picture(file_.ranks.data(), extents_, count), shown_points, shown_points);
      const int factor = factor_to_fill(std::max(part.width, part.height), shown_quarter);
      const bool whole = part.width == extents_.width() && part.height == extents_.height();
      section.figures.push_back(figure(
          fmt::format("points_{:g}.png", density), enlarged(part, factor, factor),
          fmt::format("{:g} %: {} points in all; {}first slice.", 100 * density, count, whole ? "" : "corner of the "),
          shown_quarter));
    }
    const std::size_t slices = file_.ranks.size() / static_cast<std::size_t>(extents_.cells_per_slice());
    section.figures.push_back(
        {plot_svg(points_plot(file_.ranks, extents_, densities)),
         fmt::format("Power of these patterns over the frequencies of a slice, on a logarithmic scale, averaged over "
                     "rings and {} slice{}. The dashed line upward: {} cycles a pixel.",
                     slices, slices == 1 ? "" : "s", low_frequency),
         shown_plot});
    report_.sections.push_back(std::move(section));
  }

  void show_slices() {
    const ValueRange range = shown_range(file_);
    const Picture first = cropped(slice_picture(texture_, range, 0), most_pixels, most_pixels);
    const bool whole = first.width == extents_.width() && first.height == extents_.height();
    const int factor = factor_to_fill(std::max(first.width, first.height), shown_size);
    const std::string shown = texture_.channels == 1   ? "value as grey"
                              : texture_.channels == 2 ? "the two values as red and green"
                                                       : "three values as red, green and blue";
    ReportSection section{"The texture", "", {}};
    section.figures.push_back(figure(
        "preview.png", enlarged(first, factor, factor),
        fmt::format("{}irst slice, {}, every pixel {} x {}.", whole ? "F" : "A corner of the f", shown, factor, factor),
        most_pixels));
    const SliceIndex count = std::min<SliceIndex>(slices_shown, extents_.num_slices());
    if (count > 1) {
      const int small = std::max(1, factor / 2);
      std::vector<Picture> slices;
      for (SliceIndex s = 0; s < count; ++s)
        slices.push_back(enlarged(cropped(slice_picture(texture_, range, s), shown_small, shown_small), small, small));
      section.figures.push_back(
          figure("slices.png", side_by_side(slices, 8), fmt::format("Slices 0 to {}.", count - 1), page_width));
    }
    report_.sections.push_back(std::move(section));
  }

  void show_filtered_error() {
    const Footprint footprint(extents_, file_.config->problem.filter);
    if (footprint.slices().front().taps.empty()) return;  // the filter does nothing inside a slice
    const FilteredError error = filtered_error(texture_, 0, footprint);
    const auto shown = [&](const std::string& name, const Picture& picture, const std::string& caption) {
      const Picture part = cropped(picture, shown_small, shown_small);
      const int factor = factor_to_fill(std::max(part.width, part.height), shown_small);
      return figure(name, enlarged(part, factor, factor), caption, shown_small);
    };
    report_.sections.push_back(
        {"What the filter leaves",
         fmt::format("Every pixel of the first slice answers yes or no to a question whose true answer is one half (is "
                     "its value below the median?). After the filter inside the slice, the mean squared error of this "
                     "texture is {:.3f} of that of white noise.",
                     error.ratio),
         {shown("estimates.png", error.before, "One sample a pixel, before the filter."),
          shown("error_white_noise.png", error.white_noise, "Error after the filter: white noise."),
          shown("error.png", error.texture, "Error after the filter: this texture, same contrast.")}});
  }

  void write_csv(const std::string& file, const std::vector<SpectrumBin>& bins) {
    std::string text = "frequency_cycles_per_pixel,power,count\n";
    for (const SpectrumBin& bin : bins) text += fmt::format("{},{},{}\n", bin.frequency, bin.power, bin.count);
    output_.write(path(file), text);
  }

  // Both axes of a spectrum run from -1/2 to 1/2, however many frequencies lie between.
  static Picture square(const PlaneSpectrum& spectrum) {
    const Picture picture = spectrum_picture(spectrum, most_pixels);
    return enlarged(picture, factor_to_fill(picture.width, shown_size), factor_to_fill(picture.height, shown_size));
  }

  static PlotLine line_of(const std::vector<SpectrumBin>& bins, const std::string& label, PlotLine::Style style) {
    PlotLine line{label, {}, {}, style};
    for (const SpectrumBin& bin : bins) {
      line.x.push_back(bin.frequency);
      line.y.push_back(bin.power);
    }
    return line;
  }

  PlaneSpectrum xy_spectrum() const {
    for (const GroupQuality& group : quality_.groups)
      if (group.axes == std::vector<int>{0, 1}) return centred(group.spectrum);
    return plane_spectrum(texture_, kind_, 0, 1);
  }

  void show_plane_spectrum() {
    const PlaneSpectrum spectrum = xy_spectrum();
    const std::vector<SpectrumBin> rings = radial_average(spectrum);
    write_csv("spectrum_xy.csv", rings);
    Plot plot{"Power over the frequencies of a slice",
              "frequency (cycles a pixel)",
              "power, white noise = 1",
              false,
              {line_of(rings, "this texture", PlotLine::Style::main),
               PlotLine{"white noise", {0, 0.5}, {1, 1}, PlotLine::Style::dashed}}};
    std::string text = "Where the filter lets much through, power should be low: that error stays in the image.";
    if (file_.config) {
      const Footprint footprint(extents_, file_.config->problem.filter);
      plot.lines.push_back(
          line_of(radial_average(filter_response(footprint)), "filter lets through", PlotLine::Style::second));
    } else {
      text = "A blur removes high frequencies; power at low ones stays in the image as error.";
    }
    const std::string svg = plot_svg(plot);
    output_.write(path("spectrum_xy.svg"), svg);
    report_.sections.push_back(
        {"Spectrum of a slice",
         text,
         {figure(
              "spectrum_xy.png", square(spectrum),
              "Mean over slices and channels, frequency zero in the middle. Black: none; light grey: as white noise; "
              "white: twice that or more.",
              shown_size),
          {svg, "The same, averaged over rings."}}});
  }

  void show_slice_axis_spectrum(int axis) {
    const std::string& name = extents_.name(axis);
    const PlaneSpectrum spectrum = plane_spectrum(texture_, kind_, 0, axis);
    const std::vector<SpectrumBin> rows = row_average(spectrum);
    write_csv(fmt::format("spectrum_{}.csv", name), rows);
    const Plot plot{"Power over the frequencies along " + name,
                    fmt::format("frequency along {} (cycles a slice)", name),
                    "power, white noise = 1",
                    false,
                    {line_of(rows, "this texture", PlotLine::Style::main),
                     PlotLine{"white noise", {0, 0.5}, {1, 1}, PlotLine::Style::dashed}}};
    report_.sections.push_back(
        {fmt::format("Spectrum over x and {}", name),
         "",
         {figure(
              fmt::format("spectrum_x{}.png", name), square(spectrum),
              fmt::format("Frequency along x to the right, along {} upward, zero in the middle; greys as above.", name),
              shown_size),
          {plot_svg(plot),
           fmt::format("How each pixel changes along {}: the mean over all frequencies along x.", name)}}});
  }

  // Axes that the filter groups, other than x with y.
  void show_group_spectrum(const GroupQuality& group) {
    const std::vector<SpectrumBin> rings = radial_average(group.spectrum);
    write_csv(fmt::format("spectrum_{}.csv", group.name), rings);
    std::string names;
    for (std::size_t a = 0; a < group.axes.size(); ++a)
      names += (a == 0 ? "" : a + 1 == group.axes.size() ? " and " : ", ") + extents_.name(group.axes[a]);
    const Plot plot{"Power over the frequencies of " + names,
                    "frequency (cycles a pixel)",
                    "power, white noise = 1",
                    false,
                    {line_of(rings, "this texture", PlotLine::Style::main),
                     PlotLine{"white noise", {0, 0.5}, {1, 1}, PlotLine::Style::dashed}}};
    ReportSection section{fmt::format("Spectrum over {}", names), "", {}};
    if (group.axes.size() == 2)
      section.figures.push_back(figure(fmt::format("spectrum_{}.png", group.name), square(centred(group.spectrum)),
                                       fmt::format("Frequency along {} to the right, along {} upward, zero in the "
                                                   "middle; greys as above.",
                                                   extents_.name(group.axes[0]), extents_.name(group.axes[1])),
                                       shown_size));
    section.figures.push_back({plot_svg(plot), fmt::format("Averaged over frequencies of equal length in {}.", names)});
    report_.sections.push_back(std::move(section));
  }

  void show_low_frequencies() {
    const std::string svg = plot_svg(low_frequency_plot(quality_));
    output_.write(path("spectra.svg"), svg);
    report_.sections.push_back(
        {"Low frequencies",
         fmt::format(
             "What a blur leaves, and what the eye sees first. The table holds the mean power over all frequencies "
             "below "
             "{} cycles a pixel, and the power at the three lowest ones along each slice axis. White noise has 1.",
             low_frequency),
         {{svg,
           "Power on a logarithmic scale, averaged over frequencies of equal length; a line for each set of axes. The "
           "dashed line "
           "upward: the limit of the table.",
           shown_plot}},
         {low_frequency_table(quality_)}});
  }

  const std::vector<double>* column(const std::string& name) const {
    for (const auto& [column_name, values] : file_.history)
      if (column_name == name) return &values;
    return nullptr;
  }

  void show_convergence() {
    const std::vector<double>* const error = column("relative_error");
    if (error == nullptr || error->size() < 2) return;
    std::string csv;
    for (const auto& [name, values] : file_.history) csv += (csv.empty() ? "" : ",") + name;
    csv += "\n";
    for (std::size_t row = 0; row < error->size(); ++row)
      for (std::size_t c = 0; c < file_.history.size(); ++c)
        csv += fmt::format("{}{}", file_.history[c].second[row], c + 1 == file_.history.size() ? "\n" : ",");
    output_.write(path("convergence.csv"), csv);
    ReportSection section{"Convergence", "", {}};
    for (const auto& [name, label] : {std::pair{"iterations", "iterations"}, std::pair{"seconds", "seconds"}}) {
      const std::vector<double>* const x = column(name);
      if (x == nullptr || x->back() <= 0) continue;
      const Plot plot{fmt::format("R against {}", label),
                      label,
                      "relative error R",
                      true,
                      {PlotLine{"", *x, *error, PlotLine::Style::main}}};
      section.figures.push_back({plot_svg(plot), fmt::format("R against {}.", label)});
    }
    report_.sections.push_back(std::move(section));
  }

  const TextureFile& file_;
  const Texture& texture_;
  const Extents& extents_;
  std::string folder_;
  OutputFiles& output_;
  ThreadPool& pool_;
  DistanceKind kind_ = DistanceKind::euclidean;
  SpectralQuality quality_;
  Report report_;
};

}  // namespace

SpectralQuality analyze_texture(const std::string& name, const TextureFile& file, const std::string& folder,
                                OutputFiles& output, ThreadPool& pool) {
  return Analysis(name, file, folder, output, pool).run();
}

}  // namespace noiseloom
