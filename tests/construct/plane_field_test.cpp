#include "construct/plane_field.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <optional>

#include "construct/full_scans.h"
#include "construct/stamp_kernel.h"
#include "noiseloom/core/random.h"
#include "support/construct_problems.h"

namespace noiseloom {
namespace {

using namespace testing_support;

// The pixels of a slice and of those that act on it, changed at random; and the same energies from nothing.
class ChangingPlane {
 public:
  explicit ChangingPlane(const ConstructProblem& problem)
      : kernel_(problem.extents, problem.filter, problem.spec.sharpness),
        cells_(static_cast<std::uint32_t>(problem.extents.cells_per_slice())),
        hash_(problem.seed),
        field_(kernel_, hash_, first_position),
        others_on_(kernel_.stamps().size(), std::vector<bool>(cells_)) {
    field_.clear();
  }

  PlaneField& field() { return field_; }
  std::uint32_t num_cells() const { return cells_; }
  std::size_t num_stamps() const { return kernel_.stamps().size(); }

  void turn(std::uint32_t cell) { field_.is_on(cell) ? field_.turn_off(cell) : field_.turn_on(cell); }
  void turn_of_other(std::size_t stamp, std::uint32_t cell) {
    const bool on = !others_on_[stamp][cell];
    others_on_[stamp][cell] = on;
    field_.act(kernel_.stamps()[stamp], on, std::array{cell});
  }

  void expect_words_as_from_nothing() const {
    PlaneField fresh(kernel_, hash_, first_position);
    fresh.clear();
    for (std::uint32_t cell = 0; cell < cells_; ++cell) {
      if (field_.is_on(cell)) fresh.turn_on(cell);
    }
    for (std::size_t stamp = 1; stamp < others_on_.size(); ++stamp) {
      std::vector<std::uint32_t> on;
      for (std::uint32_t cell = 0; cell < cells_; ++cell) {
        if (others_on_[stamp][cell]) on.push_back(cell);
      }
      fresh.act(kernel_.stamps()[stamp], true, on);
    }
    for (std::uint32_t cell = 0; cell < cells_; ++cell) ASSERT_EQ(field_.word(cell), fresh.word(cell)) << cell;
  }

  // By a full scan.
  std::optional<std::uint32_t> expected_pick(VacView view) const {
    return oracle::pick_of(field_, cells_, hash_, first_position, view);
  }

 private:
  static constexpr std::uint64_t first_position = 12345;
  StampKernel kernel_;
  std::uint32_t cells_;
  VacTieHash hash_;
  PlaneField field_;
  std::vector<std::vector<bool>> others_on_;  // by the stamp that leads here
};

std::vector<ConstructProblem> plane_problems() {
  std::vector<ConstructProblem> problems = construct_problems();
  problems.push_back(construct_problem("ties", {13, 11, 3}, product({group({2}, ema(0.1, 0.1))})));
  problems.push_back(construct_problem("two branches", {67, 65}, product({group({0, 1}, gauss(1))})));
  problems.push_back(construct_problem("whole leaves", {64, 4}, product({group({0, 1}, gauss(2))})));
  problems.push_back(construct_problem("one pixel", {1, 1, 3}, product({group({2}, box(2))})));
  problems.push_back(construct_problem("folded", {5, 3, 3}, product({group({0, 1}, gauss(8)), group({2}, box(5))})));
  return problems;
}

// The numbers that a test draws, one after the other.
class Draws {
 public:
  std::uint32_t below(std::size_t bound) {
    return to_below(random_block(7, Purpose::jitter, 0, 0, count_++)[0], bound);
  }

 private:
  std::uint64_t count_ = 0;
};

TEST(PlaneField, HasTheEnergiesOfAFreshOneAfterAnyChanges) {
  for (const ConstructProblem& problem : plane_problems()) {
    SCOPED_TRACE(problem.name);
    ChangingPlane plane(problem);
    Draws draws;
    for (int change = 0; change < 500; ++change) {
      const std::uint32_t cell = draws.below(plane.num_cells());
      const std::size_t stamp = draws.below(plane.num_stamps());
      stamp == 0 ? plane.turn(cell) : plane.turn_of_other(stamp, cell);
    }
    plane.expect_words_as_from_nothing();
  }
}

// Both views are watched, and values rise and fall in both.
TEST(PlaneField, PicksAsAFullScanWhateverChanges) {
  for (const ConstructProblem& problem : plane_problems()) {
    SCOPED_TRACE(problem.name);
    ChangingPlane plane(problem);
    plane.field().watch(true, true);
    Draws draws;
    for (int change = 0; change < 200; ++change) {
      const std::uint32_t cell = draws.below(plane.num_cells());
      const std::size_t stamp = draws.below(4) == 0 ? draws.below(plane.num_stamps()) : 0;
      stamp == 0 ? plane.turn(cell) : plane.turn_of_other(stamp, cell);
      ASSERT_EQ(plane.field().pick(VacView::voids), plane.expected_pick(VacView::voids)) << change;
      ASSERT_EQ(plane.field().pick(VacView::clusters), plane.expected_pick(VacView::clusters)) << change;
    }
  }
}

// Until all are on, then until all are off, and on again, with changes of other slices in between: the bounds of one
// view hold without any work, and are asked only now and then.
TEST(PlaneField, PicksAsAFullScanWhileOneViewIsWatched) {
  for (const ConstructProblem& problem : plane_problems()) {
    SCOPED_TRACE(problem.name);
    ChangingPlane plane(problem);
    Draws draws;
    const auto others = [&] {
      if (plane.num_stamps() == 1 || draws.below(3) > 0) return;
      plane.turn_of_other(1 + draws.below(plane.num_stamps() - 1), draws.below(plane.num_cells()));
    };
    for (const VacView view : {VacView::voids, VacView::clusters, VacView::voids}) {
      plane.field().watch(view == VacView::voids, view == VacView::clusters);
      for (std::uint32_t turned = 0; turned < plane.num_cells(); ++turned) {
        others();
        const auto pick = plane.field().pick(view);
        ASSERT_TRUE(pick.has_value());
        if (turned < 100 || turned + 100 > plane.num_cells()) {
          ASSERT_EQ(pick, plane.expected_pick(view)) << turned;
        }
        plane.turn(*pick);
      }
      EXPECT_EQ(plane.field().pick(view), std::nullopt);
    }
    plane.expect_words_as_from_nothing();
  }
}

TEST(PlaneField, HasNothingToPickWhereNothingIsOnOrOff) {
  ChangingPlane plane(construct_problem("small", {3, 2}, product({group({0, 1}, gauss(1))})));
  plane.field().watch(true, true);
  EXPECT_EQ(plane.field().pick(VacView::clusters), std::nullopt);
  for (std::uint32_t cell = 0; cell < 6; ++cell) plane.turn(cell);
  EXPECT_EQ(plane.field().pick(VacView::voids), std::nullopt);
  EXPECT_NE(plane.field().pick(VacView::clusters), std::nullopt);
}

}  // namespace
}  // namespace noiseloom
