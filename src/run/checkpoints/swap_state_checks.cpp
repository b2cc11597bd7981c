#include "run/checkpoints/swap_state_checks.h"

#include <fmt/format.h>

#include <cmath>

#include "noiseloom/anneal/schedule.h"

namespace noiseloom {
namespace {

void check_progress(const SwapState& state, const RunConfig& config, ContentFaults& faults) {
  const StopSpec& stop = config.optimizer.stop;
  const bool finished = !state.finished.empty();
  const auto require = [&](bool sound, const char* name, const auto& value, const char* must) {
    faults.require(sound, fmt::format("/state/@{} = {}: {}", name, value, must));
  };
  const bool is_rule =
      (state.finished == ended::by_iterations && stop.iterations > 0) ||
      (state.finished == ended::by_time && stop.time_s > 0) || (state.finished == ended::by_score && stop.score > 0) ||
      (state.finished == ended::out_of_reach && stop.score > 0) ||
      (state.finished == ended::by_improvement && stop.improvement > 0) || state.finished == ended::nothing_to_swap;
  require(!finished || is_rule, "finished", state.finished, "must be empty or the stop rule of its config");
  const std::int64_t most_iterations = stop.iterations > 0 ? stop.iterations : std::int64_t{1} << 40;
  const std::int64_t most_sweeps = stop.iterations > 0 ? stop.iterations : std::int64_t{1} << 31;
  require(state.sweep >= 0 && state.sweep <= most_sweeps, "sweep", state.sweep,
          "must be a number of sweeps that its stop rule can reach");
  require(state.step >= 0 && state.step < config.problem.extents.num_slices() && (state.step == 0 || !finished), "step",
          state.step, "must count the steps of a sweep that is under way");
  require(state.iterations >= 0 && state.iterations <= most_iterations, "iterations", state.iterations,
          "must be a number of iterations that its stop rule can reach");
  require(state.scored_iterations >= 0 && state.scored_iterations <= state.iterations, "scored_iterations",
          state.scored_iterations, "must be some of the iterations");
  require(state.scored_step >= 0 && state.scored_step < config.problem.extents.num_slices(), "scored_step",
          state.scored_step, "must be a step of a sweep");
  // A visit makes at most a few dozen candidates for each pixel.
  const double most_candidates = 64 * static_cast<double>(config.problem.extents.num_cells());
  require(state.candidates >= 0 && static_cast<double>(state.candidates) <= most_candidates &&
              (state.candidates == 0 || state.step > 0),
          "candidates", state.candidates, "must be those of a sweep that is under way");
  require(state.accepted >= 0 && state.accepted <= state.candidates, "accepted", state.accepted,
          "must be some of the candidates");
}

void check_numbers(const SwapState& state, ContentFaults& faults) {
  const auto require = [&](bool sound, const char* name, double value, const char* must) {
    faults.require(sound, fmt::format("/state/@{} = {}: {}", name, value, must));
  };
  const auto positive_or_zero = [&](const char* name, double value) {
    require(is_finite_positive_or_zero(value), name, value, "must be a finite number from 0 on");
  };
  positive_or_zero("temperature", state.temperature);
  positive_or_zero("elapsed_s", state.elapsed_s);
  positive_or_zero("mean_magnitude", state.mean_magnitude);
  positive_or_zero("mean_distance", state.mean_distance);
  require(state.fraction > 0 && state.fraction <= 1, "fraction", state.fraction, "must be above 0 and at most 1");
  require(std::isfinite(state.relative_error), "relative_error", state.relative_error, "must be finite");
  require(std::isfinite(state.round_score), "round_score", state.round_score, "must be finite");
  positive_or_zero("begun_s", state.begun_s);
  require(state.join >= 0 && state.join <= 1, "join", state.join, "must be from 0 to 1");
  require(std::isfinite(state.given_error), "given_error", state.given_error, "must be finite");
}

// What goes with an arrangement that the run began with.
void check_given(const SwapState& state, const RunConfig& config, ContentFaults& faults) {
  const auto require = [&](bool sound, const char* name, const auto& value, const char* must) {
    faults.require(sound, fmt::format("/state/@{} = {}: {}", name, value, must));
  };
  const bool wanted = begins_with_arrangement(config);
  require(state.is_given == (wanted ? 1 : 0), "is_given", state.is_given,
          wanted ? "must be 1, as its config has the run begin with an arrangement"
                 : "must be 0, as its config has the run begin at random");
  const auto flag = [&](const char* name, std::int64_t value) {
    require(value == 0 || (value == 1 && state.is_given == 1), name, value, "must be 0, or 1 with an arrangement");
  };
  flag("is_cold", state.is_cold);
  flag("given_kept", state.given_kept);
  require(state.given_kept == 0 || !state.finished.empty(), "given_kept", state.given_kept,
          "must be 0 until the run is finished");
}

void check_rows(const SwapState& state, const RunConfig& config, ContentFaults& faults) {
  const StopSpec& stop = config.optimizer.stop;
  const double most_iterations = stop.iterations > 0 ? static_cast<double>(stop.iterations) : 0x1p53;
  double least_sweep = 0;
  double least_iterations = 0;
  for (std::size_t index = 0; index < state.history.size(); ++index) {
    const HistoryRow& row = state.history[index];
    const auto require = [&](bool sound, const char* column, double value, const char* must) {
      faults.require(sound, fmt::format("/history/{}, row {} = {}: {}", column, index, value, must));
    };
    const bool first = index == 0;
    require(is_count(row.sweep, least_sweep, first ? 0 : static_cast<double>(state.sweep)), "sweep", row.sweep,
            "must count the sweeps from 0 on, each row more, up to those of /state");
    require(is_count(row.iterations, least_iterations, first ? 0 : most_iterations), "iterations", row.iterations,
            "must count the iterations from 0 on, each row more");
    require(is_finite_positive_or_zero(row.temperature), "temperature", row.temperature,
            "must be a finite number from 0 on");
    require(row.acceptance >= 0 && row.acceptance <= 1, "acceptance", row.acceptance, "must be from 0 to 1");
    require(std::isfinite(row.relative_error), "relative_error", row.relative_error, "must be finite");
    require(is_finite_positive_or_zero(row.seconds), "seconds", row.seconds, "must be a finite number from 0 on");
    least_sweep = row.sweep + 1;
    least_iterations = row.iterations + 1;
  }
  const bool at_end = !state.history.empty() && state.history.back().sweep == static_cast<double>(state.sweep);
  faults.require(state.finished.empty() || at_end,
                 fmt::format("/state/@sweep = {}: the run is finished, so it must be that of the last row of /history",
                             state.sweep));
}

}  // namespace

void check_swap_state(const SwapState& state, const RunConfig& config, ContentFaults& faults) {
  check_progress(state, config, faults);
  check_numbers(state, faults);
  check_given(state, config, faults);
  check_rows(state, config, faults);
}

}  // namespace noiseloom
