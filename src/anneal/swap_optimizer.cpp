#include "noiseloom/anneal/swap_optimizer.h"

#include "anneal/swap_optimizer_impl.h"
#include "anneal/texture_score.h"
#include "noiseloom/anneal/swap_choices.h"

namespace noiseloom {
namespace {

// What the slice that is visited first says about the size of dE.
constexpr std::int64_t magnitude_candidates = 4096;

}  // namespace

SwapOptimizer::Impl::Impl(const ProblemSpec& p, const OptimizerSpec& o, const SampleSource& s, const Communicator& c,
                          ThreadPool& t)
    : problem(p),
      optimizer(o),
      source(s),
      communicator(c),
      pool(t),
      score_footprint(p.extents, p.filter),
      energy_footprint(p.extents, p.filter, energy_cutoff(o)),
      kernel(make_value_kernel(p, s.channels(), s.distance())),
      layout(energy_footprint, s.channels()),
      classes(classes_for(o.method, energy_footprint)),
      tiles(tiles_for(o, energy_footprint, classes)),
      members_are_coupled(o.method == Method::fast ||
                          (energy_footprint.couples_slices() && classes.front().size() > 1)),
      movers(o, energy_footprint, kernel, s, tiles.window(), t.num_threads()),
      schedule(o.stop, visit_length(o, p.extents.num_cells(), movers.use_features(), movers.use_sieve())),
      slices(score_footprint, layout, c, t) {
  if (FloatScore::fits(score_footprint, s.distance(), layout))
    float_score.emplace(score_footprint, s.distance(), layout);
}

// Mean |dE| in slice 0 at the start, the same on every rank.
double SwapOptimizer::Impl::mean_magnitude() {
  double magnitude = 0;
  constexpr SliceIndex first;
  if (slices.owns(first)) {
    const Visit visit{first, 0, problem.seed, 1, 0, tiles.num_tiles(), tiles.corner(problem.seed, first, 0, 0)};
    magnitude = movers.mean_magnitude(visit, magnitude_candidates, slices.field(first), slices.permutation(first),
                                      slices.fields());
  }
  return communicator.broadcast(magnitude);  // the first slice is always rank 0's
}

SwapOptimizer::SwapOptimizer(const ProblemSpec& problem, const OptimizerSpec& optimizer, const SampleSource& source,
                             const Communicator& communicator, ThreadPool& pool)
    : impl_(std::make_unique<Impl>(problem, optimizer, source, communicator, pool)) {}

SwapOptimizer::~SwapOptimizer() = default;

void SwapOptimizer::start() {
  const ProblemSpec& problem = impl_->problem;
  impl_->slices.fill(impl_->source, [&](SliceIndex slice) {
    return start_permutation(problem.seed, slice, problem.extents.cells_per_slice());
  });
  if (impl_->optimizer.method == Method::anneal) impl_->state.mean_magnitude = impl_->mean_magnitude();
  impl_->score_start(0);
}

void SwapOptimizer::start_from(const PermutationOf& permutation, double seconds) {
  NOISELOOM_CHECK(impl_->optimizer.method == Method::anneal);
  // The unit of temperature is that of the problem, whatever its arrangement.
  const ProblemSpec& problem = impl_->problem;
  impl_->slices.fill(impl_->source, [&](SliceIndex slice) {
    return start_permutation(problem.seed, slice, problem.extents.cells_per_slice());
  });
  SwapState& state = impl_->state;
  state.mean_magnitude = impl_->mean_magnitude();
  impl_->slices.fill(impl_->source, permutation);
  impl_->keep_given([&](SliceIndex slice) { return impl_->slices.permutation(slice); });
  state.is_given = 1;
  state.begun_s = impl_->communicator.broadcast(seconds);
  impl_->score_start(state.begun_s);
  score_now();
  state.given_error = state.history.back().relative_error = state.relative_error;
  const double limit_s = impl_->optimizer.stop.time_s;
  if (limit_s > 0 && state.finished.empty() && state.begun_s >= limit_s) state.finished = ended::by_time;
}

void SwapOptimizer::join_schedule(double fraction, double seconds) {
  NOISELOOM_CHECK(impl_->state.sweep == 0 && impl_->state.step == 0);
  impl_->state.join = impl_->communicator.broadcast(fraction);
  impl_->state.begun_s = impl_->communicator.broadcast(seconds);
}

void SwapOptimizer::join_cold(double seconds) {
  NOISELOOM_CHECK(impl_->state.sweep == 0 && impl_->state.step == 0);
  impl_->state.is_cold = 1;
  impl_->state.begun_s = impl_->communicator.broadcast(seconds);
  impl_->schedule = Schedule(impl_->optimizer.stop, iterations_per_sweep(true));
}

std::int64_t SwapOptimizer::iterations_per_sweep(bool cold) const {
  const bool features = impl_->movers.use_features();
  const bool sieve = impl_->movers.use_sieve();
  const std::int64_t cells = impl_->problem.extents.num_cells();
  return cold ? cold_visit_length(impl_->optimizer, cells, features, sieve)
              : visit_length(impl_->optimizer, cells, features, sieve);
}

void SwapOptimizer::Impl::keep_given(const PermutationOf& permutation) {
  given = IndexedVector<LocalSlice, Permutation>(static_cast<std::size_t>(slices.num_own()));
  for (const SliceIndex slice : slices.distribution().own_slices()) {
    given[slices.distribution().local_slice_from_global(slice)] = permutation(slice);
  }
}

void SwapOptimizer::Impl::score_start(double seconds) {
  state.mean_distance = mean_distance(source, communicator, pool);
  state.fraction = optimizer.fraction;
  const StopSpec& stop = optimizer.stop;
  // A run that must end in time has to know how long its last score will take.
  score(stop.time_s > 0 ? Exactness::exact : Exactness::quick, seconds);
  // A run ends by the exact score alone, its start included.
  if (stop.score > 0 && state.relative_error <= stop.score && !score_is_exact) score(Exactness::exact, seconds);
  add_row(seconds);
  if (stop.iterations > 0) return;
  const bool can_swap = problem.extents.cells_per_slice() > 1 && state.mean_distance > 0;
  if (!can_swap) state.finished = ended::nothing_to_swap;
  if (stop.score > 0 && state.relative_error <= stop.score) state.finished = ended::by_score;
}

void SwapOptimizer::restore(const SwapState& state, const PermutationOf& permutation, const PermutationOf& given) {
  impl_->state = state;
  impl_->schedule = Schedule(impl_->optimizer.stop, iterations_per_sweep(state.is_cold != 0));
  impl_->state.iterations = state.finished.empty() ? impl_->schedule.iterations_before(state.sweep)
                                                   : static_cast<std::int64_t>(state.history.back().iterations);
  // Counts of the present sweep live on one rank, so that their sum stays what it was.
  if (!impl_->communicator.is_root()) impl_->state.accepted = impl_->state.candidates = 0;
  impl_->slices.fill(impl_->source, permutation);
  if (state.is_given != 0) impl_->keep_given(given);
  impl_->prepare_movers();
  impl_->score_is_exact = !impl_->float_score;  // the state does not say
  const HistoryRow& last = impl_->state.history.back();
  impl_->figures = {last.temperature, last.acceptance};
  // A run that must end in time has to know how long its last score will take.
  if (impl_->optimizer.stop.time_s > 0 && state.finished.empty()) impl_->score(Impl::Exactness::exact, state.elapsed_s);
}

void SwapOptimizer::step(double seconds) {
  NOISELOOM_CHECK(!finished());
  if (impl_->state.step == 0) {
    impl_->begin_sweep(seconds);
  } else if (impl_->is_out_of_time(seconds)) {
    return impl_->end_sweep(seconds);  // cut short
  }
  impl_->move(impl_->classes[static_cast<std::size_t>(impl_->state.step)]);
  ++impl_->state.step;
  if (impl_->state.step == num_classes()) impl_->end_sweep(seconds);
}

void SwapOptimizer::settle() { impl_->slices.hear(); }

void SwapOptimizer::score_now() {
  if (impl_->state.score_is_current() && impl_->score_is_exact) return;
  impl_->score(Impl::Exactness::exact, impl_->last_score_s);
}

bool SwapOptimizer::scores_within(double seconds) const {
  const double took_s = impl_->communicator.broadcast(impl_->exact_score_took_s);
  return took_s >= 0 && took_s < seconds;
}

SwapState SwapOptimizer::state() {
  settle();
  SwapState state = impl_->state;
  std::int64_t counts[] = {state.accepted + impl_->own_accepted, state.candidates + impl_->own_candidates};
  impl_->communicator.sum(counts);
  state.accepted = counts[0];
  state.candidates = counts[1];
  return state;
}

double SwapOptimizer::relative_error() {
  score_now();
  return last_score();
}

std::vector<SliceIndex> SwapOptimizer::slices_held() const { return impl_->slices.indices(); }
Method SwapOptimizer::method() const { return impl_->optimizer.method; }
bool SwapOptimizer::finished() const { return !impl_->state.finished.empty(); }
const std::string& SwapOptimizer::finished_by() const { return impl_->state.finished; }
const std::vector<HistoryRow>& SwapOptimizer::history() const { return impl_->state.history; }
const SweepFigures& SwapOptimizer::last_sweep() const { return impl_->figures; }
bool SwapOptimizer::has_given() const { return impl_->state.is_given != 0; }
double SwapOptimizer::join() const { return impl_->state.join; }
bool SwapOptimizer::is_cold() const { return impl_->state.is_cold != 0; }
bool SwapOptimizer::kept_given() const { return impl_->state.given_kept != 0; }
double SwapOptimizer::last_score() const { return impl_->state.relative_error; }
std::int64_t SwapOptimizer::last_score_at_iteration() const { return impl_->state.scored_iterations; }
bool SwapOptimizer::last_score_is_current() const { return impl_->state.score_is_current(); }
double SwapOptimizer::temperature() const { return impl_->state.temperature; }
std::int64_t SwapOptimizer::sweep() const { return impl_->state.sweep; }
std::int64_t SwapOptimizer::iterations() const { return impl_->state.iterations; }
std::int64_t SwapOptimizer::iterations_per_sweep() const { return impl_->schedule.iterations_per_sweep(); }
Moment SwapOptimizer::moment() const { return impl_->moment(); }
const Distribution& SwapOptimizer::distribution() const { return impl_->slices.distribution(); }
bool SwapOptimizer::row_is_planned_after(std::int64_t sweeps, bool cold) const {
  const Schedule schedule(impl_->optimizer.stop, iterations_per_sweep(cold));
  return impl_->row_is_planned(schedule, schedule.moment(sweeps - 1, 0));
}
const HaloPlan& SwapOptimizer::halo() const { return impl_->slices.halo(); }
std::int64_t SwapOptimizer::num_classes() const { return std::ssize(impl_->classes); }
bool SwapOptimizer::couples_slices() const { return impl_->score_footprint.couples_slices(); }
std::int64_t SwapOptimizer::bytes_sent() const { return impl_->slices.exchange().bytes_sent(); }
std::int64_t SwapOptimizer::messages_sent() const { return impl_->slices.exchange().messages_sent(); }
std::int64_t SwapOptimizer::candidates_done() const { return impl_->candidates_done + impl_->own_candidates; }

const Permutation& SwapOptimizer::permutation(SliceIndex slice) const { return impl_->slices.permutation(slice); }

const Permutation& SwapOptimizer::given_permutation(SliceIndex slice) const {
  return impl_->given[distribution().local_slice_from_global(slice)];
}

std::vector<float> SwapOptimizer::samples(SliceIndex slice) const {
  const FieldLayout& layout = impl_->layout;
  std::vector<float> out(static_cast<std::size_t>(layout.width * layout.height * layout.channels));
  impl_->slices.field(slice).interleaved(out);
  return out;
}

}  // namespace noiseloom
