#include "noiseloom/anneal/engine.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <map>
#include <numeric>

#include "noiseloom/anneal/engine_choices.h"
#include "noiseloom/problem/score.h"

namespace noiseloom {
namespace {

// What the slice that is judged first says about the size of dE.
constexpr std::int64_t magnitude_candidates = 4096;
constexpr std::int64_t least_sweeps_per_fraction = 100;

std::vector<Extents::SliceCoord> coupled_offsets(const Footprint& footprint) {
  std::vector<Extents::SliceCoord> offsets;
  for (const SliceTaps& slice : footprint.slices()) offsets.push_back(slice.offset);
  return offsets;
}

}  // namespace

struct Engine::Impl {
  const ProblemSpec& problem;
  const OptimizerSpec& optimizer;
  const SampleSource& source;
  const Communicator& communicator;
  ThreadPool& pool;

  Footprint score_footprint;
  Footprint footprint;
  ValueKernel kernel;
  std::optional<FeatureMap> features;
  int rank_now;
  std::int64_t iterations_per_sweep;
  StopSpec stop;
  FieldLayout layout;
  Partition partition;
  HaloPlan halo;
  HaloExchange exchange;
  std::vector<std::vector<SliceIndex>> classes;
  TileGrid tiles;
  bool members_meet;  // whether slices of one class see one another
  PartnerDraw partners;
  std::vector<AnnealMover> anneal_movers;  // one for each thread
  std::vector<PairingMover> pairing_movers;
  std::map<SliceIndex, SliceField> fields;               // own and needed
  std::vector<std::vector<std::uint32_t>> permutations;  // own
  EngineState state;
  std::int64_t own_accepted = 0;
  std::int64_t own_candidates = 0;
  std::int64_t candidates_done = 0;
  SweepFigures figures;
  std::int64_t own_energy = 0;  // of the swaps of the present sweep, in energy_unit; exact in any order
  double last_score_s = 0;      // how long the last score took

  Impl(const ProblemSpec& p, const OptimizerSpec& o, const SampleSource& s, const Communicator& c, ThreadPool& t)
      : problem(p),
        optimizer(o),
        source(s),
        communicator(c),
        pool(t),
        score_footprint(p.extents, p.filter),
        footprint(p.extents, p.filter, o.cutoff),
        kernel(make_value_kernel(p, s.channels(), s.distance())),
        features(features_between_slices(o, footprint, kernel, s, o.background_rank)),
        rank_now(o.background_rank),
        iterations_per_sweep(visit_length(o, features.has_value())),
        stop(in_sweeps(o.stop, iterations_per_sweep)),
        layout(footprint, s.channels()),
        partition(p.extents.num_slices(), c.size()),
        halo(p.extents, coupled_offsets(score_footprint), partition, c.rank()),
        exchange(c, halo, partition),
        classes(classes_for(o.method, footprint)),
        tiles(tiles_for(o.method, footprint, classes)),
        members_meet(o.method == Method::fast || (footprint.couples_slices() && classes.front().size() > 1)),
        partners(partners_for(s.distance(), s.channels(), tiles.window(), 0)),
        permutations(static_cast<std::size_t>(partition.count(c.rank()))) {
    make_movers();
  }

  void make_movers() {
    anneal_movers.clear();
    pairing_movers.clear();
    for (int worker = 0; worker < pool.num_threads(); ++worker) {
      auto delta =
          make_swap_delta(footprint, kernel, optimizer.precision, features ? &*features : nullptr, tiles.window());
      if (optimizer.method == Method::anneal) {
        anneal_movers.emplace_back(std::move(delta));
      } else {
        pairing_movers.emplace_back(std::move(delta));
      }
    }
  }

  // Step sizes and background for the present sweep.
  void choose_for_sweep() {
    const double fraction = moment_of(stop, state.sweep, state.elapsed_s).fraction;
    partners = partners_for(source.distance(), source.channels(), tiles.window(), fraction);
    const int rank = background_rank(optimizer, fraction);
    if (!features || rank == rank_now) return;
    rank_now = rank;
    anneal_movers.clear();  // before the features that they look at
    features = features_between_slices(optimizer, footprint, kernel, source, rank);
    make_movers();
  }

  bool owns(SliceIndex slice) const { return partition.owner(slice) == communicator.rank(); }
  std::vector<std::uint32_t>& permutation(SliceIndex slice) {
    return permutations[static_cast<std::size_t>(slice - partition.begin(communicator.rank()))];
  }
  FieldOf field_of() const {
    return [this](SliceIndex slice) -> const SliceField& { return fields.at(slice); };
  }

  std::vector<SliceIndex> held() const {
    std::vector<SliceIndex> slices(static_cast<std::size_t>(partition.count(communicator.rank())));
    std::iota(slices.begin(), slices.end(), partition.begin(communicator.rank()));
    slices.insert(slices.end(), halo.needed().begin(), halo.needed().end());
    return slices;
  }

  void fill(const std::function<std::vector<std::uint32_t>(SliceIndex)>& permutation_of) {
    const std::vector<SliceIndex> slices = held();
    for (const SliceIndex slice : slices) fields.emplace(slice, layout);
    pool.for_each(static_cast<std::int64_t>(slices.size()), [&](std::int64_t index, int) {
      const SliceIndex slice = slices[static_cast<std::size_t>(index)];
      std::vector<std::uint32_t> ids = permutation_of(slice);
      fields.at(slice).fill(ids, source.list(slice));
      if (owns(slice)) permutation(slice) = std::move(ids);
    });
  }

  double mean_distance() {
    const MeanDistance mean(source.distance(), source.channels(), problem.extents.cells_per_slice(),
                            problem.extents.num_slices());
    const Partition tasks(narrow<SliceIndex>(mean.num_tasks()), communicator.size());
    const SliceIndex begin = tasks.begin(communicator.rank());
    std::vector<double> own(static_cast<std::size_t>(tasks.count(communicator.rank())));
    pool.for_each(static_cast<std::int64_t>(own.size()), [&](std::int64_t index, int) {
      own[static_cast<std::size_t>(index)] =
          mean.run_task(begin + index, [this](SliceIndex slice) { return source.list(slice); });
    });
    return mean.combine(communicator.gather_all(tasks, own));
  }

  // Mean |dE| in slice 0 at the start, the same on every rank.
  double mean_magnitude() {
    double magnitude = 0;
    if (owns(0)) {
      const Visit visit{0, 0, problem.seed, 1, 0, tiles.num_tiles(), tiles.corner(problem.seed, 0, 0, 0)};
      magnitude = anneal_movers[0].mean_magnitude(visit, magnitude_candidates, partners, fields.at(0), permutation(0),
                                                  field_of());
    }
    return communicator.broadcast(magnitude);  // slice 0 is always rank 0's
  }

  double relative_error() {
    exchange_wait();
    const std::vector<SliceIndex> slices = held();
    std::map<SliceIndex, std::vector<float>> planar;
    for (const SliceIndex slice : slices) planar[slice];
    pool.for_each(static_cast<std::int64_t>(slices.size()), [&](std::int64_t index, int) {
      const SliceIndex slice = slices[static_cast<std::size_t>(index)];
      planar.at(slice) = fields.at(slice).planar();
    });
    const auto values = [&planar](SliceIndex slice) { return planar.at(slice).data(); };
    std::vector<double> own(permutations.size());
    pool.for_each(static_cast<std::int64_t>(own.size()), [&](std::int64_t index, int) {
      own[static_cast<std::size_t>(index)] =
          weighted_distance_sum(score_footprint, source.distance(), source.channels(),
                                slices[static_cast<std::size_t>(index)], values, PairEnds::one);
    });
    return noiseloom::relative_error(score_footprint, state.mean_distance, communicator.gather_all(partition, own));
  }

  void exchange_wait() {
    std::vector<SliceSwaps> received;  // each slice once: it moves once a step
    exchange.wait([&received](SliceIndex slice, std::span<const Swap> swaps) {
      received.push_back({slice, {swaps.begin(), swaps.end()}});
    });
    pool.for_each(std::ssize(received), [&](std::int64_t index, int) {
      const SliceSwaps& changed = received[static_cast<std::size_t>(index)];
      SliceField& field = fields.at(changed.slice);
      for (const Swap& swap : changed.swaps) field.swap(swap.a, swap.b);
    });
  }

  bool depends_on_pending(SliceIndex slice) const {
    return std::any_of(footprint.slices().begin(), footprint.slices().end(), [&](const SliceTaps& taps) {
      return exchange.pending(problem.extents.slice_at(slice, taps.offset));
    });
  }

  void begin_sweep(double seconds) {
    if (optimizer.stop.time_s > 0) state.elapsed_s = communicator.broadcast(seconds);
    const Moment moment = moment_of(stop, state.sweep, state.elapsed_s);
    choose_for_sweep();
    const TemperatureRange range = temperature_range(optimizer);
    state.temperature = state.mean_magnitude * temperature_at(range.start, range.end, moment.fraction);
    own_accepted = own_candidates = 0;
  }

  std::int64_t iterations_before(std::int64_t sweep) const {
    const std::int64_t iterations = sweep * iterations_per_sweep;
    return optimizer.stop.iterations > 0 ? std::min(iterations, optimizer.stop.iterations) : iterations;
  }

  VisitResult visit(SliceIndex slice, int tile, int worker) {
    const auto sweep = narrow<std::uint32_t>(state.sweep);
    const Visit visit{slice,
                      sweep,
                      problem.seed,
                      iterations_before(state.sweep + 1) - iterations_before(state.sweep),
                      tile,
                      tiles.num_tiles(),
                      tiles.corner(problem.seed, slice, sweep, tile)};
    if (optimizer.method == Method::fast) {
      return pairing_movers[static_cast<std::size_t>(worker)].visit(visit, state.fraction, fields.at(slice),
                                                                    field_of());
    }
    return anneal_movers[static_cast<std::size_t>(worker)].visit(visit, state.temperature, partners, fields.at(slice),
                                                                 permutation(slice), field_of());
  }

  // Slices that wait for messages go last, so that the messages travel while the others move.
  void move(const std::vector<SliceIndex>& moving) {
    std::vector<SliceSwaps> own;
    for (const SliceIndex slice : moving) {
      if (owns(slice)) own.push_back({slice, {}});
    }
    const std::int64_t num_tiles = tiles.num_tiles();
    std::vector<VisitResult> results(own.size() * static_cast<std::size_t>(num_tiles));
    std::vector<std::size_t> order(own.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    const auto first_waiting = std::stable_partition(order.begin(), order.end(),
                                                     [&](std::size_t k) { return !depends_on_pending(own[k].slice); });
    const auto visit_all = [&](auto begin, auto end) {
      pool.for_each((end - begin) * num_tiles, [&](std::int64_t index, int worker) {
        const auto k = static_cast<std::int64_t>(*(begin + index / num_tiles));
        const std::int64_t tile = index % num_tiles;
        VisitResult& result = results[static_cast<std::size_t>(k * num_tiles + tile)];
        const SliceIndex slice = own[static_cast<std::size_t>(k)].slice;
        result = visit(slice, static_cast<int>(tile), worker);
        if (members_meet) return;
        carry_out(slice, result);  // while it is in the cache: nobody else looks there
        if (!halo.listeners(slice).empty()) return;
        anneal_movers[static_cast<std::size_t>(worker)].recycle(std::exchange(result.swaps, {}));
      });
    };
    visit_all(order.begin(), first_waiting);
    exchange_wait();
    visit_all(first_waiting, order.end());
    publish(own, results);
    shorten(own);
    exchange.begin(moving, own);
  }

  // Tiles of a slice have no cell in common.
  void carry_out(SliceIndex slice, VisitResult& result) {
    SliceField& field = fields.at(slice);
    std::vector<std::uint32_t>& ids = permutation(slice);
    for (const Swap& swap : result.swaps) {
      field.swap(swap.a, swap.b);
      std::swap(ids[swap.a], ids[swap.b]);
    }
  }

  // A hot visit makes several swaps a cell; what travels is what they come to.
  void shorten(std::vector<SliceSwaps>& own) {
    const Cell cells = problem.extents.cells_per_slice();
    pool.for_each(std::ssize(own), [&](std::int64_t index, int) {
      SliceSwaps& changed = own[static_cast<std::size_t>(index)];
      if (halo.listeners(changed.slice).empty() || std::ssize(changed.swaps) < cells / 4) return;
      changed.swaps = fewest_swaps(changed.swaps, cells);
    });
  }

  // Carries out what is not yet, and lists what others are to hear of.
  void publish(std::vector<SliceSwaps>& moved, std::vector<VisitResult>& results) {
    const auto num_tiles = static_cast<std::size_t>(tiles.num_tiles());
    if (members_meet) {
      pool.for_each(std::ssize(results), [&](std::int64_t index, int) {
        const auto unit = static_cast<std::size_t>(index);
        carry_out(moved[unit / num_tiles].slice, results[unit]);
      });
    }
    for (std::size_t unit = 0; unit < results.size(); ++unit) {
      VisitResult& result = results[unit];
      std::vector<Swap>& swaps = moved[unit / num_tiles].swaps;
      if (swaps.empty()) swaps.swap(result.swaps);
      swaps.insert(swaps.end(), result.swaps.begin(), result.swaps.end());
      own_accepted += result.num_swaps;
      own_candidates += result.candidates;
      own_energy += std::llround(result.energy / energy_unit());
    }
  }

  // Small enough for what a tile changes, large enough for the sum over any texture.
  double energy_unit() const { return state.mean_magnitude > 0 ? state.mean_magnitude / 1024 : 1; }
  // What the sweep has done to R, as its swaps were judged.
  double change_of_error(std::int64_t energy) const {
    if (optimizer.method != Method::anneal || kernel.kind != ValueKernelKind::distance || state.mean_distance == 0)
      return 0;
    const double cells = static_cast<double>(problem.extents.num_cells());
    return static_cast<double>(energy) * energy_unit() / (cells * state.mean_distance * score_footprint.weight_zero());
  }

  void end_sweep(double seconds) {
    const Moment moment = moment_of(stop, state.sweep, state.elapsed_s);
    std::int64_t counts[] = {own_accepted + state.accepted, own_candidates + state.candidates, own_energy};
    communicator.sum(counts);
    candidates_done += own_candidates;
    own_accepted = own_candidates = own_energy = state.accepted = state.candidates = 0;
    ++state.sweep;
    state.step = 0;
    figures.temperature = optimizer.method == Method::fast ? state.fraction : state.temperature;
    figures.acceptance = counts[1] > 0 ? static_cast<double>(counts[0]) / static_cast<double>(counts[1]) : 0;
    figures.relative_error += change_of_error(counts[2]);
    adapt_fraction(counts[0], moment);
    bool last = moment.ends_round() && optimizer.stop.iterations > 0;
    double now = seconds;
    const std::int64_t scores =
        scores_per_round(source.distance(), score_footprint, footprint, features.has_value(),
                         moment.round_length > 0 ? moment.round_length * iterations_per_sweep : 0);
    bool score = score_due(moment, scores);
    if (optimizer.stop.time_s > 0) {
      now = communicator.broadcast(seconds);
      const double score_s = communicator.broadcast(last_score_s);
      last = now + score_s >= optimizer.stop.time_s;
      score = last || now - state.history.back().seconds >= std::max(optimizer.stop.time_s / 50, 30 * score_s);
    }
    if (!score) return;
    const double error = timed_score();
    figures.relative_error = error;
    state.history.push_back({static_cast<double>(state.sweep), static_cast<double>(iterations_before(state.sweep)),
                             figures.temperature, figures.acceptance, error, now});
    decide(moment, last);
  }

  // The clock counts for stop.time alone.
  double timed_score() {
    const auto begun = std::chrono::steady_clock::now();
    const double error = relative_error();
    last_score_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - begun).count();
    return error;
  }

  // The paper's rule: gamma doubles when fewer than gamma / 4 of all pairs were swapped. Looked at once in a hundredth
  // of the run, as its authors' program does, and never sooner than those hundred sweeps of its ten thousand: swaps
  // double with gamma, so a rule that is looked at every sweep takes gamma to 1 in three, and the pairs that then swap
  // together drive R up without end.
  void adapt_fraction(std::int64_t accepted, const Moment& moment) {
    if (optimizer.method != Method::fast || !optimizer.grow_fraction) return;
    if (state.sweep % std::max(least_sweeps_per_fraction, moment.round_length / 100) != 0) return;
    const double pairs = static_cast<double>(problem.extents.num_cells()) / 2;
    if (static_cast<double>(accepted) < state.fraction / 4 * pairs) state.fraction = std::min(1.0, 2 * state.fraction);
  }

  void decide(const Moment& moment, bool last) {
    const double score = state.history.back().relative_error;
    if (last) state.finished = stop.time_s > 0 ? "time" : "iterations";
    if (stop.score > 0 && score <= stop.score) state.finished = "score";
    if (stop.improvement > 0 && moment.ends_round()) {
      if (moment.round > 0 && score > (1 - stop.improvement) * state.round_score) state.finished = "improvement";
      state.round_score = score;
    }
  }
};

Engine::Engine(const ProblemSpec& problem, const OptimizerSpec& optimizer, const SampleSource& source,
               const Communicator& communicator, ThreadPool& pool)
    : impl_(std::make_unique<Impl>(problem, optimizer, source, communicator, pool)) {}

Engine::~Engine() = default;

void Engine::start() {
  const ProblemSpec& problem = impl_->problem;
  impl_->fill(
      [&](SliceIndex slice) { return start_permutation(problem.seed, slice, problem.extents.cells_per_slice()); });
  impl_->state.mean_distance = impl_->mean_distance();
  impl_->state.fraction = impl_->optimizer.fraction;
  if (impl_->optimizer.method == Method::anneal) impl_->state.mean_magnitude = impl_->mean_magnitude();
  impl_->state.history.push_back({0, 0, 0, 0, impl_->timed_score(), 0});
  impl_->figures.relative_error = impl_->state.history.back().relative_error;
}

void Engine::restore(const EngineState& state,
                     const std::function<std::vector<std::uint32_t>(SliceIndex)>& permutation) {
  impl_->state = state;
  // Counts of the present sweep live on one rank, so that their sum stays what it was.
  if (!impl_->communicator.is_root()) impl_->state.accepted = impl_->state.candidates = 0;
  impl_->fill(permutation);
  impl_->choose_for_sweep();
  const HistoryRow& last = impl_->state.history.back();
  impl_->figures = {last.temperature, last.acceptance, last.relative_error};
}

std::vector<SliceIndex> Engine::slices_held() const { return impl_->held(); }
bool Engine::finished() const { return !impl_->state.finished.empty(); }
const std::string& Engine::finished_by() const { return impl_->state.finished; }

void Engine::step(double seconds) {
  NOISELOOM_CHECK(!finished());
  if (impl_->state.step == 0) impl_->begin_sweep(seconds);
  impl_->move(impl_->classes[static_cast<std::size_t>(impl_->state.step)]);
  ++impl_->state.step;
  if (impl_->state.step == num_classes()) impl_->end_sweep(seconds);
}

void Engine::settle() { impl_->exchange_wait(); }

EngineState Engine::state() {
  settle();
  EngineState state = impl_->state;
  std::int64_t counts[] = {state.accepted + impl_->own_accepted, state.candidates + impl_->own_candidates};
  impl_->communicator.sum(counts);
  state.accepted = counts[0];
  state.candidates = counts[1];
  return state;
}

const std::vector<HistoryRow>& Engine::history() const { return impl_->state.history; }
const SweepFigures& Engine::last_sweep() const { return impl_->figures; }
double Engine::temperature() const { return impl_->state.temperature; }
std::int64_t Engine::sweep() const { return impl_->state.sweep; }
std::int64_t Engine::iterations() const { return impl_->iterations_before(impl_->state.sweep); }
std::int64_t Engine::iterations_per_sweep() const { return impl_->iterations_per_sweep; }
Moment Engine::moment() const { return moment_of(impl_->stop, impl_->state.sweep, impl_->state.elapsed_s); }
double Engine::relative_error() { return impl_->relative_error(); }
const Partition& Engine::partition() const { return impl_->partition; }
const HaloPlan& Engine::halo() const { return impl_->halo; }
std::int64_t Engine::num_classes() const { return static_cast<std::int64_t>(impl_->classes.size()); }
bool Engine::couples_slices() const { return impl_->score_footprint.couples_slices(); }
std::int64_t Engine::bytes_sent() const { return impl_->exchange.bytes_sent(); }
std::int64_t Engine::messages_sent() const { return impl_->exchange.messages_sent(); }
std::int64_t Engine::candidates_done() const { return impl_->candidates_done + impl_->own_candidates; }
const std::vector<std::uint32_t>& Engine::permutation(SliceIndex slice) const { return impl_->permutation(slice); }

std::vector<float> Engine::samples(SliceIndex slice) const {
  std::vector<float> out(static_cast<std::size_t>(impl_->layout.width * impl_->layout.height * impl_->layout.channels));
  impl_->fields.at(slice).interleaved(out);
  return out;
}

}  // namespace noiseloom
