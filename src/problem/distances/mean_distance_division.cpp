#include "problem/distances/mean_distance_division.h"

#include <algorithm>
#include <numeric>
#include <optional>
#include <utility>
#include <vector>

#include "noiseloom/core/compensated_sum.h"
#include "noiseloom/core/random.h"
#include "problem/distances/mean_distance_blocks.h"
#include "problem/distances/order_in_space.h"

namespace noiseloom {
namespace {

constexpr std::int64_t samples_per_task = std::int64_t{1} << 20;
constexpr std::int64_t tasks_wanted = 64;

std::int64_t ceil_div(std::int64_t a, std::int64_t b) { return (a + b - 1) / b; }

// Deals each group of `parts` samples that are near each other to the blocks of the slice in random order, so that
// every block is spread over the space as the slice is. In very large slices, whose order would take longer than the
// pairs, each group of those that follow each other in the list.
std::vector<std::vector<float>> dealt(const Division& division, SliceIndex slice, const std::vector<float>& list) {
  const auto count = static_cast<std::size_t>(division.channels);
  const auto parts = static_cast<std::size_t>(division.parts);
  NOISELOOM_CHECK_EQ(std::ssize(list), division.cells_per_slice * division.channels);
  if (parts == 1) return {list};
  std::vector<std::uint32_t> near;
  if (!division.exact && division.cells_per_slice <= largest_ordered_slice)
    near = order_in_space(list, division.channels);
  std::vector<std::vector<float>> blocks(parts);
  for (std::size_t part = 0; part < parts; ++part) {
    blocks[part].reserve(static_cast<std::size_t>(division.size(static_cast<std::int64_t>(part))) * count);
  }
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
      const std::size_t at = near.empty() ? first + i : near[first + i];
      const float* sample = list.data() + at * count;
      blocks[order[i]].insert(blocks[order[i]].end(), sample, sample + count);
    }
  }
  return blocks;
}

// Blocks first, first + 1, ... on the ring.
std::vector<SampleBlock> load_blocks(const Division& division, std::int64_t first, std::int64_t count,
                                     const SliceList& list) {
  std::vector<SampleBlock> blocks;
  std::vector<std::vector<float>> of_slice;
  std::optional<SliceIndex> loaded;
  for (std::int64_t k = first; k < first + count; ++k) {
    const std::int64_t block = k % division.num_blocks();
    const auto slice = SliceIndex(block / division.parts);
    if (slice != loaded) {
      of_slice.clear();  // before there are two
      of_slice = dealt(division, slice, list(slice));
    }
    loaded = slice;
    blocks.push_back(make_block(division.kind, division.channels,
                                std::exchange(of_slice[static_cast<std::size_t>(block % division.parts)], {})));
  }
  return blocks;
}

double sorted_mean(const Division& division, const SliceList& list) {
  const auto channels = static_cast<std::size_t>(division.channels);
  SampleBlock all{static_cast<std::size_t>(division.cells_per_slice * division.num_slices), {}};
  all.values.resize(all.size * channels);
  std::size_t at = 0;
  for (const SliceIndex slice : first_indices<SliceIndex>(division.num_slices)) {
    const std::vector<float> samples = list(slice);
    for (std::size_t i = 0; i < samples.size(); ++i)
      all.values[i % channels * all.size + at + i / channels] = static_cast<double>(samples[i]);
    at += samples.size() / channels;
  }
  NOISELOOM_CHECK_EQ(at, all.size);
  sort_channels(division.channels, all);
  const auto count = static_cast<double>(all.size);
  return self_distance_sum(division.kind, division.channels, all) / (count * count);
}

// A task makes the lists of its slices anew, so it takes whole slices where it can, and large parts of very large ones.
std::int64_t blocks_per_task(const Division& division) {
  const std::int64_t blocks = division.num_blocks();
  if (division.num_slices == 1 && !division.exact) return ceil_div(blocks, 4);  // each deals the slice anew
  const std::int64_t block = ceil_div(division.cells_per_slice, division.parts);
  const std::int64_t enough =
      std::clamp(ceil_div(blocks, tasks_wanted), std::int64_t{1}, std::max(std::int64_t{1}, samples_per_task / block));
  return division.meets_own_slice() ? ceil_div(enough, division.parts) * division.parts : enough;  // whole slices
}

}  // namespace

std::int64_t Division::num_tasks() const { return sorts_everything ? 1 : ceil_div(num_blocks(), blocks_per_task); }

Division::PairFactors Division::pair_factors() const {
  const double all = num_samples() * num_samples();
  if (exact) return {2 / all, 0};
  double own = 0;
  double ring = 0;
  double ring_of_slice = 0;
  for (std::int64_t part = 0; part < parts; ++part) {
    const auto n = static_cast<double>(size(part));
    own += n * n;
    for (std::int64_t j = 1; j <= neighbours; ++j) ring += n * static_cast<double>(size((part + j * stride) % parts));
    ring_of_slice += n * static_cast<double>(size((part + 1) % parts));
  }
  const auto slices = static_cast<double>(num_slices);
  if (!meets_own_slice()) return {(1 - slices * own / all) / (slices * ring), 0};
  const auto slice = static_cast<double>(cells_per_slice) * static_cast<double>(cells_per_slice);
  return {(1 - slices * slice / all) / (slices * ring), (slice - own) / (all * ring_of_slice)};
}

Division divide_pairs(DistanceKind kind, int channels, std::int64_t cells_per_slice, std::int32_t num_slices,
                      const PairBudget& budget) {
  const std::int64_t num_samples = cells_per_slice * num_slices;
  Division division{kind, channels, cells_per_slice, num_slices};
  std::int64_t largest = std::min(std::int64_t{4096}, budget.largest_block);  // small: threads share a single slice
  std::int64_t smallest = 1;  // blocks of smaller slices meet more neighbours instead
  if (mean_is_sorted(kind)) {
    division.exact = division.sorts_everything = num_samples * channels <= budget.max_sorted_numbers;
    largest = samples_per_task;  // sorting makes large blocks cheap
    smallest = budget.largest_block / 4;
  } else if (num_samples > budget.max_paired_samples) {
    largest = std::clamp(budget.pairs_wanted / num_samples, budget.smallest_block, budget.largest_block);
    smallest = largest;
  } else {
    division.exact = true;
  }
  division.parts = ceil_div(cells_per_slice, largest);
  division.neighbours = std::max(std::int64_t{1}, smallest / cells_per_slice);
  if (2 * division.neighbours >= division.num_blocks()) division.exact = true;
  if (division.exact) division.neighbours = division.num_blocks() / 2;
  if (division.meets_own_slice()) division.stride = division.parts;
  division.blocks_per_task = blocks_per_task(division);
  return division;
}

double run_division_task(const Division& division, std::int64_t task, const SliceList& list) {
  if (division.sorts_everything) return sorted_mean(division, list);
  const std::int64_t num_blocks = division.num_blocks();
  const std::int64_t first = task * division.blocks_per_task;
  const std::int64_t own = std::min(division.blocks_per_task, num_blocks - first);
  const std::vector<SampleBlock> blocks =
      load_blocks(division, first, std::min(own + division.neighbours * division.stride, num_blocks), list);
  CompensatedSum inside;
  CompensatedSum between;
  CompensatedSum in_slice;
  for (std::int64_t k = 0; k < own; ++k) {
    const SampleBlock& block = blocks[static_cast<std::size_t>(k)];
    inside.add(self_distance_sum(division.kind, division.channels, block));
    for (std::int64_t j = 1; j <= division.neighbours; ++j) {
      const SampleBlock& other = blocks[static_cast<std::size_t>((k + j * division.stride) % num_blocks)];
      const bool met_twice = division.exact && 2 * j == num_blocks;  // opposite each other on the ring
      between.add(cross_distance_sum(division.kind, division.channels, block, other) / (met_twice ? 2 : 1));
    }
    if (division.meets_own_slice()) {  // tasks have whole slices
      const std::int64_t next = k % division.parts + 1 < division.parts ? k + 1 : k + 1 - division.parts;
      in_slice.add(cross_distance_sum(division.kind, division.channels, block, blocks[static_cast<std::size_t>(next)]));
    }
  }
  const double all = division.num_samples() * division.num_samples();
  const Division::PairFactors factors = division.pair_factors();
  return inside.value() / all + factors.between * between.value() + factors.in_slice * in_slice.value();
}

}  // namespace noiseloom
