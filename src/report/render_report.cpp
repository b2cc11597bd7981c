#include "noiseloom/report/render_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "noiseloom/core/quantity_text.h"
#include "noiseloom/report/number_text.h"
#include "report/error_spectra.h"
#include "report/report_writer.h"

namespace noiseloom {
namespace {

using render::Result;
using render::ResultPicture;
using render::Scene;

constexpr int picture_size = 216;  // CSS pixels of a picture's side, four in a row
constexpr int wipe_size = 640;     // of one that is looked at alone

std::string repeats_text(int count) { return fmt::format("{} repeat{}", count, count == 1 ? "" : "s"); }

std::string percent_of(const Result& result, double rmse, std::size_t effect, std::size_t stage) {
  if (!result.white) return "";
  const double base = result.rmse(effect, *result.white, stage, result.frames - 1).mean;
  return base > 0 ? fmt::format("{:.0f} % of white", 100 * rmse / base) : "";
}

// Of at most so many pixels, cut from the middle, each shown as a square of whole pixels.
Picture shown(const ResultPicture& image, const ResultPicture* truth, double scale, int size = picture_size) {
  const int width = std::min(image.width, size);
  const int height = std::min(image.height, size);
  const int first_x = (image.width - width) / 2;
  const int first_y = (image.height - height) / 2;
  const std::size_t pixels = static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height);
  Picture picture{width, height, {}};
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      for (std::size_t c = 0; c < 3; ++c) {
        const std::size_t i = (image.channels == 3 ? c : 0) * pixels +
                              static_cast<std::size_t>(y + first_y) * static_cast<std::size_t>(image.width) +
                              static_cast<std::size_t>(x + first_x);
        const double value = static_cast<double>(image.values[i]);
        const double level = truth == nullptr ? value : 0.5 + scale * (value - static_cast<double>(truth->values[i]));
        picture.rgb.push_back(static_cast<std::uint8_t>(255 * std::clamp(level, 0.0, 1.0) + 0.5));
      }
  const int factor = factor_to_fill(std::max(width, height), size);
  return enlarged(picture, factor, factor);
}

// Two pictures of one size beside each other.
Picture beside(const Picture& a, const Picture& b) {
  Picture both{a.width + b.width, a.height, {}};
  for (int y = 0; y < a.height; ++y)
    for (const Picture* one : {&a, &b}) {
      const auto row = one->rgb.begin() + std::ptrdiff_t{3} * one->width * y;
      both.rgb.insert(both.rgb.end(), row, row + std::ptrdiff_t{3} * one->width);
    }
  return both;
}

// How many times: "1.7", and of hundreds and more two digits, "32000".
std::string times_text(double times) {
  if (times < 99.95) return fmt::format("{:.1f}", times);
  const double unit = std::pow(10, std::floor(std::log10(times)) - 1);
  return fmt::format("{:.0f}", std::round(times / unit) * unit);
}

class Page {
 public:
  Page(const Scene& scene, const Result& result, const std::string& folder, OutputFiles& output)
      : scene_(scene), result_(result), writer_(output, folder) {}

  ReportWriter& writer() { return writer_; }

  void add_effect(std::size_t effect) {
    const std::string name = render::name_of(result_.effects[effect]);
    const std::size_t last = main_stage();
    writer_.report.findings.push_back(sample_sentence(result_, effect, last));
    ReportSection section{name, "", {}, {}};
    section.text = fmt::format(
        "Root of the mean squared error in frame {}, over the whole picture and {} (results.csv has standard "
        "errors){}.",
        result_.frames, repeats_text(result_.repeats),
        result_.predictions.empty()
            ? ""
            : "; in brackets what the score of the texture promises, times the error of white noise");
    section.tables.push_back(table(effect));
    writer_.report.sections.push_back(section);
    for (std::size_t m = 1; m < result_.metrics.size(); ++m) add_metric(effect, name, result_.metrics[m]);
    if (scene_.puts_out("curves")) add_curves(effect, name);
    if (scene_.puts_out("images")) {
      add_pictures(effect, name, 0);
      if (last > 0) add_pictures(effect, name, last);
      add_wipe(effect, name, last);
      add_spectra(effect, name);
    }
    if (!result_.spectra.empty()) add_error_spectra(result_, effect, writer_);
  }

  void add_expectations(const std::vector<render::ExpectationResult>& expectations) {
    if (expectations.empty()) return;
    ReportTable table{{"expected", "measured", "outcome"}, {}, true};
    for (const auto& one : expectations)
      table.rows.push_back({{one.text, one.found, render::to_string(one.outcome)}, ""});
    writer_.report.sections.push_back({"What the scene expects", "", {}, {table}});
  }

  void add_notes() {
    if (result_.notes.empty()) return;
    ReportTable table{{"note"}, {}, true};
    for (const std::string& note : result_.notes) table.rows.push_back({{note}, ""});
    writer_.report.sections.push_back({"What is to be known of it", "", {}, {table}});
  }

  void add_passes() {
    ReportTable table{{"pass", "calls", "seconds", "why"}, {}, true};
    for (const render::PassResult& one : result_.passes)
      table.rows.push_back({{std::string(one.planned.pass->name), one.planned.on ? std::to_string(one.calls) : "off",
                             one.planned.on ? fmt::format("{:.2f}", one.seconds) : "", one.planned.why},
                            ""});
    writer_.report.sections.push_back(
        {"What was done", "Only what the outputs of the scene need. Seconds are of one processor.", {}, {table}});
  }

 private:
  // A line for each stage, a column for each noise.
  ReportTable table(std::size_t effect) const {
    ReportTable table{{"after"}, {}};
    for (const std::string& noise : result_.noises) table.columns.push_back(noise);
    const double* const biases = result_.bias.data() + effect * result_.stages.size();
    const bool has_bias = !std::isnan(biases[0]);  // none where the truth is another in every frame
    if (has_bias) table.columns.push_back("bias of the filter");
    for (std::size_t stage = 0; stage < result_.stages.size(); ++stage) {
      ReportTableRow row{{result_.stages[stage].to_string()}, ""};
      for (std::size_t noise = 0; noise < result_.noises.size(); ++noise) {
        const auto value = result_.rmse(effect, noise, stage, result_.frames - 1);
        const auto promised = result_.prediction(noise, stage);
        const double ratio = result_.over_white(effect, noise, stage, result_.frames - 1);
        row.cells.push_back(digits_text(value.mean) +
                            (promised && ratio > 0 ? fmt::format(" [{}]", digits_text(*promised * value.mean / ratio))
                                                   : std::string()));
      }
      if (has_bias) row.cells.push_back(digits_text(biases[stage]));
      row.strong = stage == main_stage();
      table.rows.push_back(row);
    }
    return table;
  }

  void add_metric(std::size_t effect, const std::string& name, render::Metric metric) {
    if (std::isnan(result_.of_repeat(metric, effect, 0, 0, 0, result_.frames - 1))) return;
    ReportTable values{{"after"}, {}};
    for (const std::string& noise : result_.noises) values.columns.push_back(noise);
    for (std::size_t stage = 0; stage < result_.stages.size(); ++stage) {
      ReportTableRow row{{result_.stages[stage].to_string()}, ""};
      for (std::size_t noise = 0; noise < result_.noises.size(); ++noise)
        row.cells.push_back(digits_text(result_.value(metric, effect, noise, stage, result_.frames - 1).mean));
      row.strong = stage == main_stage();
      values.rows.push_back(row);
    }
    writer_.report.sections.push_back({name + ": " + render::title_of(metric), "", {}, {values}});
  }

  // What most users look at: the first filter over time and the last over space, where there are such.
  std::size_t main_stage() const {
    const std::size_t spaces = scene_.space.size();
    return scene_.time.kernels.empty() ? spaces : 1 + 2 * spaces;
  }

  // White noise is broken.
  PlotLine::Style style_of(std::size_t noise) const {
    if (result_.white == noise) return PlotLine::Style::dashed;
    std::size_t place = 0;
    for (std::size_t i = 0; i < noise; ++i) place += result_.white == i ? 0 : 1;
    return style_of_line(place);
  }

  // One plot for each filter over time, before the filters over space and after the last of them.
  void add_curves(std::size_t effect, const std::string& name) {
    if (result_.frames < 2) return;
    ReportSection section{name + ": from frame to frame", "Both axes are logarithmic.", {}, {}};
    if (result_.repeats > 1) section.text += " Pale areas reach from the least to the largest error of a repeat.";
    for (std::size_t stage = 0; stage < result_.stages.size(); ++stage) {
      const render::Stage& at = result_.stages[stage];
      const bool is_last = !scene_.space.empty() && at.space == scene_.space.back().name;
      if (at.time == "frame" || (at.space != "none" && !is_last)) continue;
      Plot plot{at.to_string(), "frame", "error", true, {}, true};
      for (std::size_t noise = 0; noise < result_.noises.size(); ++noise) {
        PlotLine line{result_.noises[noise], {}, {}, style_of(noise)};
        for (int frame = 0; frame < result_.frames; ++frame) {
          line.x.push_back(frame + 1);
          line.y.push_back(result_.rmse(effect, noise, stage, frame).mean);
          std::vector<double> squares;
          for (int repeat = 0; repeat < result_.repeats; ++repeat)
            squares.push_back(result_.square(effect, noise, repeat, stage, frame));
          line.low.push_back(std::sqrt(*std::min_element(squares.begin(), squares.end())));
          line.high.push_back(std::sqrt(*std::max_element(squares.begin(), squares.end())));
        }
        line.has_band = result_.repeats > 1;
        plot.lines.push_back(line);
      }
      section.figures.push_back({plot_svg(plot), "After " + at.to_string() + "."});
    }
    if (!section.figures.empty()) writer_.report.sections.push_back(section);
  }

  const ResultPicture& picture(std::size_t effect, std::size_t noise, std::size_t stage) const {
    return result_.pictures[(effect * result_.noises.size() + noise) * result_.stages.size() + stage];
  }
  const ResultPicture& truth(std::size_t effect, std::size_t stage) const {
    return result_.truths[effect * result_.stages.size() + stage];
  }

  void add_pictures(std::size_t effect, const std::string& name, std::size_t stage) {
    const std::string after = result_.stages[stage].to_string();
    ReportSection section{fmt::format("{}: {}", name, stage == 0 ? "one frame alone" : "after " + after),
                          "Pixel by pixel, cut from the middle of the last frame. Errors are shown around mid grey, at "
                          "one scale for all.",
                          {},
                          {}};
    const auto file = [&](const std::string& what) { return fmt::format("page/{}_{}_{}.png", name, stage, what); };
    section.figures.push_back(writer_.figure(file("truth"), shown(truth(effect, stage), nullptr, 0), "the truth"));
    double largest = 0;
    for (std::size_t noise = 0; noise < result_.noises.size(); ++noise)
      largest = std::max(largest, result_.rmse(effect, noise, stage, result_.frames - 1).mean);
    const double scale = largest > 0 ? 1 / (8 * largest) : 0;
    for (std::size_t noise = 0; noise < result_.noises.size(); ++noise) {
      const std::string& of = result_.noises[noise];
      const double rmse = result_.rmse(effect, noise, stage, result_.frames - 1).mean;
      const std::string share = percent_of(result_, rmse, effect, stage);
      section.figures.push_back(writer_.figure(
          file(of),
          beside(shown(picture(effect, noise, stage), nullptr, 0),
                 shown(picture(effect, noise, stage), &truth(effect, stage), scale)),
          fmt::format("{}, and its error: {}{}", of, digits_text(rmse), share.empty() ? "" : ", " + share)));
    }
    writer_.report.sections.push_back(section);
  }

  // The truth and all noises over each other, after the filters that most users have.
  void add_wipe(std::size_t effect, const std::string& name, std::size_t stage) {
    std::vector<std::pair<std::string, Picture>> pictures = {
        {"truth", shown(truth(effect, stage), nullptr, 0, wipe_size)}};
    for (std::size_t noise = 0; noise < result_.noises.size(); ++noise)
      pictures.emplace_back(result_.noises[noise], shown(picture(effect, noise, stage), nullptr, 0, wipe_size));
    const std::string after = stage == 0 ? "one frame alone" : "after " + result_.stages[stage].to_string();
    writer_.report.sections.push_back(
        {fmt::format("{}: side by side, {}", name, after),
         "Choose two pictures, and draw the corner at the lower end of the line between them.",
         {writer_.wipe(fmt::format("page/{}_wipe", name), pictures, "The middle of the last frame.")}});
  }

  // How the error of a frame is spread over frequencies: all noises have about the same sum.
  void add_spectra(std::size_t effect, const std::string& name) {
    Plot plot{"power of the error", "frequency (cycles a pixel)", "power", true, {}};
    double sum = 0;
    for (std::size_t noise = 0; noise < result_.noises.size(); ++noise)
      sum = std::max(sum, result_.square(effect, noise, 0, 0, result_.frames - 1));
    if (!(sum > 0)) return;
    for (std::size_t noise = 0; noise < result_.noises.size(); ++noise) {
      const ResultPicture& image = picture(effect, noise, 0);
      if (image.width < 4 || image.height < 4) return;
      Texture error = make_texture(Extents({image.width, image.height}), image.channels);
      for (std::size_t i = 0; i < error.values.size(); ++i)
        error.values[i] = image.values[i] - truth(effect, 0).values[i];
      const double square = result_.square(effect, noise, 0, 0, result_.frames - 1);
      if (!(square > 0)) continue;
      const DistanceKind kind = image.channels == 1 ? DistanceKind::absolute : DistanceKind::euclidean;
      std::vector<SpectrumBin> bins = radial_average(plane_spectrum(error, kind, 0, 1));
      for (SpectrumBin& bin : bins) bin.power *= square / sum;
      plot.lines.push_back(line_of(bins, result_.noises[noise], style_of(noise)));
    }
    writer_.report.sections.push_back(
        {name + ": where the error of one frame lies",
         "Power of the error over frequencies of the picture, at one scale for all noises. What lies to the right is "
         "what "
         "filters over space remove.",
         {{plot_svg(plot), "Mean over rings of frequencies; the largest mean square error is 1."}},
         {}});
  }

  const Scene& scene_;
  const Result& result_;
  ReportWriter writer_;
};

}  // namespace

std::string sample_sentence(const Result& result, std::size_t effect, std::size_t stage) {
  const int last = result.frames - 1;
  std::vector<std::pair<double, std::size_t>> order;
  for (std::size_t noise = 0; noise < result.noises.size(); ++noise)
    order.emplace_back(result.square(effect, noise, 0, stage, last), noise);
  for (auto& [square, noise] : order) {
    const double rmse = result.rmse(effect, noise, stage, last).mean;
    square = rmse * rmse;
  }
  std::sort(order.begin(), order.end());
  const auto& [best, winner] = order.front();
  std::string text = fmt::format("{}, {}: {} has the least error, {}", render::name_of(result.effects[effect]),
                                 stage == 0 ? "each frame alone" : "after " + result.stages[stage].to_string(),
                                 result.noises[winner], digits_text(std::sqrt(best)));
  if (order.size() < 2) return text + ".";
  if (!(best > 0)) return text + ".";
  text += "; at the same error it needs ";
  std::string others;
  for (std::size_t i = order.size(); i-- > 1;)
    others += fmt::format("{}{} times fewer samples than {}",
                          others.empty() ? ""
                          : i == 1       ? " and "
                                         : ", ",
                          times_text(order[i].first / best), result.noises[order[i].second]);
  return text + others + ".";
}

void add_render_report(const Scene& scene, const Result& result,
                       const std::vector<render::ExpectationResult>& expectations, const std::string& scene_text,
                       const ReportOrigin& origin, const std::string& folder, OutputFiles& output) {
  Page page(scene, result, folder, output);
  Report& report = page.writer().report;
  report.title = scene.title.empty() ? "Rendering test" : scene.title;
  report.subtitle = fmt::format(
      "{} x {} pixels, {} frames, {} with the noises moved elsewhere. Errors are "
      "against the exact mean of the same estimates through the same filters.",
      scene.width, scene.height, scene.frames, repeats_text(scene.repeats));
  for (std::size_t effect = 0; effect < result.effects.size(); ++effect) page.add_effect(effect);
  page.add_expectations(expectations);
  page.add_notes();
  page.add_passes();
  report.config = scene_text;
  report.origin = origin;
  page.writer().finish();
}

}  // namespace noiseloom
