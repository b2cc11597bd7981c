#include "noiseloom/accuracy/accuracy_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <set>

#include "noiseloom/anneal/swap_choices.h"
#include "noiseloom/image/encoding.h"
#include "noiseloom/image/naming.h"
#include "noiseloom/report/plot.h"
#include "noiseloom/report/report.h"
#include "noiseloom/samples/sample_space.h"

namespace noiseloom {
namespace {

std::string error_number(double r) { return fmt::format("{:.4f}", r); }
std::string ratio_text(double ratio) { return fmt::format("{:.3f}", ratio); }

std::vector<const AccuracyRow*> by_seconds(const std::vector<AccuracyRow>& rows) {
  std::vector<const AccuracyRow*> sorted;
  for (const AccuracyRow& row : rows) sorted.push_back(&row);
  std::sort(sorted.begin(), sorted.end(),
            [](const AccuracyRow* a, const AccuracyRow* b) { return a->seconds < b->seconds; });
  return sorted;
}

std::string short_note(const AccuracyPoint& point, std::int64_t iterations) {
  if (iterations == 0) return method_name(point.method);
  if (!point.is_knob()) return std::to_string(iterations);
  if (point.setting == "precision") return point.value;
  return (point.setting == "cutoff" ? "cutoff " : "features ") + point.value;
}

// What each knob is, and what to expect of it.
struct KnobText {
  const char* setting;
  const char* title;
  const char* text;
};
constexpr KnobText knob_texts[] = {
    {"cutoff", "Footprint cut-off",
     "Taps of the filter's overlap below this fraction of the largest (of a sum: of the largest of their group) are "
     "left out of the energy. Fewer taps are quicker to visit; what is left out is not optimised. Where the config "
     "does not say, annealing has 0.001 and the paper's method 0."},
    {"background_features", "Features of the background",
     "How many features stand for the other slices. Few are quick and coarse; 0 visits every tap of every slice, "
     "exactly."},
    {"precision", "Float or double",
     "Arithmetic of the energy while swapping. R itself is always computed in double. Double visits every tap, without "
     "a background."},
};

class Page {
 public:
  explicit Page(const AccuracyStudy& study)
      : study_(study),
        rows_(by_seconds(study.rows)),
        all_above_(std::all_of(rows_.begin(), rows_.end(), [](const auto* row) { return row->relative_error > 1; })) {}

  std::string html() {
    report_.title = std::filesystem::path(study_.name).filename().string() + ": what accuracy costs";
    const ProblemSpec& problem = study_.config.problem;
    report_.subtitle = fmt::format("{} pixels of {}, for {}", problem.extents.to_string(),
                                   describe_samples(problem.samples), describe_filter(problem.extents, problem.filter));
    if (!rows_.empty()) {
      headline();
      report_.findings = accuracy_sentences(study_.rows);
    }
    summarise();
    if (!rows_.empty()) {
      show_plot();
      for (const KnobText& knob : knob_texts) show_knob(knob);
      show_bits();
      show_all();
    }
    show_left_out();
    report_.config = to_toml(study_.config);
    report_.origin = study_.origin;
    return report_html(report_);
  }

 private:
  static std::string spread_words(const AccuracyRow& row) {
    if (row.runs < 2) return "";
    return fmt::format(", mean of {} seeds, which have {} to {}", row.runs, error_number(row.least_error),
                       error_number(row.largest_error));
  }

  void headline() {
    const auto add = [&](const AccuracyRow* row, const std::string& name) {
      if (row == nullptr) return;
      report_.headline.emplace_back(error_number(row->relative_error),
                                    fmt::format("R of {} ({}){}", name, describe_row(*row), spread_words(*row)));
      report_.headline.emplace_back(seconds_text(row->seconds), "for " + name);
    };
    const AccuracyRow* const standard = default_row(study_.rows);
    const AccuracyRow* const best = best_row(study_.rows);
    add(standard, "the default");
    if (best != standard) add(best, "the best measured");
  }

  void summarise() {
    std::set<int> threads;
    for (const AccuracyRow* row : rows_) threads.insert(row->threads);
    std::string counts;
    for (const int n : threads) counts += fmt::format("{}{}", counts.empty() ? "" : " and ", n);
    std::vector<ReportRow>& rows = report_.summary;
    rows.push_back(
        {"State", fmt::format("{}: {} points ran, {} did not", study_.state, rows_.size(), study_.left_out.size())});
    rows.push_back(
        {"Budget", fmt::format("{} of {} used", seconds_text(study_.spent_s), seconds_text(study_.budget_s))});
    rows.push_back({"R",
                    "Relative error: the mean squared error left after the filter, over random step functions; "
                    "white noise has 1"});
    int most_runs = 0;
    for (const AccuracyRow* row : rows_) most_runs = std::max(most_runs, row->runs);
    rows.push_back({"Seconds", fmt::format("Wall time of the whole process, with start-up and writing the file{}",
                                           most_runs > 1 ? ": the mean over the seeds"
                                                         : "; each point ran once, so a few per cent mean nothing")});
    if (most_runs > 1)
      rows.push_back({"Runs", fmt::format("{} of each point, with a seed of its own each: R is their mean, and the "
                                          "least and largest R stand beside it",
                                          most_runs)});
    if (!counts.empty())
      rows.push_back(
          {"Threads", counts + (threads.size() > 1 ? ": seconds of different thread counts do not compare" : "")});
    rows.push_back({most_runs > 1 ? "First seed" : "Seed", std::to_string(study_.config.problem.seed)});
  }

  // One line of the plot, by iterations; the points of knobs in any order. Those above white noise are counted instead.
  PlotLine plot_line(const std::string& label, PlotLine::Style style, int& above,
                     bool (*belongs)(const AccuracyPoint&)) const {
    std::vector<const AccuracyRow*> rows;
    for (const AccuracyRow* row : rows_) {
      if (!belongs(row->point)) continue;
      if (row->relative_error <= 1 || all_above_)
        rows.push_back(row);
      else
        ++above;
    }
    std::stable_sort(rows.begin(), rows.end(),
                     [](const AccuracyRow* a, const AccuracyRow* b) { return a->iterations < b->iterations; });
    PlotLine line{label, {}, {}, style};
    for (const AccuracyRow* row : rows) {
      line.x.push_back(row->seconds);
      line.y.push_back(row->relative_error);
      line.low.push_back(row->least_error);
      line.high.push_back(row->largest_error);
      line.names.push_back(
          fmt::format("{}: R {}, {}", describe_row(*row), error_with_spread(*row), seconds_text(row->seconds)));
      line.notes.push_back(short_note(row->point, row->iterations));
    }
    return line;
  }

  PlotLine front_line() const {
    PlotLine front{"Pareto front", {}, {}, PlotLine::Style::front};
    const std::vector<bool> on_front = pareto_front(study_.rows);
    for (const AccuracyRow* row : rows_) {
      if (!on_front[static_cast<std::size_t>(row - study_.rows.data())] || (row->relative_error > 1 && !all_above_))
        continue;
      front.x.push_back(row->seconds);
      front.y.push_back(row->relative_error);
    }
    return front;
  }

  void show_plot() {
    int above = 0;
    Plot plot{
        "R against seconds", "seconds (whole process)", "relative error R", true, {front_line()}, true, {}, 910, 440};
    const PlotLine lines[] = {
        plot_line("anneal", PlotLine::Style::main, above,
                  [](const AccuracyPoint& p) { return !p.is_knob() && p.method == Method::anneal; }),
        plot_line("fast", PlotLine::Style::second, above,
                  [](const AccuracyPoint& p) { return !p.is_knob() && p.method == Method::fast; }),
        plot_line("construct", PlotLine::Style::third, above,
                  [](const AccuracyPoint& p) { return p.method == Method::construct; }),
        plot_line("void-and-cluster", PlotLine::Style::fourth, above,
                  [](const AccuracyPoint& p) { return p.method == Method::void_and_cluster; }),
        plot_line("one setting changed", PlotLine::Style::points, above,
                  [](const AccuracyPoint& p) { return p.is_knob(); })};
    for (const PlotLine& line : lines)
      if (!line.x.empty()) plot.lines.push_back(line);
    if (const AccuracyRow* const standard = default_row(study_.rows))
      plot.marks.push_back({"default", standard->seconds, standard->relative_error});
    std::string caption =
        "Every dot is a point; the number at it is its iterations; the mouse over it shows more. An upright line leads "
        "from the least R of its seeds to the largest.";
    if (above > 0)
      caption +=
          fmt::format(" Not shown: {} point{} that ended above white noise (R > 1).", above, above == 1 ? "" : "s");
    report_.sections.push_back(
        {"R against seconds",
         "Both axes are logarithmic; down and to the left is better. No point beats one on the Pareto front in both at "
         "once.",
         {{plot_svg(plot), caption}}});
  }

  void show_knob(const KnobText& knob) {
    ReportTable table{{"value", "iterations", "R", "ratio", "seconds", "ratio", ""}, {}, true};
    for (const auto& [negative_iterations, rows] : by_iterations(knob.setting)) {
      const AccuracyRow* const base = base_row(study_.rows, *rows.front());
      std::vector<std::pair<double, ReportTableRow>> lines;
      lines.emplace_back(order_of(own_value(knob.setting)),
                         knob_line(*base, *base, own_value(knob.setting) + " (config)"));
      for (const AccuracyRow* row : rows)
        lines.emplace_back(order_of(row->point.value), knob_line(*row, *base, row->point.value));
      std::stable_sort(lines.begin(), lines.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
      for (auto& [order, line] : lines) table.rows.push_back(std::move(line));
    }
    if (!table.rows.empty())
      report_.sections.push_back(
          {knob.title, knob.text + std::string(" Ratios are to the run with nothing else changed."), {}, {table}});
  }

  // Values that are words come in the order in which they are found.
  static double order_of(const std::string& value) { return std::strtod(value.c_str(), nullptr); }

  // The rows of a knob that have a run to be compared with, most iterations first.
  std::map<std::int64_t, std::vector<const AccuracyRow*>> by_iterations(const std::string& setting) const {
    std::map<std::int64_t, std::vector<const AccuracyRow*>> groups;
    for (const AccuracyRow& row : study_.rows)
      if (row.point.setting == setting && base_row(study_.rows, row) != nullptr)
        groups[-row.iterations].push_back(&row);
    return groups;
  }

  static ReportTableRow knob_line(const AccuracyRow& row, const AccuracyRow& base, const std::string& value) {
    const double error = row.relative_error / base.relative_error;
    const double seconds = row.seconds / base.seconds;
    std::string words;
    if (&row != &base) words = fmt::format("error: {}; time: {}", difference_text(error), difference_text(seconds));
    return {{value, std::to_string(row.iterations), error_number(row.relative_error), ratio_text(error),
             seconds_text(row.seconds), ratio_text(seconds), words},
            "",
            &row == &base};
  }

  std::string own_value(const std::string& setting) const {
    const OptimizerSpec& optimizer = study_.config.optimizer;
    if (setting == "cutoff") return shortest_number(energy_cutoff(optimizer));
    if (setting == "background_features") return std::to_string(optimizer.background_features);
    return optimizer.precision == Precision::float64 ? "double" : "float";
  }

  void show_bits() {
    ReportTable table{{"run", "R, float", "R, 16 bit", "over float", "R, 8 bit", "over float"}, {}};
    const AccuracyRow* const standard = default_row(study_.rows);
    for (const AccuracyRow* row : rows_) {
      if (row->point.is_knob() || row->point.method != study_.config.optimizer.method || !row->r_8bit || !row->r_16bit)
        continue;
      table.rows.push_back({{describe_row(*row), error_number(row->relative_error), error_number(*row->r_16bit),
                             ratio_text(*row->r_16bit / row->relative_error), error_number(*row->r_8bit),
                             ratio_text(*row->r_8bit / row->relative_error)},
                            "",
                            row == standard});
    }
    std::string text =
        "The same samples as images hold them, stored and decoded as noiseloom export does. No run was made for this.";
    if (table.rows.empty())
      text =
          "These samples have no natural bounds: what 8 and 16 bits cost depends on the range that is given to "
          "noiseloom export --range.";
    report_.sections.push_back({"Output bits", text, {}, {}});
    if (!table.rows.empty()) report_.sections.back().tables.push_back(table);
  }

  void show_all() {
    ReportTable table{{"point", "R", "least", "largest", "runs", "seconds", "threads", ""}, {}, true};
    const std::vector<bool> on_front = pareto_front(study_.rows);
    for (const AccuracyRow* row : rows_) {
      const bool front = on_front[static_cast<std::size_t>(row - study_.rows.data())];
      std::string notes = row->point.is_default ? "default" : "";
      if (front) notes += notes.empty() ? "on the front" : ", on the front";
      table.rows.push_back({{describe_row(*row), error_number(row->relative_error), error_number(row->least_error),
                             error_number(row->largest_error), std::to_string(row->runs), seconds_text(row->seconds),
                             std::to_string(row->threads), notes},
                            row->command,
                            row->point.is_default});
    }
    report_.sections.push_back(
        {"Every point",
         fmt::format("By time, each with the command that makes its first run again. Further runs have --set "
                     "texture.seed={} and the seeds after it.",
                     study_.config.problem.seed + 1),
         {},
         {table}});
  }

  void show_left_out() {
    if (study_.left_out.empty()) return;
    ReportTable table{{"point", "why"}, {}, true};
    for (const LeftOut& left : study_.left_out)
      table.rows.push_back({{describe_point(left.point), left.reason}, "", left.point.is_default});
    report_.sections.push_back(
        {"Not run",
         "A longer budget reaches further: run the same command with --resume and a larger --budget.",
         {},
         {table}});
  }

  const AccuracyStudy& study_;
  std::vector<const AccuracyRow*> rows_;  // by seconds
  bool all_above_;                        // no run ended below white noise
  Report report_;
};

}  // namespace

std::string accuracy_html(const AccuracyStudy& study) { return Page(study).html(); }

}  // namespace noiseloom
