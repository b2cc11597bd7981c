// Picks that wait until their surroundings are looked at: nothing that can be asked of a field tells.
#include <gtest/gtest.h>
#include <hwy/highway.h>

#include <algorithm>
#include <limits>
#include <random>

#include "construct/fields/vac_field.h"
#include "support/vac_specs.h"

namespace noiseloom {
namespace {

using namespace testing_support;

constexpr std::int64_t never = std::numeric_limits<std::int64_t>::max();

void expect_same(VacField& waiting, VacField& prompt) {
  for (std::uint64_t p = 0; p < static_cast<std::uint64_t>(prompt.layout().cells * prompt.layout().num_slices); ++p) {
    if (!prompt.has(p)) continue;
    ASSERT_EQ(waiting.word(p), prompt.word(p)) << p;
  }
}

// Turns on all pixels in batches, some of which crowd a corner so that bins overflow, and scans with limits that open
// some of the leaves.
void expect_waiting_changes_nothing(const VacSpec& spec, std::int32_t begin, std::int32_t end) {
  const VacKernel kernel(spec);
  ASSERT_TRUE(VacPending::make(VacLayout(spec, begin, end), kernel)) << "this test would compare like with like";
  VacField waiting(spec, kernel, begin, end, 0);
  VacField prompt(spec, kernel, begin, end, never);
  waiting.refresh_bounds(VacView::voids);
  prompt.refresh_bounds(VacView::voids);
  std::vector<std::uint64_t> left(static_cast<std::size_t>(spec.extents.num_cells()));
  for (std::size_t i = 0; i < left.size(); ++i) left[i] = i;
  std::mt19937_64 random(spec.seed);
  std::shuffle(left.begin(), left.end(), random);
  std::sort(left.end() - 3000, left.end());  // the batches at the back, which come first
  const VacTieHash hash(spec.seed);
  std::vector<std::uint64_t> batch;
  for (int round = 0; !left.empty(); ++round) {
    const std::size_t count = std::min<std::size_t>(left.size(), 10 + random() % 60);
    batch.assign(left.end() - static_cast<std::ptrdiff_t>(count), left.end());
    left.resize(left.size() - count);
    std::sort(batch.begin(), batch.end());
    waiting.turn(true, batch);
    prompt.turn(true, batch);
    if (round % 3 == 0) continue;
    std::vector<std::uint32_t> bounds(prompt.bounds().begin(), prompt.bounds().end());
    std::nth_element(bounds.begin(), bounds.begin() + static_cast<std::ptrdiff_t>(bounds.size() / 8), bounds.end());
    const std::uint64_t limit = (std::uint64_t{bounds[bounds.size() / 8]} << 32) | 0x7FFFFFFFU;
    waiting.scan({VacView::voids, hash, limit, left.size() + count});
    ASSERT_TRUE(waiting.found_all());
    prompt.scan({VacView::voids, hash, limit, left.size() + count});
    ASSERT_TRUE(prompt.found_all());
    const std::vector<VacCandidate>& found_waiting = waiting.found();
    const std::vector<VacCandidate>& found_prompt = prompt.found();
    ASSERT_EQ(found_waiting.size(), found_prompt.size());
    for (std::size_t i = 0; i < found_prompt.size(); ++i) {
      ASSERT_EQ(found_waiting[i].position, found_prompt[i].position);
      ASSERT_EQ(found_waiting[i].key(), found_prompt[i].key());
    }
    waiting.end_of_batch();
    prompt.end_of_batch();
    ASSERT_TRUE(std::equal(prompt.bounds().begin(), prompt.bounds().end(), waiting.bounds().begin()));
    if (round == 10) {  // turning off and on again does not wait, and leaves nothing behind
      waiting.turn(false, batch);
      prompt.turn(false, batch);
      expect_same(waiting, prompt);
      waiting.turn(true, batch);
      prompt.turn(true, batch);
    }
  }
  expect_same(waiting, prompt);
}

TEST(VacPending, ChangesNothingInOneSlice) {
  expect_waiting_changes_nothing(vac_spec({256, 128}, {{0, 1}}, 1.9), 0, 1);
}

TEST(VacPending, ChangesNothingWhereLeavesCrossRowsAndTheLastOnesAreShort) {
  expect_waiting_changes_nothing(vac_spec({241, 123}, {{0, 1}}, 1.9, 2), 0, 1);
}

TEST(VacPending, ChangesNothingAtEdgesThatDoNotWrapAround) {
  VacSpec spec = vac_spec({233, 131}, {{0, 1}}, 1.7, 3);
  spec.toroidal = {false, true};
  expect_waiting_changes_nothing(spec, 0, 1);
  spec.toroidal = {true, false};
  expect_waiting_changes_nothing(spec, 0, 1);
}

TEST(VacPending, ChangesNothingInSomeSlicesOfMany) {
  expect_waiting_changes_nothing(vac_spec({220, 121, 4}, {{0, 1}, {2}}, 1.1, 4), 1, 3);
}

TEST(VacPending, ChangesNothingWithTwoKernelsOverAPlane) {
  VacSpec spec = vac_spec({264, 132}, {{0, 1}, {0, 1}}, 1.3, 5);
  spec.groups[1].sigma_px = 2.4;
  spec.groups[1].weight = 0.1;
  expect_waiting_changes_nothing(spec, 0, 1);
}

TEST(VacPending, ChangesNothingOnAnyInstructionSet) {
  for (std::int64_t rest = hwy::SupportedTargets() & HWY_TARGETS; rest != 0; rest &= rest - 1) {
    const std::int64_t target = rest & -rest;
    hwy::SetSupportedTargetsForTest(target);
    hwy::GetChosenTarget().DeInit();
    SCOPED_TRACE(hwy::TargetName(target));
    expect_waiting_changes_nothing(vac_spec({231, 122}, {{0, 1}}, 1.5, 6), 0, 1);
  }
  hwy::SetSupportedTargetsForTest(0);
  hwy::GetChosenTarget().DeInit();
}

TEST(VacPending, IsNotForSlicesThatAFootprintNearlyGoesRound) {
  const auto may_wait = [](std::vector<std::int64_t> sizes, double sigma) {
    const VacSpec spec = vac_spec(std::move(sizes), {{0, 1}}, sigma);
    const VacKernel kernel(spec);
    return VacPending::make(VacLayout(spec, 0, 1), kernel).has_value();
  };
  EXPECT_TRUE(may_wait({256, 128}, 1.9));
  EXPECT_FALSE(may_wait({190, 128}, 1.9));
  EXPECT_FALSE(may_wait({256, 80}, 1.9));
  EXPECT_FALSE(may_wait({4096, 4096}, 9));  // its table of weights would not stay in the first cache
}

}  // namespace
}  // namespace noiseloom
