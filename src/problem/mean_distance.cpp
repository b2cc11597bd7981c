// The mean distance m over all ordered pairs of a texture's samples.
//
// Beyond what can be done exactly, with mu_A the samples of block A as a measure, mu their mean and e_A = mu_A - mu:
//
//   m_AA = m + 2 m(mu, e_A) + m(e_A, e_A)        m_AB = m + m(mu, e_A) + m(mu, e_B) + m(e_A, e_B)
//
// In sum_A (n_A/N)^2 m_AA + (1 - sum_A (n_A/N)^2) <m_AB over neighbours on a ring>, blocks of equal size cancel every
// term of first order. What is left are the m(e_A, e_B) of the neighbours: independent, of mean nearly zero and of
// standard deviation c m / n_A where blocks are random, so the relative error is c / sqrt(pairs looked at), c between
// 0.2 (vectors of many channels) and 0.63 (scalars). The pairs are 2^34 or more: 5e-6 at most. Lists in stratified
// order do better, because blocks are dealt from groups of samples next to each other in the list: measured 3e-8 for
// 2^20 uniform samples of the unit square in strata (MeanDistance.BlocksOfATextureAgreeWithAllPairs).
#include <algorithm>
#include <numeric>
#include <vector>

#include "compensated_sum.h"
#include "mean_distance_blocks.h"
#include "noiseloom/core/random.h"
#include "noiseloom/problem/score.h"

namespace noiseloom {
namespace {

constexpr std::int64_t max_sorted_samples = std::int64_t{1} << 26;
constexpr std::int64_t max_paired_samples = std::int64_t{1} << 18;  // squared: 2^36
constexpr std::int64_t pairs_wanted = std::int64_t{1} << 34;
constexpr std::int64_t samples_per_task = std::int64_t{1} << 20;
constexpr std::int64_t tasks_wanted = 64;

std::int64_t ceil_div(std::int64_t a, std::int64_t b) { return (a + b - 1) / b; }

// Blocks are numbered slice by slice. Each meets itself and `neighbours` blocks that follow it on the ring of all.
struct Division {
  bool exact = false;
  std::int64_t cells_per_slice = 0;
  std::int64_t num_slices = 0;
  std::int64_t parts = 1;  // blocks per slice
  std::int64_t neighbours = 0;
  std::int64_t blocks_per_task = 1;

  std::int64_t num_blocks() const { return parts * num_slices; }
  std::int64_t num_tasks() const { return ceil_div(num_blocks(), blocks_per_task); }
  double num_samples() const { return static_cast<double>(cells_per_slice) * static_cast<double>(num_slices); }
  // The first blocks of a slice hold one sample more where the division leaves a rest.
  std::int64_t size(std::int64_t part) const { return cells_per_slice / parts + (part < cells_per_slice % parts); }
  // What the sum of distances between two neighbours counts in m.
  double pair_factor() const;
};

double Division::pair_factor() const {
  const double all = num_samples() * num_samples();
  if (exact) return 2 / all;
  double own = 0;
  double ring = 0;
  for (std::int64_t part = 0; part < parts; ++part) {
    const auto n = static_cast<double>(size(part));
    own += n * n;
    for (std::int64_t j = 1; j <= neighbours; ++j) ring += n * static_cast<double>(size((part + j) % parts));
  }
  const auto slices = static_cast<double>(num_slices);
  return (1 - slices * own / all) / (slices * ring);
}

bool sorts_everything(DistanceKind kind, std::int64_t num_samples) {
  return is_one_dimensional(kind) && num_samples <= max_sorted_samples;
}

Division divide(DistanceKind kind, std::int64_t cells_per_slice, std::int64_t num_slices) {
  const std::int64_t num_samples = cells_per_slice * num_slices;
  Division division{false, cells_per_slice, num_slices};
  std::int64_t largest = 4096;  // block; small enough to share a single slice among threads
  std::int64_t smallest = 1;    // smaller ones meet more neighbours instead
  if (is_one_dimensional(kind)) {
    largest = std::int64_t{1} << 20;
    smallest = 4096;
  } else if (num_samples > max_paired_samples) {
    largest = std::clamp(pairs_wanted / num_samples, std::int64_t{64}, std::int64_t{16384});
    smallest = largest;
  } else {
    division.exact = true;
  }
  division.parts = ceil_div(cells_per_slice, largest);
  division.neighbours =
      division.exact ? division.num_blocks() / 2 : std::max(std::int64_t{1}, smallest / cells_per_slice);
  const std::int64_t block = ceil_div(cells_per_slice, division.parts);
  // A task makes the lists of its slices anew, so very large slices are shared by few.
  division.blocks_per_task = cells_per_slice > samples_per_task
                                 ? ceil_div(division.parts, 4)
                                 : std::clamp(ceil_div(division.num_blocks(), tasks_wanted), std::int64_t{1},
                                              std::max(std::int64_t{1}, samples_per_task / block));
  return division;
}

// Deals each group of `parts` samples that follow each other to the blocks of the slice in random order.
std::vector<std::vector<float>> dealt(const Division& division, int channels, SliceIndex slice,
                                      const std::vector<float>& list) {
  const auto count = static_cast<std::size_t>(channels);
  const auto parts = static_cast<std::size_t>(division.parts);
  NOISELOOM_CHECK_EQ(std::ssize(list), division.cells_per_slice * channels);
  if (parts == 1) return {list};
  std::vector<std::vector<float>> blocks(parts);
  std::vector<std::size_t> order;
  RandomBlock random{};
  std::uint64_t draws = 0;
  for (std::size_t first = 0; first * count < list.size(); first += parts) {
    order.resize(std::min(parts, list.size() / count - first));
    std::iota(order.begin(), order.end(), std::size_t{0});
    for (std::size_t i = order.size(); i > 1; --i) {
      if (draws % 4 == 0) random = random_block(0, Purpose::subset, static_cast<std::uint32_t>(slice), 0, draws / 4);
      std::swap(order[i - 1], order[to_below(random[draws++ % 4], i)]);
    }
    for (std::size_t i = 0; i < order.size(); ++i) {
      const float* sample = list.data() + (first + i) * count;
      blocks[order[i]].insert(blocks[order[i]].end(), sample, sample + count);
    }
  }
  return blocks;
}

// Blocks first, first + 1, ... on the ring.
std::vector<SampleBlock> load_blocks(const Division& division, DistanceKind kind, int channels, std::int64_t first,
                                     std::int64_t count, const SliceList& list) {
  std::vector<SampleBlock> blocks;
  std::vector<std::vector<float>> of_slice;
  SliceIndex loaded = -1;
  for (std::int64_t k = first; k < first + count; ++k) {
    const std::int64_t block = k % division.num_blocks();
    const auto slice = narrow<SliceIndex>(block / division.parts);
    if (slice != loaded) of_slice = dealt(division, channels, slice, list(slice));
    loaded = slice;
    blocks.push_back(make_block(kind, channels, of_slice[static_cast<std::size_t>(block % division.parts)]));
  }
  return blocks;
}

double sorted_mean(DistanceKind kind, SliceIndex num_slices, const SliceList& list) {
  SampleBlock all;
  for (SliceIndex slice = 0; slice < num_slices; ++slice) {
    const std::vector<float> samples = list(slice);
    all.values.insert(all.values.end(), samples.begin(), samples.end());
  }
  std::sort(all.values.begin(), all.values.end());
  all.size = all.values.size();
  const auto count = static_cast<double>(all.size);
  return self_distance_sum(kind, 1, all) / (count * count);
}

}  // namespace

MeanDistance::MeanDistance(DistanceKind kind, int channels, std::int64_t cells_per_slice, SliceIndex num_slices)
    : kind_(kind), channels_(channels), cells_per_slice_(cells_per_slice), num_slices_(num_slices) {
  NOISELOOM_CHECK(channels == 1 || !is_one_dimensional(kind));
}

bool MeanDistance::exact() const {
  return sorts_everything(kind_, cells_per_slice_ * num_slices_) || divide(kind_, cells_per_slice_, num_slices_).exact;
}

std::int64_t MeanDistance::num_tasks() const {
  if (sorts_everything(kind_, cells_per_slice_ * num_slices_)) return 1;
  return divide(kind_, cells_per_slice_, num_slices_).num_tasks();
}

double MeanDistance::run_task(std::int64_t task, const SliceList& list) const {
  if (sorts_everything(kind_, cells_per_slice_ * num_slices_)) return sorted_mean(kind_, num_slices_, list);
  const Division division = divide(kind_, cells_per_slice_, num_slices_);
  const std::int64_t num_blocks = division.num_blocks();
  const std::int64_t first = task * division.blocks_per_task;
  const std::int64_t own = std::min(division.blocks_per_task, num_blocks - first);
  const std::vector<SampleBlock> blocks =
      load_blocks(division, kind_, channels_, first, std::min(own + division.neighbours, num_blocks), list);
  CompensatedSum inside;
  CompensatedSum between;
  for (std::int64_t k = 0; k < own; ++k) {
    const SampleBlock& block = blocks[static_cast<std::size_t>(k)];
    inside.add(self_distance_sum(kind_, channels_, block));
    for (std::int64_t j = 1; j <= division.neighbours; ++j) {
      const SampleBlock& other = blocks[static_cast<std::size_t>((k + j) % num_blocks)];
      const bool met_twice = 2 * j == num_blocks;  // opposite each other on the ring
      between.add(cross_distance_sum(kind_, channels_, block, other) / (met_twice ? 2 : 1));
    }
  }
  return inside.value() / (division.num_samples() * division.num_samples()) + division.pair_factor() * between.value();
}

double MeanDistance::combine(std::span<const double> task_results) const {
  CompensatedSum sum;
  for (const double result : task_results) sum.add(result);
  return sum.value();
}

double MeanDistance::compute(const SliceList& list, ThreadPool& pool) const {
  std::vector<double> results(static_cast<std::size_t>(num_tasks()));
  pool.for_each(num_tasks(),
                [&](std::int64_t task, int) { results[static_cast<std::size_t>(task)] = run_task(task, list); });
  return combine(results);
}

}  // namespace noiseloom
