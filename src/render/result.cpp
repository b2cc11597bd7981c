#include "noiseloom/render/result.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <span>

#include "noiseloom/core/json.h"
#include "noiseloom/core/quantity_text.h"
#include "render/jobs/frames.h"

namespace noiseloom::render {
namespace {

std::size_t index_of(const std::vector<std::string>& names, const std::string& name) {
  return static_cast<std::size_t>(std::find(names.begin(), names.end(), name) - names.begin());
}

// Where an expectation looks.
struct Place {
  Metric metric = Metric::rmse;
  std::size_t effect = 0;
  std::size_t stage = 0;
  int frame = 0;
};

Place place_of(const ExpectSpec& expect, const Result& result) {
  Place place{.frame = (expect.frame == 0 ? result.frames : expect.frame) - 1};
  for (const Metric metric : result.metrics)
    if (name_of(metric) == expect.metric) place.metric = metric;
  while (name_of(result.effects[place.effect]) != expect.effect) ++place.effect;
  while (result.stages[place.stage].time != expect.time || result.stages[place.stage].space != expect.space)
    ++place.stage;
  return place;
}

std::vector<double> repeats_of(const Result& result, const Place& place, const std::string& noise) {
  std::vector<double> values;
  for (int repeat = 0; repeat < result.repeats; ++repeat)
    values.push_back(
        result.of_repeat(place.metric, place.effect, index_of(result.noises, noise), repeat, place.stage, place.frame));
  return values;
}

std::string where(const ExpectSpec& expect, const Place& place, const Result& result) {
  return fmt::format("{}{}, {}, frame {}", place.metric == Metric::rmse ? "" : expect.metric + " of ", expect.effect,
                     result.stages[place.stage].to_string(), place.frame + 1);
}

MeanAndError value_at(const Result& result, const Place& place, const std::string& noise) {
  return result.value(place.metric, place.effect, index_of(result.noises, noise), place.stage, place.frame);
}

ExpectationResult check_order(const ExpectSpec& expect, const Result& result) {
  const Place place = place_of(expect, result);
  const std::vector<OrderTerm> terms = parse_order(expect.order);
  Outcome worst = Outcome::holds;
  std::string found;
  for (std::size_t i = 0; i < terms.size(); ++i) {
    const auto value = value_at(result, place, terms[i].noise);
    found += fmt::format("{}{} {}", i == 0 ? "" : fmt::format(" {} ", terms[i].relation), terms[i].noise,
                         digits_text(value.mean));
    if (i == 0) continue;
    const std::vector<double> a = repeats_of(result, place, terms[i - 1].noise);
    const std::vector<double> b = repeats_of(result, place, terms[i].noise);
    std::vector<double> differences;
    for (std::size_t r = 0; r < a.size(); ++r) differences.push_back(a[r] - b[r]);
    // Squares differ by twice as much as their roots.
    const double margin = (is_root(place.metric) ? 2 : 1) * expect.within * mean_and_error(b).mean;
    const Outcome outcome =
        terms[i].relation == '<' ? outcome_of_less(differences) : outcome_of_equal(differences, margin);
    if (outcome != Outcome::holds) found += fmt::format(" ({})", to_string(outcome));
    worst = std::max(worst, outcome);
  }
  return {fmt::format("{} ({})", expect.order, where(expect, place, result)), worst, found};
}

// Within a share of the value, and three standard errors of what was measured.
ExpectationResult check_value(const ExpectSpec& expect, const Result& result) {
  const Place place = place_of(expect, result);
  MeanAndError value = value_at(result, place, expect.noise);
  const bool is_ratio = expect.ratio > 0;
  if (is_ratio) {
    const MeanAndError other = value_at(result, place, expect.against);
    const double ratio = value.mean / other.mean;
    value = {ratio, ratio * std::hypot(value.error / value.mean, other.error / other.mean)};
  }
  const double wanted = is_ratio ? expect.ratio : expect.rmse;
  const double chance = std::isfinite(value.error) ? 3 * value.error : 0;
  const bool holds = std::fabs(value.mean - wanted) <= wanted * expect.within + chance;
  return {fmt::format("{} {} {} within {} % ({})", is_ratio ? expect.noise + " / " + expect.against : expect.noise,
                      is_ratio ? "=" : "has", wanted, 100 * expect.within, where(expect, place, result)),
          holds ? Outcome::holds : Outcome::fails,
          fmt::format("{} +- {}", digits_text(value.mean), digits_text(std::isfinite(value.error) ? value.error : 0))};
}

std::string csv_row(const Result& result, std::size_t effect, std::size_t noise, std::size_t stage, int frame) {
  const MeanAndError value = result.rmse(effect, noise, stage, frame);
  const double ratio = result.over_white(effect, noise, stage, frame);
  const double predicted = result.prediction(noise, stage).value_or(std::nan(""));
  const auto number = [](double v) { return std::isfinite(v) ? fmt::format("{:.9g}", v) : std::string(); };
  std::string row = fmt::format("{},{},{},{},{},{},{},{},{}", name_of(result.effects[effect]), result.noises[noise],
                                result.stages[stage].time, result.stages[stage].space, frame + 1, number(value.mean),
                                number(value.error), number(ratio), number(predicted));
  for (const Metric metric : std::span(result.metrics).subspan(1))
    row += "," + number(result.value(metric, effect, noise, stage, frame).mean);
  return row + "\n";
}

std::string csv_head(const Result& result) {
  std::string head = "effect,noise,time,space,frame,rmse,standard_error,over_white,predicted";
  for (const Metric metric : std::span(result.metrics).subspan(1)) head += fmt::format(",{}", name_of(metric));
  return head + "\n";
}

std::size_t width_of_names(const Result& result) {
  std::size_t widest = 5;
  for (const std::string& noise : result.noises) widest = std::max(widest, noise.size());
  return widest;
}

std::size_t width_of_stage(const Stage& stage) { return std::max<std::size_t>(19, stage.to_string().size()); }

// A line for each noise, a column for each stage.
template <class Cell>
std::string table_text(const Result& result, Cell cell) {
  const std::size_t names = width_of_names(result);
  std::string text = fmt::format("  {:<{}}", "", names);
  for (const Stage& stage : result.stages) text += fmt::format("  {:>{}}", stage.to_string(), width_of_stage(stage));
  text += "\n";
  for (std::size_t noise = 0; noise < result.noises.size(); ++noise) {
    text += fmt::format("  {:<{}}", result.noises[noise], names);
    for (std::size_t stage = 0; stage < result.stages.size(); ++stage)
      text += fmt::format("  {:>{}}", cell(noise, stage), width_of_stage(result.stages[stage]));
    text += "\n";
  }
  return text;
}

}  // namespace

std::string title_of(Metric metric) {
  switch (metric) {
    case Metric::rmse:
      return "root of the mean squared error";
    case Metric::deviation:
      return "deviation of the error around its own mean";
    case Metric::ssim:
      return "1 - structural similarity";
    case Metric::low:
      return "error at frequencies below 0.05 cycles a pixel";
    case Metric::middle:
      return "error at frequencies from 0.05 to 0.15 cycles a pixel";
    case Metric::high:
      return "error at frequencies above 0.15 cycles a pixel";
    case Metric::unseen:
      return "share of pixels that no frame has sampled";
    case Metric::pattern:
      return "1 - rank correlation of the error with the mask that seeds follow";
    case Metric::flip:
      return "FLIP";
    case Metric::median:
      return "median of the pixels' errors";
    case Metric::p99:
      return "what the errors of 99 % of the pixels stay below";
    case Metric::largest:
      return "largest error of a pixel";
  }
  return {};
}

double Result::square(std::size_t effect, std::size_t noise, int repeat, std::size_t stage, int frame) const {
  return squares[place(effect, noise, repeat, stage, frame)];
}

std::size_t Result::place(std::size_t effect, std::size_t noise, int repeat, std::size_t stage, int frame) const {
  const std::size_t job =
      (effect * noises.size() + noise) * static_cast<std::size_t>(repeats) + static_cast<std::size_t>(repeat);
  return (job * stages.size() + stage) * static_cast<std::size_t>(frames) + static_cast<std::size_t>(frame);
}

std::size_t Result::num_times() const {
  return static_cast<std::size_t>(
      std::count_if(stages.begin(), stages.end(), [](const Stage& stage) { return stage.space == "none"; }));
}

double Result::of_repeat(Metric metric, std::size_t effect, std::size_t noise, int repeat, std::size_t stage,
                         int frame) const {
  const auto found = std::find(metrics.begin(), metrics.end(), metric) - metrics.begin();
  const std::vector<double>& all = found == 0 ? squares : further.at(static_cast<std::size_t>(found - 1));
  return all[place(effect, noise, repeat, stage, frame)];
}

MeanAndError Result::rmse(std::size_t effect, std::size_t noise, std::size_t stage, int frame) const {
  return value(Metric::rmse, effect, noise, stage, frame);
}

MeanAndError Result::value(Metric metric, std::size_t effect, std::size_t noise, std::size_t stage, int frame) const {
  std::vector<double> values;
  for (int repeat = 0; repeat < repeats; ++repeat)
    values.push_back(of_repeat(metric, effect, noise, repeat, stage, frame));
  const MeanAndError mean = mean_and_error(values);
  if (!is_root(metric)) return mean;
  const double root = std::sqrt(mean.mean);
  return {root, root > 0 ? mean.error / (2 * root) : repeats < 2 ? mean.error : 0};
}

double Result::over_white(std::size_t effect, std::size_t noise, std::size_t stage, int frame) const {
  if (!white) return std::nan("");
  const double below = rmse(effect, *white, stage, frame).mean;
  return below > 0 ? rmse(effect, noise, stage, frame).mean / below : std::nan("");
}

std::optional<double> Result::prediction(std::size_t noise, std::size_t stage) const {
  return predictions.empty() ? std::nullopt : predictions[noise * stages.size() + stage];
}

std::vector<ExpectationResult> check_expectations(const Scene& scene, const Result& result) {
  std::vector<ExpectationResult> results;
  for (const ExpectSpec& expect : scene.expects) {
    results.push_back(expect.order.empty() ? check_value(expect, result) : check_order(expect, result));
    if (!expect.source.empty()) results.back().text = expect.source + ": " + results.back().text;
  }
  return results;
}

std::string results_text(const Result& result) {
  std::string text;
  for (std::size_t effect = 0; effect < result.effects.size(); ++effect) {
    for (const Metric metric : result.metrics) {
      if (metric == Metric::unseen && result.effects[effect] != Effect::sparse) continue;
      text +=
          fmt::format("{}{}, {} in frame {}{}\n", metric == Metric::rmse ? "" : "\n", name_of(result.effects[effect]),
                      title_of(metric), result.frames, result.repeats > 1 ? " (standard error)" : "");
      text += table_text(result, [&](std::size_t noise, std::size_t stage) {
        const MeanAndError value = result.value(metric, effect, noise, stage, result.frames - 1);
        return digits_text(value.mean) +
               (std::isfinite(value.error) ? fmt::format(" ({})", digits_text(value.error)) : std::string());
      });
    }
    const double* const biases = result.bias.data() + effect * result.stages.size();
    std::string bias = fmt::format("  {:<{}}", "bias", width_of_names(result));
    for (std::size_t stage = 0; stage < result.stages.size(); ++stage)
      bias += fmt::format("  {:>{}}", digits_text(biases[stage]), width_of_stage(result.stages[stage]));
    text += std::isnan(biases[0]) ? "" : bias + "\n";
    if (std::isnan(result.over_white(effect, 0, 0, result.frames - 1))) continue;
    text += fmt::format("\n{}, over the error of white noise{}\n", name_of(result.effects[effect]),
                        result.predictions.empty() ? "" : " [as the score of the texture promises]");
    text += table_text(result, [&](std::size_t noise, std::size_t stage) {
      const auto predicted = result.prediction(noise, stage);
      return fmt::format("{:.3f}", result.over_white(effect, noise, stage, result.frames - 1)) +
             (predicted ? fmt::format(" [{:.3f}]", *predicted) : std::string());
    });
    text += "\n";
  }
  if (std::all_of(result.bias.begin(), result.bias.end(), [](double bias) { return std::isnan(bias); })) return text;
  return text +
         "bias: how far filters (and the steps of a march) take the mean from the converged truth, whatever the "
         "noise;\n"
         "no part of the errors.\n";
}

std::string results_csv(const Result& result) {
  std::string text = csv_head(result);
  for (std::size_t effect = 0; effect < result.effects.size(); ++effect)
    for (std::size_t noise = 0; noise < result.noises.size(); ++noise)
      for (std::size_t stage = 0; stage < result.stages.size(); ++stage)
        text += csv_row(result, effect, noise, stage, result.frames - 1);
  return text;
}

std::string curves_csv(const Result& result) {
  std::string text = csv_head(result);
  for (std::size_t effect = 0; effect < result.effects.size(); ++effect)
    for (std::size_t noise = 0; noise < result.noises.size(); ++noise)
      for (std::size_t stage = 0; stage < result.stages.size(); ++stage)
        for (int frame = 0; frame < result.frames; ++frame) text += csv_row(result, effect, noise, stage, frame);
  return text;
}

}  // namespace noiseloom::render
