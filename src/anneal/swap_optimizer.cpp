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
      energy_footprint(p.extents, p.filter, o.cutoff),
      kernel(make_value_kernel(p, s.channels(), s.distance())),
      layout(energy_footprint, s.channels()),
      classes(classes_for(o.method, energy_footprint)),
      tiles(tiles_for(o.method, energy_footprint, classes)),
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
  if (slices.owns(0)) {
    const Visit visit{0, 0, problem.seed, 1, 0, tiles.num_tiles(), tiles.corner(problem.seed, 0, 0, 0)};
    magnitude =
        movers.mean_magnitude(visit, magnitude_candidates, slices.field(0), slices.permutation(0), slices.fields());
  }
  return communicator.broadcast(magnitude);  // slice 0 is always rank 0's
}

SwapOptimizer::SwapOptimizer(const ProblemSpec& problem, const OptimizerSpec& optimizer, const SampleSource& source,
                             const Communicator& communicator, ThreadPool& pool)
    : impl_(std::make_unique<Impl>(problem, optimizer, source, communicator, pool)) {}

SwapOptimizer::~SwapOptimizer() = default;

void SwapOptimizer::start() {
  const ProblemSpec& problem = impl_->problem;
  SwapState& state = impl_->state;
  impl_->slices.fill(impl_->source, [&](SliceIndex slice) {
    return start_permutation(problem.seed, slice, problem.extents.cells_per_slice());
  });
  state.mean_distance = mean_distance(impl_->source, impl_->communicator, impl_->pool);
  state.fraction = impl_->optimizer.fraction;
  if (impl_->optimizer.method == Method::anneal) state.mean_magnitude = impl_->mean_magnitude();
  const StopSpec& stop = impl_->optimizer.stop;
  // A run that must end in time has to know how long its last score will take.
  impl_->score(stop.time_s > 0 ? Impl::Exactness::exact : Impl::Exactness::quick, 0);
  // A run ends by the exact score alone, its start included.
  if (stop.score > 0 && state.relative_error <= stop.score && !impl_->score_is_exact)
    impl_->score(Impl::Exactness::exact, 0);
  impl_->add_row(0);
  if (stop.iterations > 0) return;
  const bool can_swap = problem.extents.cells_per_slice() > 1 && state.mean_distance > 0;
  if (!can_swap) state.finished = ended::nothing_to_swap;
  if (stop.score > 0 && state.relative_error <= stop.score) state.finished = ended::by_score;
}

void SwapOptimizer::restore(const SwapState& state,
                            const std::function<std::vector<std::uint32_t>(SliceIndex)>& permutation) {
  impl_->state = state;
  impl_->state.iterations = impl_->schedule.iterations_before(state.sweep);
  // Counts of the present sweep live on one rank, so that their sum stays what it was.
  if (!impl_->communicator.is_root()) impl_->state.accepted = impl_->state.candidates = 0;
  impl_->slices.fill(impl_->source, permutation);
  impl_->movers.prepare(impl_->moment().fraction);
  impl_->score_is_exact = !impl_->float_score;  // the state does not say
  const HistoryRow& last = impl_->state.history.back();
  impl_->figures = {last.temperature, last.acceptance};
  // A run that must end in time has to know how long its last score will take.
  if (impl_->optimizer.stop.time_s > 0 && state.finished.empty()) impl_->score(Impl::Exactness::exact, state.elapsed_s);
}

void SwapOptimizer::step(double seconds) {
  NOISELOOM_CHECK(!finished());
  if (impl_->state.step == 0) impl_->begin_sweep(seconds);
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
bool SwapOptimizer::finished() const { return !impl_->state.finished.empty(); }
const std::string& SwapOptimizer::finished_by() const { return impl_->state.finished; }
const std::vector<HistoryRow>& SwapOptimizer::history() const { return impl_->state.history; }
const SweepFigures& SwapOptimizer::last_sweep() const { return impl_->figures; }
double SwapOptimizer::last_score() const { return impl_->state.relative_error; }
std::int64_t SwapOptimizer::last_score_at_iteration() const { return impl_->state.scored_iterations; }
bool SwapOptimizer::last_score_is_current() const { return impl_->state.score_is_current(); }
double SwapOptimizer::temperature() const { return impl_->state.temperature; }
std::int64_t SwapOptimizer::sweep() const { return impl_->state.sweep; }
std::int64_t SwapOptimizer::iterations() const { return impl_->state.iterations; }
std::int64_t SwapOptimizer::iterations_per_sweep() const { return impl_->schedule.iterations_per_sweep(); }
Moment SwapOptimizer::moment() const { return impl_->moment(); }
const Distribution& SwapOptimizer::distribution() const { return impl_->slices.distribution(); }
bool SwapOptimizer::row_is_planned_after(std::int64_t sweeps) const {
  return impl_->row_is_planned(impl_->schedule.moment(sweeps - 1, 0));
}
const HaloPlan& SwapOptimizer::halo() const { return impl_->slices.halo(); }
std::int64_t SwapOptimizer::num_classes() const { return std::ssize(impl_->classes); }
bool SwapOptimizer::couples_slices() const { return impl_->score_footprint.couples_slices(); }
std::int64_t SwapOptimizer::bytes_sent() const { return impl_->slices.exchange().bytes_sent(); }
std::int64_t SwapOptimizer::messages_sent() const { return impl_->slices.exchange().messages_sent(); }
std::int64_t SwapOptimizer::candidates_done() const { return impl_->candidates_done + impl_->own_candidates; }

const std::vector<std::uint32_t>& SwapOptimizer::permutation(SliceIndex slice) const {
  return impl_->slices.permutation(slice);
}

std::vector<float> SwapOptimizer::samples(SliceIndex slice) const {
  const FieldLayout& layout = impl_->layout;
  std::vector<float> out(static_cast<std::size_t>(layout.width * layout.height * layout.channels));
  impl_->slices.field(slice).interleaved(out);
  return out;
}

}  // namespace noiseloom
