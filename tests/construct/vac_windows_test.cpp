// Windows of one slice pick what is picked one by one from the whole field.
#include "construct/order/vac_windows.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>

#include "construct/full_scans.h"
#include "support/vac_specs.h"

namespace noiseloom {
namespace {

using namespace testing_support;

std::vector<std::uint64_t> all_positions(const VacSpec& spec) {
  std::vector<std::uint64_t> all(static_cast<std::size_t>(spec.extents.num_cells()));
  std::iota(all.begin(), all.end(), std::uint64_t{0});
  return all;
}

// Voids: from an empty slice. Clusters: from a full one.
VacField first_field(const VacSpec& spec, const VacKernel& kernel, VacView view) {
  VacField field(spec, kernel, 0, 1);
  if (view == VacView::clusters) field.turn(true, all_positions(spec));
  return field;
}

struct Batches {
  std::vector<std::uint64_t> order;
  std::size_t most = 0;
  std::size_t count = 0;
  std::size_t left_over = 0;
};

Batches by_windows(const VacSpec& spec, const VacKernel& kernel, VacView view, const VacWindows::Sizes& sizes) {
  VacField field = first_field(spec, kernel, view);
  ThreadPool pool(sizes.bands);
  VacWindows windows(spec, kernel, sizes, field, pool);
  field.refresh_bounds(view);
  windows.restart();
  Batches result;
  for (;; ++result.count) {
    const std::span<const std::uint64_t> picks = windows.take(view);
    if (picks.empty()) break;
    result.left_over += windows.num_left_over();
    result.most = std::max(result.most, picks.size());
    result.order.insert(result.order.end(), picks.begin(), picks.end());
    if (result.order.size() > static_cast<std::size_t>(spec.extents.num_cells())) break;
  }
  // All are on, or off: and what they add up to is what is added at once.
  VacField other = first_field(spec, kernel, view == VacView::voids ? VacView::clusters : VacView::voids);
  for (const std::uint64_t p : all_positions(spec)) EXPECT_EQ(field.words()[p], other.words()[p]) << p;
  return result;
}

void expect_the_order_of_one_by_one(const VacSpec& spec, std::int64_t rows) {
  SCOPED_TRACE(spec.extents.to_string());
  const VacKernel kernel(spec);
  const std::int64_t cells = spec.extents.num_cells();
  for (const VacView view : {VacView::voids, VacView::clusters}) {
    const std::vector<std::uint64_t> expected = oracle::picks_one_by_one(spec, first_field(spec, kernel, view), view);
    for (const int bands : {1, 3}) {
      for (const std::int64_t picks : {std::int64_t{1}, cells / 50, cells}) {
        const Batches batches = by_windows(spec, kernel, view, {bands, rows, picks});
        ASSERT_EQ(batches.order, expected) << bands << " bands, batches of " << picks;
        EXPECT_GT(batches.count, 1U);
      }
    }
  }
}

TEST(VacWindows, GiveTheOrderOfOneByOne) {
  expect_the_order_of_one_by_one(vac_spec({64, 72}, {{0, 1}}, 0.9), 24);
  expect_the_order_of_one_by_one(vac_spec({32, 131}, {{0, 1}}, 0.8, 2), 20);  // leaves of two rows, the last one short
  expect_the_order_of_one_by_one(vac_spec({13, 190}, {{0, 1}}, 0.7, 3), 64);  // leaves across rows
}

TEST(VacWindows, GiveTheSameWhereEdgesDoNotWrapAround) {
  VacSpec spec = vac_spec({64, 72}, {{0, 1}}, 0.9);
  spec.toroidal = {true, false};
  expect_the_order_of_one_by_one(spec, 24);
  spec.toroidal = {false, true};
  expect_the_order_of_one_by_one(spec, 24);
}

TEST(VacWindows, GiveTheSameWithTwoKernels) {
  VacSpec spec = vac_spec({64, 80}, {{0, 1}, {0, 1}}, 0.8);
  spec.groups[1].sigma_px = 1.2;
  spec.groups[1].weight = 0.2;
  expect_the_order_of_one_by_one(spec, 30);
}

// Then all is picked by the one selector of the whole slice.
TEST(VacWindows, GiveTheSameWhereWindowsAreTooNarrowForAnyPick) {
  const VacSpec spec = vac_spec({32, 70}, {{0, 1}}, 1.3);
  expect_the_order_of_one_by_one(spec, 6);
  EXPECT_EQ(by_windows(spec, VacKernel(spec), VacView::voids, {2, 6, 100}).left_over, 32U * 70U);
}

// As large as real ones, which pick nearly all before the selector of the whole slice is asked; against other windows.
TEST(VacWindows, GiveTheSameWhateverTheirSizes) {
  const VacSpec spec = vac_spec({192, 640}, {{0, 1}});
  const VacKernel kernel(spec);
  const auto usual = by_windows(spec, kernel, VacView::voids, {1, 208, 2000});
  EXPECT_LT(usual.most, 12000U);
  EXPECT_GT(usual.count, 40U);
  EXPECT_LT(usual.left_over, 1000U);
  EXPECT_EQ(by_windows(spec, kernel, VacView::voids, {3, 208, 2000}).order, usual.order);
  EXPECT_EQ(by_windows(spec, kernel, VacView::voids, {2, 100, 9000}).order, usual.order);
}

// A run that goes on from half, or from all points of a pattern, has no batches before that tell how large the next is.
TEST(VacWindows, TakeAboutAsManyAsWantedAfterARestart) {
  VacSpec spec = vac_spec({192, 640}, {{0, 1}});
  spec.density = 0.4;
  const VacKernel kernel(spec);
  constexpr std::size_t wanted = 1000;
  for (const VacView view : {VacView::voids, VacView::clusters}) {
    VacField field(spec, kernel, 0, 1);
    ThreadPool pool(2);
    VacWindows windows(spec, kernel, {2, 208, wanted}, field, pool);
    windows.turn_on(vac_start_pattern(spec));
    for (int phase = 0; phase < 3; ++phase) {
      field.refresh_bounds(view);
      windows.restart();
      for (int batch = 0; batch < 4; ++batch) {
        const std::size_t num = windows.take(view).size();
        EXPECT_GT(num, 0U);
        EXPECT_LT(num, 4 * wanted) << phase << ' ' << batch;
      }
    }
  }
}

// Whose candidates lie in bins of another kind.
TEST(VacWindows, GiveTheSameInVeryWideSlices) {
  VacSpec spec = vac_spec({33024, 16}, {{0, 1}}, 0.6);
  spec.density = 0;
  const Communicator self = Communicator::self();
  ThreadPool pool(1);
  VoidAndCluster plain(spec, self, pool);
  plain.start();
  while (!plain.done()) plain.advance(1'000'000);
  const std::vector<std::byte> bytes = plain.order(SliceIndex(0));
  const auto order = by_windows(spec, VacKernel(spec), VacView::voids, {2, 8, 5000}).order;
  ASSERT_EQ(order.size(), 33024U * 16U);
  for (std::uint64_t place = 0; place < order.size(); ++place) {
    ASSERT_EQ(plain.codec().get(bytes, order[place]), place);
  }
}

TEST(VacWindows, TurnOnAnyPixels) {
  for (const bool wraps : {true, false}) {
    VacSpec spec = vac_spec({64, 200}, {{0, 1}}, 1.3);
    spec.toroidal = {true, wraps};
    spec.density = 0.3;
    const VacKernel kernel(spec);
    const std::vector<std::uint64_t> points = vac_start_pattern(spec);
    VacField expected(spec, kernel, 0, 1);
    expected.turn(true, points);
    for (const int bands : {1, 2, 3}) {
      VacField field(spec, kernel, 0, 1);
      ThreadPool pool(bands);
      VacWindows(spec, kernel, {bands, 40, 100}, field, pool).turn_on(points);
      for (const std::uint64_t p : all_positions(spec)) ASSERT_EQ(field.words()[p], expected.words()[p]) << p;
    }
  }
}

TEST(VacWindows, AreForLargeSlicesAlone) {
  const auto bands = [](VacSpec spec, int threads) {
    const auto sizes = VacWindows::sizes(VacLayout(spec, 0, spec.extents.num_slices()), VacKernel(spec), threads);
    return sizes ? sizes->bands : 0;
  };
  EXPECT_EQ(bands(vac_spec({4096, 4096}, {{0, 1}}), 1), 1);
  EXPECT_EQ(bands(vac_spec({4096, 4096}, {{0, 1}}), 8), 8);
  EXPECT_EQ(bands(vac_spec({1024, 1024}, {{0, 1}}), 1), 0);  // which the third cache holds
  EXPECT_EQ(bands(vac_spec({512, 512}, {{0, 1}}), 64), 5);   // of more than eight reaches
  EXPECT_EQ(bands(vac_spec({256, 256}, {{0, 1}}), 2), 0);
  EXPECT_EQ(bands(vac_spec({65536, 64}, {{0, 1}}), 2), 0);  // lower than a window
  EXPECT_EQ(bands(vac_spec({4096, 4096, 2}, {{0, 1}, {2}}), 2), 0);
  EXPECT_EQ(bands(vac_spec({4096, 4096}, {{0, 1}, {1}}), 2), 0);  // a group over y
}

}  // namespace
}  // namespace noiseloom
