#include "noiseloom/report/analyze.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "noiseloom/core/decimal.h"
#include "noiseloom/image/naming.h"
#include "noiseloom/measure/score_file.h"
#include "noiseloom/report/filtered.h"
#include "noiseloom/report/number_text.h"
#include "noiseloom/report/picture.h"
#include "noiseloom/report/plot.h"
#include "noiseloom/samples/sample_space.h"
#include "report/mask_report.h"
#include "report/report_writer.h"
#include "report/spectrum_sections.h"

namespace noiseloom {
namespace {

// Longer sides of pictures, in CSS pixels. Pixels of a texture are shown as squares of a whole number of them.
constexpr int shown_size = 384;
constexpr int shown_small = 288;        // three in a row
constexpr int shown_quarter = 210;      // four in a row
constexpr int most_pixels_shown = 768;  // of a texture that is shown; larger ones are cut
constexpr int slices_shown = 4;
constexpr int shown_points = 70;  // pixels of a point set, so that they are large enough to be seen one by one

class Analysis {
 public:
  Analysis(const std::string& name, const TextureFile& file, const std::string& folder, OutputFiles& output,
           ThreadPool& pool, const ReportOrigin& origin)
      : file_(file),
        texture_(file.texture),
        extents_(file.texture.extents),
        filter_(file.config ? &file.config->problem.filter : nullptr),
        writer_(output, folder),
        report_(writer_.report),
        pool_(pool) {
    report_.title = std::filesystem::path(name).filename().string();
    if (report_.title.empty()) report_.title = name;
    report_.origin = origin;
    kind_ = file.config                  ? distance_kind(file.config->problem.samples, file.texture.channels)
            : file.texture.channels == 1 ? DistanceKind::absolute
                                         : DistanceKind::euclidean;
  }

  SpectralQuality run() {
    quality_ = spectral_quality(texture_, kind_, filter_);
    summarise();
    if (file_.config) score();
    show_low_frequency_figure();
    show_slices();
    if (!file_.places.empty()) show_points();
    if (file_.config) show_filtered_error();
    add_spectrum_sections(writer_, {texture_, kind_, quality_, filter_});
    if (!file_.history.empty()) show_convergence();
    if (file_.config) report_.config = to_toml(*file_.config);
    writer_.finish();
    return std::move(quality_);
  }

 private:
  // At most `most` pixels a side, each enlarged so that the picture fills `size`.
  static Picture shown(const Picture& picture, int most, int size) {
    const Picture part = cropped(picture, most, most);
    const int factor = factor_to_fill(std::max(part.width, part.height), size);
    return enlarged(part, factor, factor);
  }
  bool is_whole(int most) const { return extents_.width() <= most && extents_.height() <= most; }

  void summarise() {
    const std::string samples =
        file_.config ? describe_samples(file_.config->problem.samples) : "not given (taken as values from 0 to 1)";
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
    report_.headline.emplace_back(error_text(score.relative_error),
                                  "R: relative error of the whole texture after its own filter; white noise has 1");
    if (score.relative_error > 0)
      report_.headline.emplace_back(fmt::format("{:.1f} x", 1 / score.relative_error),
                                    "as many white-noise samples are needed for the same error");
    if (extents_.num_slices() > 1) {
      const auto [least, largest] = std::minmax_element(score.per_slice.begin(), score.per_slice.end());
      report_.summary.push_back({"R of single slices", fmt::format("{} to {}; their mean is R of the whole texture",
                                                                   error_text(*least), error_text(*largest))});
    }
    for (const FilterScore& other : score.others) report_.scores.push_back({other.filter, other.relative_error});
  }

  // Of the first group that reaches so low: xy for all but the smallest slices.
  void show_low_frequency_figure() {
    for (const GroupQuality& group : quality_.groups)
      if (std::isfinite(group.low_frequency_power)) {
        report_.headline.emplace_back(
            number_text(group.low_frequency_power, 2),
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
      const std::int64_t count = decimal_of(density).floor_of_times(extents_.num_cells());
      section.figures.push_back(
          writer_.figure(fmt::format("points_{:g}.png", density),
                         shown(points_picture(file_.places.data(), extents_, count), shown_points, shown_quarter),
                         fmt::format("{} %: {} points in all; {}first slice.", number_text(100 * density, 6), count,
                                     is_whole(shown_points) ? "" : "corner of the ")));
    }
    const std::size_t slices = file_.places.size() / static_cast<std::size_t>(extents_.cells_per_slice());
    section.figures.push_back(
        {plot_svg(points_plot(file_.places, extents_, densities)),
         fmt::format("Power of these patterns over the frequencies of a slice, on a logarithmic scale, averaged over "
                     "rings and {} slice{}. The dashed line upward: {} cycles a pixel.",
                     slices, slices == 1 ? "" : "s", low_frequency),
         plot_width});
    report_.sections.push_back(std::move(section));
  }

  void show_slices() {
    const ValueRange range = shown_range(file_);
    const Picture first = shown(slice_picture(texture_, range, SliceIndex(0)), most_pixels_shown, shown_size);
    const int factor = first.width / std::min(narrow<int>(extents_.width()), most_pixels_shown);
    const std::string colours = texture_.channels == 1   ? "value as grey"
                                : texture_.channels == 2 ? "the two values as red and green"
                                                         : "three values as red, green and blue";
    ReportSection section{"The texture", "", {}};
    section.figures.push_back(
        writer_.figure("preview.png", first,
                       fmt::format("{}irst slice, {}, every pixel {} x {}.",
                                   is_whole(most_pixels_shown) ? "F" : "A corner of the f", colours, factor, factor)));
    report_.sections.push_back(std::move(section));
    const std::int32_t count = std::min<std::int32_t>(slices_shown, extents_.num_slices());
    if (count == 1) return;
    ReportSection slices{"Its first slices", "", {}};
    for (const SliceIndex s : first_indices<SliceIndex>(count))
      slices.figures.push_back(
          writer_.figure(fmt::format("slice_{}.png", s.value()),
                         shown(slice_picture(texture_, range, s), shown_quarter, shown_quarter),
                         fmt::format("{}lice {}.", is_whole(shown_quarter) ? "S" : "Corner of s", s.value())));
    report_.sections.push_back(std::move(slices));
  }

  void show_filtered_error() {
    const Footprint footprint(extents_, *filter_);
    if (footprint.slices().front().taps.empty()) return;  // the filter does nothing inside a slice
    const FilteredError error = filtered_error(texture_, SliceIndex(0), footprint);
    const auto figure = [&](const std::string& name, const Picture& picture, const std::string& caption) {
      return writer_.figure(name, shown(picture, shown_small, shown_small), caption);
    };
    report_.sections.push_back(
        {"What the filter leaves",
         fmt::format("Every pixel of the first slice answers yes or no to a question whose true answer is one half (is "
                     "its value below the median?). After the filter inside the slice, the mean squared error of this "
                     "texture is {} of that of white noise. This is one slice, one question and no filter along other "
                     "axes; R is the mean over all slices and all questions, after the whole filter.",
                     error_text(error.ratio)),
         {figure("estimates.png", error.before, "One sample a pixel, before the filter."),
          figure("error_white_noise.png", error.white_noise, "Error after the filter: white noise."),
          figure("error.png", error.texture, "Error after the filter: this texture, same contrast.")}});
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
    writer_.write("convergence.csv", csv);
    ReportSection section{"Convergence", "R of the whole texture after its own filter, while it was made.", {}};
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
  const FilterSpec* filter_;  // null without a config
  DistanceKind kind_ = DistanceKind::euclidean;
  SpectralQuality quality_;
  ReportWriter writer_;
  Report& report_;  // the writer's
  ThreadPool& pool_;
};

}  // namespace

SpectralQuality analyze_texture(const std::string& name, const TextureFile& file, const std::string& folder,
                                OutputFiles& output, ThreadPool& pool, const ReportOrigin& origin) {
  return Analysis(name, file, folder, output, pool, origin).run();
}

}  // namespace noiseloom
