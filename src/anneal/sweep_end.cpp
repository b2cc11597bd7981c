// The end of a sweep: R is evaluated where it is due, a row is added to the history, and the run goes on or not.
//
// What the history holds and when the run ends follow from the problem alone (with stop.time: from rank 0's clock). R
// is also evaluated for people to see; that follows the clock, and decides nothing.
#include <algorithm>
#include <chrono>

#include "anneal/swap_optimizer_impl.h"
#include "anneal/texture_score.h"
#include "noiseloom/anneal/swap_choices.h"

namespace noiseloom {
namespace {

// R is evaluated for show after so many seconds, or as seldom as costs a fortieth of the run.
constexpr double score_shown_every_s = 1;
constexpr double score_share = 40;

}  // namespace

void SwapOptimizer::Impl::score(Exactness wanted, double seconds) {
  const auto begun = std::chrono::steady_clock::now();
  score_is_exact = wanted == Exactness::exact || !float_score;
  slices.hear();
  state.relative_error = texture_error(score_footprint, source, state.mean_distance, slices,
                                       score_is_exact ? nullptr : &*float_score, communicator, pool);
  state.scored_iterations = state.iterations;
  state.scored_step = state.step;
  last_score_s = seconds;
  (score_is_exact ? exact_score_took_s : quick_score_took_s) =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - begun).count();
}

bool SwapOptimizer::Impl::score_is_wanted(double seconds) const {
  return seconds - last_score_s >= std::max(score_shown_every_s, score_share * quick_score_s());
}

// A run of `fast` by iterations may be extended (run/resume.h), and must then have the rows of one that had the later
// end from its start: so these follow from the sweep alone.
bool SwapOptimizer::Impl::row_is_planned(const Schedule& rounds, const Moment& moment) const {
  const std::int64_t judged_taps =
      movers.use_features() ? std::ssize(energy_footprint.slices()[0].taps) : energy_footprint.num_taps();
  const double worth =
      iterations_per_score(source.distance(), score_footprint.num_taps(), float_score.has_value(), judged_taps);
  if (optimizer.method == Method::fast && optimizer.stop.iterations > 0) {
    return score_due_without_end(moment.sweep_in_round + 1, score_interval(worth));
  }
  return score_due(moment, scores_per_round(worth, rounds.iterations_of_round(moment)));
}

// With stop.time: whether the last score is all that there is time for.
bool SwapOptimizer::Impl::is_out_of_time(double seconds) const {
  if (optimizer.stop.time_s <= 0) return false;
  const double end = seconds + std::max(0.0, exact_score_took_s);
  return communicator.broadcast(end) >= optimizer.stop.time_s;
}

// Of a sweep that is cut short, as many as its slices that were visited come to, rounded up.
std::int64_t SwapOptimizer::Impl::iterations_at(std::int64_t sweep, std::int64_t step) const {
  const std::int64_t before = schedule.iterations_before(sweep);
  const std::int64_t of_sweep = schedule.iterations_before(sweep + 1) - before;
  std::int64_t visited = 0;
  for (std::int64_t k = 0; k < step; ++k) visited += std::ssize(classes[static_cast<std::size_t>(k)]);
  const std::int64_t num_slices = problem.extents.num_slices();
  return before + (of_sweep * visited + num_slices - 1) / num_slices;
}

// Where `state.step` is not past the last class the sweep is cut short; its number counts all the same.
void SwapOptimizer::Impl::end_sweep(double seconds) {
  const Moment moment = this->moment();
  const bool wanted = communicator.is_root() && score_is_wanted(seconds);
  std::int64_t sums[] = {own_accepted + state.accepted, own_candidates + state.candidates, wanted ? 1 : 0};
  communicator.sum(sums);
  candidates_done += own_candidates;
  own_accepted = own_candidates = state.accepted = state.candidates = 0;
  state.iterations = iterations_at(state.sweep, state.step);
  ++state.sweep;
  state.step = 0;
  figures.temperature = optimizer.method == Method::fast ? state.fraction : state.temperature;
  figures.acceptance = sums[1] > 0 ? static_cast<double>(sums[0]) / static_cast<double>(sums[1]) : 0;
  adapt_fraction(sums[0], moment);

  const double limit_s = optimizer.stop.time_s;
  double now = seconds;
  bool out_of_time = false;
  bool row_is_due = false;
  if (limit_s > 0) {
    now = communicator.broadcast(seconds);
    out_of_time = is_out_of_time(seconds);
    const double score_s = communicator.broadcast(quick_score_s());
    row_is_due = out_of_time || now - state.history.back().seconds >= std::max(limit_s / 50, score_share * score_s);
  } else {
    row_is_due = moment.ends_round() || row_is_planned(schedule, moment);
  }
  if (row_is_due || sums[2] > 0) score(Exactness::quick, now);
  if (!row_is_due) return;
  // What the run ends with, and what a round is judged by.
  const bool may_end = out_of_time || moment.ends_round() || state.relative_error <= optimizer.stop.score;
  if (may_end && !score_is_exact) score(Exactness::exact, now);
  add_row(now);
  state.finished = out_of_time ? ended::by_time : schedule.ended_by(moment, state.relative_error, state.round_score);
  if (moment.ends_round()) state.round_score = state.relative_error;
  if (!state.finished.empty()) keep_the_better();
}

// Copies of slices of other ranks stay as they are: nothing moves any more.
void SwapOptimizer::Impl::keep_the_better() {
  if (state.is_given == 0 || state.relative_error < state.given_error) return;
  slices.put_back(source,
                  [&](SliceIndex slice) { return given[slices.distribution().local_slice_from_global(slice)]; });
  state.given_kept = 1;
  state.relative_error = state.history.back().relative_error = state.given_error;
}

void SwapOptimizer::Impl::add_row(double seconds) {
  state.history.push_back({static_cast<double>(state.sweep), static_cast<double>(state.iterations), figures.temperature,
                           figures.acceptance, state.relative_error, seconds});
}

// The paper's rule: gamma doubles when fewer than gamma / 4 of all pairs were swapped. Swaps double with gamma, so a
// rule that is looked at every sweep takes gamma to 1 in three, and the pairs that then swap together drive R up
// without end.
void SwapOptimizer::Impl::adapt_fraction(std::int64_t accepted, const Moment& moment) {
  if (optimizer.method != Method::fast || !optimizer.grow_fraction) return;
  if (state.sweep % sweeps_per_fraction(moment.round_length) != 0) return;
  const double pairs = static_cast<double>(problem.extents.num_cells()) / 2;
  if (static_cast<double>(accepted) < state.fraction / 4 * pairs) state.fraction = std::min(1.0, 2 * state.fraction);
}

}  // namespace noiseloom
