#include "run/plans/plan_speed.h"

#include <algorithm>
#include <cmath>
#include <ctime>
#include <functional>
#include <memory>

#include "noiseloom/anneal/slice_mover.h"
#include "noiseloom/anneal/swap_choices.h"
#include "noiseloom/problem/score.h"

namespace noiseloom {
namespace {

// Cells of the small texture along x and y: as a tile has, in memory that a cache holds.
constexpr std::int64_t wide_enough = 144;
constexpr std::int64_t widest = 384;
constexpr std::int64_t scored_cells = 64;
constexpr double most_taps = 3e5;
constexpr double most_stacked_bytes = 4e7;
constexpr std::int64_t deep_enough = 17;
constexpr std::size_t num_candidates = 2048;

// Processor time: what else runs on the machine now need not run then.
double thread_seconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

double seconds_of(const std::function<void()>& work) {
  const double begun = thread_seconds();
  work();
  return thread_seconds() - begun;
}

// The quicker of two: the first warms the caches up.
double quicker_of_two(const std::function<void()>& work) {
  const double first = seconds_of(work);
  return first > 0.05 ? first : std::min(first, seconds_of(work));
}

// Samples of a file are stood for by others of as many channels.
SampleSpec stand_in(const SampleSpec& spec, int channels, DistanceKind distance) {
  SampleSpec result = spec;
  if (!spec.is_file()) return result;
  result = SampleSpec{};
  if (distance == DistanceKind::circle) result.space = "circle";
  if (channels > 1) result.space = "vector" + std::to_string(channels);
  if (is_between_unit_vectors(distance) && channels == 3) result.space = "sphere";
  if (distance == DistanceKind::axis) result.space = channels == 3 ? "axis" : "rotation";
  if (distance == DistanceKind::manhattan) result.compared_by = ComparedBy::manhattan;
  if (distance == DistanceKind::chebyshev) result.compared_by = ComparedBy::chebyshev;
  if (distance == DistanceKind::cosine && channels == 3) result.compared_by = ComparedBy::cosine;
  return result;
}

struct Small {
  ProblemSpec problem;
  WindowSize window;
};

// A filter wider than `widest` goes around a small torus; what its taps cost is scaled up.
std::int64_t small_window(std::int64_t size, std::int64_t window, std::int64_t reach, std::int64_t& small_size) {
  const bool whole = window >= size || reach > widest / 2;
  const std::int64_t wanted = std::min(window, std::clamp(2 * reach + 1, wide_enough, widest));
  small_size = whole ? std::min(size, wanted) : std::min(size, wanted + reach);
  return whole ? small_size : wanted;
}

Small small_problem(const RunConfig& config, const FilterOutline& judged, WindowSize tile, int channels,
                    DistanceKind distance) {
  const Extents& extents = config.problem.extents;
  Small small{config.problem, {}};
  std::vector<std::int64_t> sizes(2);
  small.window.width = small_window(extents.width(), tile.width, judged.plane.reach(0), sizes[0]);
  small.window.height = small_window(extents.height(), tile.height, judged.plane.reach(1), sizes[1]);
  const double stacked = static_cast<double>(judged.num_coupled_slices()) * 4 * channels *
                         static_cast<double>(small.window.width * small.window.height);
  const bool deep = static_cast<double>(judged.num_taps) > most_taps || stacked > most_stacked_bytes;
  const std::int64_t depth = static_cast<double>(judged.own_taps) > most_taps / 16 ? 3 : deep_enough;
  std::vector<std::string> names = {extents.name(0), extents.name(1)};
  for (int axis = 2; axis < extents.num_axes(); ++axis) {
    sizes.push_back(deep ? std::min(extents.size(axis), depth) : extents.size(axis));
    names.push_back(extents.name(axis));
  }
  small.problem.extents = Extents(sizes, names);
  small.problem.samples = stand_in(config.problem.samples, channels, distance);
  return small;
}

std::vector<CellPair> some_pairs(WindowSize window) {
  const auto cells = static_cast<std::uint64_t>(window.width * window.height);
  std::vector<CellPair> pairs(num_candidates);
  for (std::uint64_t k = 0; k < pairs.size(); ++k) {
    const auto i = static_cast<std::uint32_t>(k * 7919 % cells);
    pairs[k] = {i, static_cast<std::uint32_t>((i + 1 + k * 104729 % std::max<std::uint64_t>(1, cells - 1)) % cells)};
  }
  return pairs;
}

struct MoverSpeed {
  double candidate;
  double bind;
};

// Of candidates that are estimated first: how many are judged, and swapped. Counted in nine kinds of filters and
// samples: 0.17 to 0.24 and 0.055 to 0.099 in 200 iterations, 0.10 to 0.19 and 0.039 to 0.086 in 1,500.
constexpr double share_judged = 0.15;
constexpr double sieved_acceptance = 0.06;

double seconds_of_estimates(const SwapDelta& delta, const std::vector<CellPair>& pairs) {
  double estimates[16];
  return quicker_of_two([&] {
    for (std::size_t k = 0; k + 16 <= pairs.size(); k += 16) {
      const auto sixteen = std::span(pairs).subspan(k, 16);
      delta.prefetch_estimates(sixteen);
      delta.estimate(sixteen, estimates);
    }
  });
}

MoverSpeed speed_of(SwapDelta& delta, const SliceField& field, WindowSize window) {
  const FieldOf others = [&field](SliceIndex) -> const SliceField& { return field; };
  const double bound_s = quicker_of_two([&] { delta.bind(SliceIndex(0), field, others); });
  const std::vector<CellPair> pairs = some_pairs(window);
  double sum = 0;
  std::size_t judged = 0;
  double judging_s = 0;
  // In sixteens, as candidates are drawn; a slow kernel is stopped after a few.
  while (judged + 16 <= pairs.size() && (judging_s < 0.02 || judged < 64)) {
    judging_s += seconds_of([&] {
      const auto sixteen = std::span(pairs).subspan(judged, 16);
      delta.prefetch(sixteen);
      for (const CellPair pair : sixteen) sum += delta.delta(pair);
    });
    judged += 16;
  }
  const double swapping_s = seconds_of([&] {
    for (std::size_t k = 0; k < judged; ++k) delta.swap(pairs[k]);
  });
  constexpr double draw_s = 12e-9;  // drawing a pair and looking its partner up
  const bool sieved = delta.has_estimates();
  const double judge_s = (sieved ? share_judged : 1) * judging_s;
  const double swap_s = (sieved ? sieved_acceptance : typical_acceptance) * swapping_s;
  const double estimate_s = sieved ? seconds_of_estimates(delta, pairs) / static_cast<double>(pairs.size()) : 0;
  const double each = (judge_s + swap_s) / static_cast<double>(judged) + estimate_s;
  return {sum == sum ? each + draw_s : each, bound_s / static_cast<double>(window.width * window.height)};
}

double ratio(std::int64_t a, std::int64_t b) {
  return static_cast<double>(std::max<std::int64_t>(1, a)) / static_cast<double>(std::max<std::int64_t>(1, b));
}

// Kernel and window as the engine has them, before and after the number of features grows.
void measure_moves(const RunConfig& config, const FilterOutline& judged, const Small& small, const SampleSource& source,
                   PlanSpeed& speed) {
  const ProblemSpec& problem = small.problem;
  const Footprint footprint(problem.extents, problem.filter, energy_cutoff(config.optimizer));
  SliceField field(FieldLayout(footprint, source.channels()));
  field.fill(start_permutation(problem.seed, SliceIndex(0), problem.extents.cells_per_slice()),
             source.list(SliceIndex(0)));
  const ValueKernel kernel = make_value_kernel(problem, source.channels(), source.distance());
  const std::optional<FeatureMap> sieve = features_of_sieve(config.optimizer, footprint, kernel, source);
  const bool many = wants_many_features(footprint, sieve.has_value());
  for (std::size_t k = 0; k < moments_of_run.size(); ++k) {
    const int count = num_features(config.optimizer, moments_of_run[k], many);
    const std::optional<FeatureMap> features =
        features_between_slices(config.optimizer, footprint, kernel, source, count);
    const auto delta = make_swap_delta(footprint, kernel, config.optimizer.precision, features ? &*features : nullptr,
                                       small.window, sieve ? &*sieve : nullptr);
    const MoverSpeed mover = speed_of(*delta, field, small.window);
    if (!features) {
      const double scale = ratio(judged.num_taps, footprint.num_taps());
      speed.candidate = mover.candidate * scale;
      speed.bind = mover.bind * (judged.same_pixel_only ? scale : 1);
      return;
    }
    speed.features.push_back({features->num_features(), features->missed()});
    speed.candidate +=
        share_of_moment[k] * mover.candidate * ratio(judged.own_taps, std::ssize(footprint.slices()[0].taps));
    speed.bind += share_of_moment[k] * mover.bind;
  }
}

// R of a slice by itself.
double measure_score(const ProblemSpec& problem, int channels, DistanceKind distance) {
  const Extents plane({scored_cells, scored_cells});
  FilterSpec box{Combine::product, {{{0, 1}, {}, 0}}};
  box.groups[0].kernel.size = 5;
  const Footprint footprint(plane, box);
  const SampleSource source(problem.samples, plane.cells_per_slice(), 1, 1);
  SliceField field(FieldLayout(footprint, channels));
  field.fill(start_permutation(1, SliceIndex(0), plane.cells_per_slice()), source.list(SliceIndex(0)));
  const std::vector<float> values = field.planar();
  const double took_s = quicker_of_two([&] {
    weighted_distance_sum(
        footprint, distance, channels, SliceIndex(0), [&](SliceIndex) { return values.data(); }, PairEnds::one);
  });
  return took_s / static_cast<double>(plane.cells_per_slice()) / (static_cast<double>(footprint.num_taps()) / 2);
}

double measure_pairs(const SampleSource& source, int channels, DistanceKind distance) {
  const bool sorted = mean_is_sorted(distance);
  const std::int64_t count = sorted ? std::int64_t{1} << 14 : 1024;
  std::vector<float> list(static_cast<std::size_t>(count * channels));
  const std::vector<float> some = source.list(SliceIndex(0));
  const auto samples = static_cast<std::int64_t>(some.size()) / channels;
  for (std::int64_t k = 0; k < count; ++k) {
    std::copy_n(some.begin() + k * 7919 % samples * channels, channels, list.begin() + k * channels);
  }
  const MeanDistance mean(distance, channels, count, 1);
  ThreadPool pool(1);
  const double took_s = quicker_of_two([&] { mean.compute([&list](SliceIndex) { return list; }, pool); });
  return took_s / static_cast<double>(sorted ? count : mean.num_pairs());
}

}  // namespace

PlanSpeed measure_speed(const RunConfig& config, const FilterOutline& judged, WindowSize tile, int channels,
                        DistanceKind distance) {
  const Small small = small_problem(config, judged, tile, channels, distance);
  const Cell cells = small.problem.extents.cells_per_slice();
  const SampleSource source(small.problem.samples, cells, 1, config.problem.seed);
  PlanSpeed speed;
  speed.sample = seconds_of([&] { source.list(SliceIndex(0)); }) / static_cast<double>(cells);
  speed.pair = measure_pairs(source, channels, distance);
  speed.score_tap = measure_score(small.problem, channels, distance);
  measure_moves(config, judged, small, source, speed);
  return speed;
}

}  // namespace noiseloom
