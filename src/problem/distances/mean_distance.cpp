// The mean distance m over all ordered pairs of a texture's samples.
//
// Beyond what can be done exactly, with mu_A the samples of block A as a measure, mu their mean and e_A = mu_A - mu:
//
//   m_AA = m + 2 m(mu, e_A) + m(e_A, e_A)        m_AB = m + m(mu, e_A) + m(mu, e_B) + m(e_A, e_B)
//
// In sum_A (n_A/N)^2 m_AA + (1 - sum_A (n_A/N)^2) <m_AB over neighbours on a ring>, blocks of equal size cancel every
// term of first order. What is left are the m(e_A, e_B) of the neighbours. Where blocks are slices that have nothing to
// do with each other, these have mean zero and, for samples without any order, standard deviation c m / n_A, so the
// relative error is c / sqrt(pairs looked at); c is 0.63 for a line, whose mean is found by sorting, and at most 0.45
// for the points, directions, rotations and axes made here (0.65 by their cosines): with 2^29 pairs, 2e-5. The test
// FromBlocksIsUnbiasedWithinTheStatedError holds lines to 0.67 to 1.5 of it.
//
// Larger slices are divided into blocks, each spread over the space as its slice is: samples that are near each other
// are dealt to different blocks. All e_A of a slice are then nearly the same, so it is as if all pairs of a slice and
// the next were looked at; pairs within slices have a ring of their own, as they are not independent. For slices that
// are stratified, as those of every texture made here, e_A is small itself: an estimate for 128x128x8 points or
// directions in the order of their pixels was off by 2e-9 and 4e-9 with 2^29 pairs a ring, where blocks that were dealt
// without looking at the samples had 4e-5 (FromBlocksDoesNotDependOnTheOrderOfTheList tries small ones).
#include <algorithm>
#include <vector>

#include "noiseloom/core/compensated_sum.h"
#include "noiseloom/problem/score.h"
#include "problem/distances/mean_distance_blocks.h"
#include "problem/distances/mean_distance_division.h"

namespace noiseloom {

MeanDistance::MeanDistance(DistanceKind kind, int channels, std::int64_t cells_per_slice, std::int32_t num_slices)
    : kind_(kind), channels_(channels), cells_per_slice_(cells_per_slice), num_slices_(num_slices) {
  NOISELOOM_CHECK(channels == 1 || (kind != DistanceKind::absolute && kind != DistanceKind::circle));
}

bool MeanDistance::exact() const { return divide_pairs(kind_, channels_, cells_per_slice_, num_slices_).exact; }

std::int64_t MeanDistance::num_pairs() const {
  const Division division = divide_pairs(kind_, channels_, cells_per_slice_, num_slices_);
  const double block = static_cast<double>(cells_per_slice_) / static_cast<double>(division.parts);
  const double met = 0.5 + static_cast<double>(division.neighbours) + (division.meets_own_slice() ? 1 : 0);
  return static_cast<std::int64_t>(division.num_samples() * block * met);
}

std::int64_t MeanDistance::num_tasks() const {
  return divide_pairs(kind_, channels_, cells_per_slice_, num_slices_).num_tasks();
}

double MeanDistance::task_bytes() const {
  const Division division = divide_pairs(kind_, channels_, cells_per_slice_, num_slices_);
  const auto cells = static_cast<double>(cells_per_slice_);
  const double list = 4.0 * channels_ * cells;
  // Blocks of two slices in double; and a slice on its way to them: with its order in space, then by blocks.
  if (division.parts > 1 && !division.exact) {
    return 4 * list + 24 * std::min(cells, static_cast<double>(largest_ordered_slice));
  }
  // The blocks of a task, and what a vector that grows keeps in reserve.
  return 2.25 * std::max(list, 4 * std::min(division.num_samples(), 0x1p20));
}

double MeanDistance::run_task(std::int64_t task, const SliceList& list) const {
  return run_division_task(divide_pairs(kind_, channels_, cells_per_slice_, num_slices_), task, list);
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
