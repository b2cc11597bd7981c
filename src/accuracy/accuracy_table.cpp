#include "noiseloom/accuracy/accuracy_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "noiseloom/core/error.h"

namespace noiseloom {
namespace {

// Below these, one point is not clearly shorter, or lower in R, than another; nor where their runs overlap in R.
constexpr double clear_seconds = 0.1;
constexpr double clear_error = 0.005;

constexpr double near_the_best = 0.05;
constexpr double too_far_to_tell = 0.5;  // of the next best run: nothing is then known of the last per cents

std::string percent(double fraction) {
  const double value = 100 * fraction;
  return fmt::format("{} %", value < 9.95 ? fmt::format("{:.2g}", value) : fmt::format("{:.0f}", value));
}

std::string times(double ratio) { return ratio < 9.95 ? fmt::format("{:.2g}", ratio) : fmt::format("{:.3g}", ratio); }

std::string error_text(double r) { return fmt::format("R = {:.4f}", r); }
std::string error_text(const AccuracyRow& row) { return "R = " + error_with_spread(row); }

std::string default_against_best(const AccuracyRow& standard, const AccuracyRow& best) {
  if (&standard == &best)
    return fmt::format(
        "The default ({}) is the best that was measured: {} in {}. Whether more iterations pay, a longer budget shows.",
        describe_row(standard), error_text(standard), seconds_text(standard.seconds));
  return fmt::format(
      "The default ({}) leaves {} after {}; the best that was measured ({}) leaves {}, {}, for {} times "
      "the seconds.",
      describe_row(standard), error_text(standard), seconds_text(standard.seconds), describe_row(best),
      error_text(best), difference_text(best.relative_error / standard.relative_error),
      times(best.seconds / standard.seconds));
}

// The front by rising seconds, and so falling R.
std::vector<const AccuracyRow*> front_in_order(const std::vector<AccuracyRow>& rows) {
  const std::vector<bool> on_front = pareto_front(rows);
  std::vector<const AccuracyRow*> front;
  for (std::size_t i = 0; i < rows.size(); ++i)
    if (on_front[i]) front.push_back(&rows[i]);
  std::sort(front.begin(), front.end(),
            [](const AccuracyRow* a, const AccuracyRow* b) { return a->seconds < b->seconds; });
  return front;
}

// "The last 4.3 % of error cost 50 % of the time", from the cheapest run that is nearly as good as the best; where none
// is, from the one before the best.
std::string price_of_the_last(const std::vector<AccuracyRow>& rows, const AccuracyRow& best) {
  const std::vector<const AccuracyRow*> front = front_in_order(rows);
  if (front.size() < 2 || front.back()->relative_error <= 0) return "";
  const AccuracyRow* enough = front[front.size() - 2];
  for (const AccuracyRow* row : front)
    if (row->relative_error <= best.relative_error * (1 + near_the_best)) {
      if (row != front.back()) enough = row;
      break;
    }
  if (enough->relative_error > best.relative_error * (1 + too_far_to_tell)) return "";
  return fmt::format("The last {} of error cost {} of the time: {} is reached after {} ({}), {} after {}.",
                     percent(enough->relative_error / best.relative_error - 1),
                     percent(1 - enough->seconds / best.seconds), error_text(*enough), seconds_text(enough->seconds),
                     describe_row(*enough), error_text(best), seconds_text(best.seconds));
}

std::string default_against_front(const std::vector<AccuracyRow>& rows, const AccuracyRow& standard) {
  const AccuracyRow* better = nullptr;
  for (const AccuracyRow& row : rows) {
    const bool same_line = row.point.method == standard.point.method && !row.point.is_knob();
    if (same_line && row.iterations > standard.iterations) continue;  // more of the same in less time: a noisy clock
    if (row.seconds <= standard.seconds * (1 - clear_seconds) &&
        row.relative_error <= standard.relative_error * (1 - clear_error) && row.largest_error < standard.least_error &&
        (better == nullptr || row.relative_error < better->relative_error))
      better = &row;
  }
  if (better == nullptr) return "Nothing that was measured is clearly both shorter and better than the default.";
  return fmt::format("The default is not the best use of its time: {} leaves {} after {}.", describe_row(*better),
                     error_text(*better), seconds_text(better->seconds));
}

// The run of the method with the least R; nullptr where it has none.
const AccuracyRow* best_of(const std::vector<AccuracyRow>& rows, Method method) {
  const AccuracyRow* best = nullptr;
  for (const AccuracyRow& row : rows)
    if (row.point.method == method && (best == nullptr || row.relative_error < best->relative_error)) best = &row;
  return best;
}

// "; anneal has R = 0.12 after 3.0 s." of its shortest run that is as low.
std::string against_anneal(const std::vector<AccuracyRow>& rows, double relative_error) {
  const AccuracyRow* anneal = nullptr;
  for (const AccuracyRow& row : rows)
    if (row.point.method == Method::anneal && row.relative_error <= relative_error &&
        (anneal == nullptr || row.seconds < anneal->seconds))
      anneal = &row;
  if (anneal != nullptr)
    return fmt::format("; anneal has {} after {}.", error_text(*anneal), seconds_text(anneal->seconds));
  return best_of(rows, Method::anneal) == nullptr ? "." : "; no run of anneal comes as low.";
}

std::string fast_compared(const std::vector<AccuracyRow>& rows) {
  const AccuracyRow* const fast = best_of(rows, Method::fast);
  if (fast == nullptr) return "";
  std::string text = fmt::format("The paper's method (fast) comes to {} at best, after {}", error_text(*fast),
                                 seconds_text(fast->seconds));
  const AccuracyRow* longest = fast;
  for (const AccuracyRow& row : rows)
    if (row.point.method == Method::fast && row.iterations > longest->iterations) longest = &row;
  if (longest->relative_error > fast->relative_error * (1 + near_the_best))
    text += fmt::format(" (more iterations make it worse: {} after {})", error_text(*longest), longest->iterations);
  return text + against_anneal(rows, fast->relative_error);
}

// A method without iterations has one point.
std::string single_compared(const std::vector<AccuracyRow>& rows, Method method) {
  const AccuracyRow* const row = best_of(rows, method);
  if (row == nullptr) return "";
  return fmt::format("{} has {} after {}", method_name(method), error_text(*row), seconds_text(row->seconds)) +
         against_anneal(rows, row->relative_error);
}

std::string bits_compared(const AccuracyRow& row) {
  if (!row.r_8bit || !row.r_16bit || row.relative_error <= 0)
    return "These samples have no natural bounds, so nothing is said of 8 and 16 bit: their range is the exporter's "
           "choice.";
  return fmt::format("Stored in 8 bits the best leaves {} ({}), in 16 bits {} ({}).", error_text(*row.r_8bit),
                     difference_text(*row.r_8bit / row.relative_error), error_text(*row.r_16bit),
                     difference_text(*row.r_16bit / row.relative_error));
}

}  // namespace

void AccuracyRow::add(const AccuracyRun& run) {
  const auto mean = [&](double before, double value) { return before + (value - before) / (runs + 1); };
  const auto mean_if_all = [&](std::optional<double>& before, const std::optional<double>& value) {
    if (runs == 0) {
      before = value;
    } else if (before && value) {
      before = mean(*before, *value);
    } else {
      before.reset();
    }
  };
  mean_if_all(r_8bit, run.r_8bit);
  mean_if_all(r_16bit, run.r_16bit);
  seconds = mean(seconds, run.seconds);
  relative_error = mean(relative_error, run.relative_error);
  least_error = runs == 0 ? run.relative_error : std::min(least_error, run.relative_error);
  largest_error = runs == 0 ? run.relative_error : std::max(largest_error, run.relative_error);
  ++runs;
}

std::vector<TimedPoint> timed(const std::vector<AccuracyRow>& rows, int runs) {
  std::vector<TimedPoint> points;
  for (const AccuracyRow& row : rows) points.push_back({row.point, row.seconds * runs, row.relative_error});
  return points;
}

std::vector<bool> pareto_front(const std::vector<AccuracyRow>& rows) {
  std::vector<bool> front;
  for (const AccuracyRow& row : rows)
    front.push_back(std::none_of(rows.begin(), rows.end(), [&](const AccuracyRow& other) {
      const bool as_good = other.seconds <= row.seconds && other.relative_error <= row.relative_error;
      return as_good && (other.seconds < row.seconds || other.relative_error < row.relative_error);
    }));
  return front;
}

const AccuracyRow* default_row(const std::vector<AccuracyRow>& rows) {
  const auto found =
      std::find_if(rows.begin(), rows.end(), [](const AccuracyRow& row) { return row.point.is_default; });
  return found == rows.end() ? nullptr : &*found;
}

const AccuracyRow* best_row(const std::vector<AccuracyRow>& rows) {
  const auto best = std::min_element(rows.begin(), rows.end(), [](const AccuracyRow& a, const AccuracyRow& b) {
    return a.relative_error != b.relative_error ? a.relative_error < b.relative_error : a.seconds < b.seconds;
  });
  return best == rows.end() ? nullptr : &*best;
}

const AccuracyRow* base_row(const std::vector<AccuracyRow>& rows, const AccuracyRow& knob) {
  const auto found = std::find_if(rows.begin(), rows.end(), [&](const AccuracyRow& row) {
    return !row.point.is_knob() && row.point.method == knob.point.method && row.point.iterations > 0 &&
           row.point.iterations == knob.point.iterations;
  });
  return found == rows.end() ? nullptr : &*found;
}

std::string error_with_spread(const AccuracyRow& row) {
  const std::string mean = fmt::format("{:.4f}", row.relative_error);
  return row.runs < 2 ? mean : fmt::format("{} ({:.4f} to {:.4f})", mean, row.least_error, row.largest_error);
}

std::string describe_row(const AccuracyRow& row) {
  AccuracyPoint point = row.point;
  point.iterations = row.iterations;
  return describe_point(point);
}

std::string difference_text(double ratio) {
  if (!std::isfinite(ratio)) return "not comparable";
  if (std::abs(ratio - 1) < 0.0005) return "the same";
  if (ratio >= 2) return times(ratio) + " times as much";
  return fmt::format("{} {}", percent(std::abs(ratio - 1)), ratio > 1 ? "more" : "less");
}

std::vector<std::string> accuracy_sentences(const std::vector<AccuracyRow>& rows) {
  NOISELOOM_CHECK(!rows.empty());
  const AccuracyRow& best = *best_row(rows);
  const AccuracyRow* const standard = default_row(rows);
  std::vector<std::string> sentences{price_of_the_last(rows, best)};
  sentences.push_back(standard != nullptr
                          ? default_against_best(*standard, best)
                          : fmt::format("The default did not run; the best that was measured ({}) leaves {} after {}.",
                                        describe_row(best), error_text(best), seconds_text(best.seconds)));
  if (standard != nullptr && standard != &best) sentences.push_back(default_against_front(rows, *standard));
  sentences.push_back(fast_compared(rows));
  for (const Method method : {Method::construct, Method::void_and_cluster})
    sentences.push_back(single_compared(rows, method));
  sentences.push_back(bits_compared(best));
  std::erase(sentences, "");
  return sentences;
}

}  // namespace noiseloom
