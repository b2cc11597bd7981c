#include "run/jobs/joining.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "noiseloom/anneal/cooling.h"
#include "noiseloom/anneal/swap_optimizer.h"
#include "noiseloom/core/math.h"
#include "noiseloom/dist/communicator.h"
#include "noiseloom/problem/footprint.h"
#include "noiseloom/run/stop_signals.h"

namespace noiseloom {
namespace {

constexpr double fewest_trial_iterations = 100;  // fewer do not tell what more would come to
constexpr double most_trial_iterations = 2000;
constexpr double most_trial_candidates = 2e7;  // of a trial: seconds, between two looks at the signals
constexpr double most_share_of_time = 0.1;     // of stop.time, which the trials of each rank take for themselves
// Of rounds, whose number is not known.
constexpr double iterations_of_rounds = 2000;
constexpr std::int64_t most_twin_pixels = std::int64_t{1} << 17;

double real(std::int64_t count) { return static_cast<double>(count); }

// The same problem in a texture that is small along x and y, and of one slice where slices do not act on each other.
struct Twin {
  ProblemSpec problem;
  OptimizerSpec optimizer;
};

// Samples of slices spread over the texture, which may differ, in the order of their ids: the k-th of them is of the
// k-th slice, beginning anew after the last.
SampleSpec thinned(const SampleSpec& samples, const SampleSource& source, std::int64_t wanted) {
  if (!samples.is_file()) return samples;
  constexpr std::int64_t most_slices = 16;
  const std::int64_t num_slices = std::min({most_slices, std::int64_t{source.num_slices()}, wanted});
  const auto channels = static_cast<std::size_t>(source.channels());
  std::vector<float> values(static_cast<std::size_t>(wanted) * channels);
  for (std::int64_t i = 0; i < num_slices; ++i) {
    const std::vector<float> list = source.list(SliceIndex(i * source.num_slices() / num_slices));
    for (std::int64_t k = i; k < wanted; k += num_slices) {
      const std::int64_t id = k * source.cells_per_slice() / wanted;
      std::copy_n(list.begin() + id * source.channels(), channels, values.begin() + k * source.channels());
    }
  }
  SampleSpec thin = samples;
  thin.array =
      std::make_shared<const InputArray>(InputArray{{wanted, static_cast<std::int64_t>(channels)}, std::move(values)});
  return thin;
}

}  // namespace

Extents extents_of_trials(const RunConfig& config) {
  const Extents& extents = config.problem.extents;
  const Footprint footprint(extents, config.problem.filter);
  const bool coupled = footprint.couples_slices();
  std::vector<std::int64_t> sizes;
  std::vector<std::string> names;
  for (int axis = 0; axis < extents.num_axes(); ++axis) {
    const std::int64_t small = std::max<std::int64_t>(coupled ? 32 : 64, axis < 2 ? 4 * footprint.reach(axis) : 0);
    sizes.push_back(axis < 2 ? std::min(extents.size(axis), small) : coupled ? extents.size(axis) : 1);
    names.push_back(extents.name(axis));
  }
  const auto pixels = [&] {
    double product = 1;
    for (const std::int64_t size : sizes) product *= real(size);
    return product;
  };
  while (pixels() > real(most_twin_pixels) && sizes.size() > 2) {
    const auto longest = std::max_element(sizes.begin() + 2, sizes.end());
    if (*longest < 8) break;
    *longest /= 2;
  }
  return Extents(sizes, names);
}

namespace {

Twin twin_of(const RunConfig& config, const SampleSource& source) {
  Twin twin{config.problem, config.optimizer};
  twin.problem.extents = extents_of_trials(config);
  twin.problem.samples = thinned(config.problem.samples, source, twin.problem.extents.cells_per_slice());
  twin.optimizer.method = Method::anneal;
  return twin;
}

// R that annealing comes to from a random arrangement, and how long a candidate took.
struct Trial {
  double relative_error;
  double candidate_s;
};

Trial anneal(Twin twin, double iterations, const JoiningQuestion& question, ThreadPool& pool) {
  twin.optimizer.stop = StopSpec::none();
  twin.optimizer.stop.iterations = static_cast<std::int64_t>(iterations);
  const Extents& extents = twin.problem.extents;
  const SampleSource source(twin.problem.samples, extents.cells_per_slice(), extents.num_slices(), twin.problem.seed);
  const Communicator alone = Communicator::self();
  SwapOptimizer optimizer(twin.problem, twin.optimizer, source, alone, pool);
  optimizer.start();
  const auto begun = std::chrono::steady_clock::now();
  while (!optimizer.finished()) {
    if (question.is_stopped()) throw TrialsStopped();
    optimizer.step(0);
  }
  const double took_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - begun).count();
  return {optimizer.relative_error(), took_s / std::max(1.0, real(optimizer.candidates_done()))};
}

bool is_constructed_circle(const RunConfig& config, const SampleSource& source) {
  return config.optimizer.method == Method::construct && source.distance() == DistanceKind::circle;
}

// Of a few milliseconds, the first of which find memory and threads cold: the best of three.
double quickest_candidate(const Twin& twin, const JoiningQuestion& question, ThreadPool& pool) {
  double least_s = 1;
  for (int trial = 0; trial < 3; ++trial) {
    least_s = std::min(least_s, anneal(twin, 24, question, pool).candidate_s);
  }
  return std::max(least_s, 1e-9);
}

}  // namespace

double extrapolated_error(double error_of_quarter, double error, double tried, double iterations) {
  constexpr double lasting = 0.75;
  if (!(error < error_of_quarter) || iterations <= tried) return error;
  const double quadruplings = math::log(iterations / tried) / math::log(4);
  const double gain = math::log(error_of_quarter / error);
  // The sum of lasting^k for k = 1, 2, ..., quadruplings.
  const double times = lasting * (1 - math::exp(quadruplings * math::log(lasting))) / (1 - lasting);
  return error * math::exp(-gain * times);
}

Joining joining_of(double expected_ratio) {
  if (expected_ratio < 0.95) return {expected_ratio, false, 0};
  if (!(expected_ratio <= 1.04)) return {expected_ratio, true, 0};
  return {expected_ratio, false, 0.35 + 3 * std::max(0.0, expected_ratio - 1)};
}

Joining joining_of_circle(double iterations) {
  if (!(iterations >= 500)) return {1, true, 0};
  return {1, false, iterations < 4000 ? 0.4 : 0.3};
}

Joining find_joining(const RunConfig& config, const SampleSource& source, const JoiningQuestion& question,
                     ThreadPool& pool) {
  const Twin twin = twin_of(config, source);
  const double pixels = real(config.problem.extents.num_cells());
  const double twin_pixels = real(twin.problem.extents.num_cells());
  const StopSpec& stop = config.optimizer.stop;
  double iterations = stop.iterations > 0 ? real(stop.iterations) : iterations_of_rounds;
  double longest = most_trial_candidates * 2 / twin_pixels;
  if (stop.time_s > 0) {
    const double candidate_s = quickest_candidate(twin, question, pool);
    const double used = std::min(question.workers, pool.num_threads());  // what the trial had
    const double candidates = question.left_s / candidate_s * question.workers / used;
    iterations = std::max(1.0, candidates * 2 / pixels);
    longest = std::min(longest, most_share_of_time * question.left_s / (1.25 * candidate_s * twin_pixels / 2));
    if (is_constructed_circle(config, source)) return joining_of_circle(iterations);
    // What cannot be found out is not risked.
    if (longest < std::min(iterations, fewest_trial_iterations)) return {1, true, 0};
  }
  if (is_constructed_circle(config, source)) return joining_of_circle(iterations);
  const double affordable = share_of_trials / 1.25 * iterations * pixels / twin_pixels;
  const double most = std::clamp(longest, fewest_trial_iterations, most_trial_iterations);
  const double tried = std::min(iterations, std::clamp(affordable, fewest_trial_iterations, most));
  const double quarter = anneal(twin, std::max(1.0, std::floor(tried / 4)), question, pool).relative_error;
  const double error = anneal(twin, std::max(1.0, std::floor(tried)), question, pool).relative_error;
  const double expected = extrapolated_error(quarter, error, tried, iterations);
  return joining_of(question.given_error > 0 ? expected / question.given_error : 2);
}

bool needs_joining(const OptimizerSpec& optimizer) { return !has_given_temperature(optimizer); }

std::optional<Joining> agree_on_joining(const RunConfig& config, const SampleSource& source, double given_error,
                                        double left_s, const Communicator& communicator, ThreadPool& pool) {
  std::int64_t workers[] = {pool.num_threads()};
  communicator.sum(workers);
  const JoiningQuestion question{
      .given_error = given_error, .left_s = left_s, .workers = static_cast<int>(workers[0]), .is_stopped = [] {
        return noted_stop_signal() != 0;
      }};
  Joining joining;
  bool stopped = false;
  communicator.together([&] {
    try {
      joining = find_joining(config, source, question, pool);
    } catch (const TrialsStopped&) {
      stopped = true;
    }
  });
  if (communicator.any_bits(stopped ? 1U : 0U) != 0) return std::nullopt;
  // The clock has a say with stop.time.
  joining.cold = communicator.broadcast(joining.cold ? 1.0 : 0.0) != 0;
  return joining;
}

}  // namespace noiseloom
