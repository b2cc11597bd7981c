#include "noiseloom/problem/footprint.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <memory>
#include <numeric>

#include "noiseloom/files/npy.h"
#include "support/filter_specs.h"
#include "support/oracle.h"

namespace noiseloom {
namespace {

using namespace testing_support;

// A .npy file that lives as long as the object.
class TableFile {
 public:
  TableFile(const std::string& name, const std::vector<std::int64_t>& shape, const std::vector<float>& values)
      : path_((std::filesystem::temp_directory_path() /
               ("noiseloom_footprint_" + std::to_string(getpid()) + name + ".npy"))
                  .string()) {
    write_npy(path_, shape, values);
  }
  ~TableFile() { std::filesystem::remove(path_); }
  TableFile(const TableFile&) = delete;
  TableFile& operator=(const TableFile&) = delete;
  const std::string& path() const { return path_; }

 private:
  std::string path_;
};

void expect_equal(const Extents& extents, const FilterSpec& filter) {
  const Footprint footprint(extents, filter);
  const oracle::Overlaps fast = oracle::overlaps(footprint);
  const oracle::Overlaps slow = oracle::overlaps(extents, filter);
  for (std::size_t d = 0; d < slow.size(); ++d) EXPECT_NEAR(fast[d], slow[d], 1e-12 * slow[0]) << "offset " << d;
  EXPECT_NEAR(footprint.weight_sum(), std::accumulate(slow.begin(), slow.end(), 0.0), 1e-12 * footprint.weight_sum());
}

TEST(Footprint, FoldsTheInfiniteLatticeOntoTorus) {
  const std::vector<Extents> shapes = {Extents({17, 13, 11}), Extents({7, 5, 3}), Extents({4, 6, 2}),
                                       Extents({2, 1, 7}),    Extents({1, 3, 1}), Extents({8, 2, 4})};
  for (const Extents& extents : shapes) {
    SCOPED_TRACE(extents.to_string());
    for (const KernelSpec& kernel :
         {box(1), box(4), box(5), box(13), gauss(0.05), gauss(1.3435), gauss(2.2), binomial(2), binomial(9),
          ema(0.1, 0.1), ema(0.3, 0.7), gauss_energy(0.4), gauss_energy(1.9)}) {
      SCOPED_TRACE("kernel " + std::to_string(static_cast<int>(kernel.kind)));
      expect_equal(extents, product({group({0, 1}, kernel)}));
      expect_equal(extents, product({group({0, 1}, kernel), group({2}, ema(0.4, 0.5))}));
      expect_equal(extents, sum({group({0, 1}, kernel, 0.25), group({2}, box(2), 0.75)}));
      expect_equal(extents, product({group({2, 0}, kernel)}));
    }
  }
}

TEST(Footprint, CombinesGroupsOverAnyOfFourSliceAxes) {
  const Extents extents({5, 3, 2, 3, 2, 3});
  expect_equal(extents, product({group({0, 1}, box(3)), group({2}, ema(0.4, 0.2)), group({3, 4}, gauss(0.7))}));
  expect_equal(extents, product({group({0, 3}, gauss_energy(0.8)), group({1, 5}, binomial(2))}));
  for (const int box : {1, 2, 5, 50}) {
    KernelSpec stacked = gauss_energy(0.8);
    stacked.box_axes = {3};
    stacked.box_size = box;
    expect_equal(extents, product({group({0, 1, 3}, stacked)}));
    expect_equal(extents, sum({group({0, 1}, gauss_energy(0.8), 0.5), group({0, 3}, stacked, 0.5)}));
  }
  expect_equal(extents, sum({group({0, 1}, gauss_energy(0.9), 0.5), group({2, 3}, gauss_energy(0.9), 0.3),
                             group({5}, box(2), 0.2)}));
  expect_equal(extents, sum({group({0, 1}, box(2), 0.5), group({1, 2}, box(2), 0.5)}));  // both hold offsets along y
}

TEST(Footprint, IsSymmetricToTheLastBit) {
  const Extents extents({6, 5, 4});
  const TableFile asymmetric("asymmetric", {3, 2, 4}, [] {
    std::vector<float> taps(24);
    for (std::size_t i = 0; i < taps.size(); ++i) taps[i] = 0.1F + static_cast<float>(i * i % 7) / 3;
    return taps;
  }());
  for (const FilterSpec& filter :
       {product({group({0, 1}, gauss(1.1)), group({2}, ema(0.1, 0.3))}), product({group({0, 1, 2}, gauss_energy(1.3))}),
        sum({group({0, 1}, gauss(2.2), 0.3), group({0, 2}, box(7), 0.7)}),
        product({group({0, 1, 2}, table(asymmetric.path()))})}) {
    const oracle::Overlaps f = oracle::overlaps(Footprint(extents, filter));
    for (std::size_t d = 0; d < f.size(); ++d) {
      const oracle::Coord coord = oracle::coord_of(extents, static_cast<std::int64_t>(d));
      EXPECT_EQ(f[d], f[oracle::flat_of(extents, oracle::difference({}, coord))]);
    }
  }
}

TEST(Footprint, OfProductSumsToSquareOfTheFilterSum) {
  const TableFile taps("sum", {5}, {0.5F, -0.25F, 2, 1, 0.125F});
  const double table_sum = 0.5 - 0.25 + 2 + 1 + 0.125;
  const Extents extents({11, 7, 5});
  EXPECT_NEAR(Footprint(extents, product({group({0, 1}, box(5)), group({2}, ema(0.1, 0.1))})).weight_sum(), 1, 1e-14);
  EXPECT_NEAR(Footprint(extents, product({group({0, 1}, gauss(3)), group({2}, binomial(4))})).weight_sum(), 1, 1e-14);
  EXPECT_NEAR(Footprint(extents, product({group({0, 1}, box(3)), group({2}, table(taps.path()))})).weight_sum(),
              table_sum * table_sum, 1e-13);
}

TEST(Footprint, ListsEachOffsetOnceInCanonicalOrder) {
  const Extents extents({4, 5, 2, 3});
  const Footprint footprint(extents, product({group({0, 1}, box(9)), group({2, 3}, ema(0.2, 0))}));
  ASSERT_EQ(footprint.slices().size(), 6U);
  EXPECT_EQ(footprint.num_taps(), extents.num_cells() - 1);
  EXPECT_EQ(footprint.slices()[0].offset, Extents::SliceCoord{});
  for (const SliceTaps& slice : footprint.slices()) {
    EXPECT_TRUE(slice.offset[0] >= 0 && slice.offset[0] <= 1);
    EXPECT_TRUE(slice.offset[1] >= -1 && slice.offset[1] <= 1);
    for (std::size_t k = 0; k < slice.taps.size(); ++k) {
      EXPECT_TRUE(slice.taps[k].dx >= -1 && slice.taps[k].dx <= 2);
      EXPECT_TRUE(slice.taps[k].dy >= -2 && slice.taps[k].dy <= 2);
      if (k == 0) continue;
      EXPECT_LT(std::pair(slice.taps[k - 1].dy, slice.taps[k - 1].dx), std::pair(slice.taps[k].dy, slice.taps[k].dx));
    }
  }
  for (std::size_t k = 2; k < 6; ++k) {
    const auto& a = footprint.slices()[k - 1].offset;
    const auto& b = footprint.slices()[k].offset;
    EXPECT_LT(std::pair(a[1], a[0]), std::pair(b[1], b[0]));
  }
  EXPECT_EQ(footprint.reach(0), 2);
  EXPECT_EQ(footprint.reach(1), 2);
  EXPECT_EQ(footprint.reach(2), 1);
  EXPECT_EQ(footprint.reach(3), 1);
}

TEST(Footprint, OfTemporalSumReachesOnlyTheSamePixel) {
  const Footprint footprint(Extents({11, 13, 7}), sum({group({0, 1}, box(3), 0.5), group({2}, box(3), 0.5)}));
  EXPECT_EQ(footprint.slices()[0].taps.size(), 24U);
  ASSERT_EQ(footprint.slices().size(), 5U);
  for (const SliceTaps& slice : footprint.slices().subspan(1)) {
    ASSERT_EQ(slice.taps.size(), 1U);
    EXPECT_EQ(slice.taps[0].dx, 0);
    EXPECT_EQ(slice.taps[0].dy, 0);
  }
  EXPECT_NEAR(footprint.weight_zero(), 0.5 / 9 + 0.5 / 3, 1e-16);
}

TEST(Footprint, TakesMissingWeightsAsEqual) {
  const Extents extents({5, 7, 3});
  const Footprint missing(extents, sum({group({0, 1}, box(3)), group({2}, box(2))}));
  const Footprint equal(extents, sum({group({0, 1}, box(3), 0.5), group({2}, box(2), 0.5)}));
  EXPECT_EQ(oracle::overlaps(missing), oracle::overlaps(equal));
}

TEST(Footprint, CutsGaussWhereItsSumReaches995Thousandths) {
  const Extents extents({101, 1});
  const auto taps_of = [&](double sigma) {
    return Footprint(extents, product({group({0}, gauss(sigma))})).num_taps() / 4 * 2 + 1;
  };
  EXPECT_EQ(taps_of(0.05), 1);
  EXPECT_EQ(taps_of(1.0), 7);     // erf(2.5 / sqrt 2) = 0.988, erf(3.5 / sqrt 2) = 0.9995
  EXPECT_EQ(taps_of(1.3435), 9);  // erf(3.5 / (1.3435 sqrt 2)) = 0.991, with 4.5 0.9992
}

TEST(Footprint, OfGaussWiderThanTextureIsFlat) {
  const Extents extents({7, 5, 3});
  for (const KernelSpec& kernel : {gauss(40), gauss_energy(40), box(7 * 5 * 3)}) {
    const oracle::Overlaps f = oracle::overlaps(Footprint(extents, product({group({0, 1, 2}, kernel)})));
    for (const double weight : f) EXPECT_NEAR(weight, f[0], 1e-2 * f[0]);
  }
}

TEST(Footprint, OfEmaIsOnlyTheCurrentFrameWhereHistoryHasNoPart) {
  for (const KernelSpec& kernel : {ema(1, 0), ema(1, 0.1), ema(1, 1), ema(0.1, 1), ema(1e-6, 1)}) {
    const Footprint footprint(Extents({1, 1, 7}), product({group({2}, kernel)}));
    EXPECT_FALSE(footprint.couples_slices());
    EXPECT_DOUBLE_EQ(footprint.weight_zero(), 1);
  }
}

TEST(Footprint, OfEmaWithoutRejectionIsEquation15) {
  for (const double alpha : {0.1, 0.5, 0.9}) {
    for (const std::int64_t n : {1, 2, 5, 31}) {
      const oracle::Overlaps f = oracle::overlaps(Footprint(Extents({1, 1, n}), product({group({2}, ema(alpha, 0))})));
      std::vector<double> folded(static_cast<std::size_t>(n), 0.0);
      for (std::int64_t d = -2000; d <= 2000; ++d) {
        folded[static_cast<std::size_t>((d % n + n) % n)] +=
            alpha * std::pow(1 - alpha, static_cast<double>(std::abs(d))) / (2 - alpha);
      }
      for (std::size_t d = 0; d < f.size(); ++d) EXPECT_NEAR(f[d], folded[d], 1e-14);
    }
  }
}

TEST(Footprint, OfEmaWithTinyAlphaAveragesAllFrames) {
  for (const std::int64_t n : {1, 2, 7, 64}) {
    const Footprint footprint(Extents({1, 1, n}), product({group({2}, ema(1e-6, 0))}));
    // Over n frames the weights alpha (1 - alpha)^k differ by n alpha.
    for (const double weight : oracle::overlaps(footprint)) EXPECT_NEAR(weight * static_cast<double>(n), 1, 1e-4);
    EXPECT_NEAR(footprint.weight_sum(), 1, 1e-13);
  }
}

TEST(Footprint, OfEmaIsContinuousWhereRejectionVanishes) {
  const Extents extents({1, 1, 31});
  const oracle::Overlaps none = oracle::overlaps(Footprint(extents, product({group({2}, ema(0.1, 0))})));
  const oracle::Overlaps rare = oracle::overlaps(Footprint(extents, product({group({2}, ema(0.1, 1e-9))})));
  for (std::size_t d = 0; d < none.size(); ++d) EXPECT_NEAR(none[d], rare[d], 1e-8);
}

TEST(Footprint, OfEmaAndBox5AmplifiesSixtyTwofoldOver32Slices) {
  const Footprint footprint(Extents({128, 128, 32}), product({group({0, 1}, box(5)), group({2}, ema(0.1, 0.1))}));
  EXPECT_NEAR(footprint.weight_sum() / footprint.weight_zero(), 62.13, 0.005);
}

TEST(Footprint, CutoffDropsSmallTapsAndNoOthers) {
  const Extents extents({13, 11, 7});
  const FilterSpec filter = product({group({0, 1}, gauss(1.2)), group({2}, ema(0.3, 0.1))});
  const Footprint whole(extents, filter);
  const Footprint cut(extents, filter, 1e-2);
  const oracle::Overlaps all = oracle::overlaps(whole);
  const oracle::Overlaps kept = oracle::overlaps(cut);
  EXPECT_LT(cut.num_taps(), whole.num_taps());
  for (std::size_t d = 0; d < all.size(); ++d) EXPECT_EQ(kept[d], all[d] < 1e-2 * all[0] ? 0 : all[d]);
  EXPECT_NEAR(cut.weight_sum(), std::accumulate(kept.begin(), kept.end(), 0.0), 1e-14);
  for (int axis = 0; axis < 3; ++axis) EXPECT_EQ(cut.reach(axis), whole.reach(axis));
}

// A group of so little weight that all of its taps are below the fraction of F(0) keeps those that it has to keep.
TEST(Footprint, CutoffOfASumIsOfEachGroupByItself) {
  const Extents extents({13, 11, 7});
  const GroupSpec plane = group({0, 1}, gauss(1.2), 0.99);
  const GroupSpec along = group({2}, ema(0.3, 0.1), 0.01);
  const oracle::Overlaps in_plane = oracle::overlaps(Footprint(extents, product({plane})));
  const oracle::Overlaps over_slices = oracle::overlaps(Footprint(extents, product({along})));
  const Footprint cut(extents, sum({plane, along}), 0.05);
  const oracle::Overlaps kept = oracle::overlaps(cut);
  const auto above = [](const oracle::Overlaps& f, std::size_t d) { return f[d] < 0.05 * f[0] ? 0 : f[d]; };
  for (std::size_t d = 0; d < kept.size(); ++d) {
    EXPECT_NEAR(kept[d], 0.99 * above(in_plane, d) + 0.01 * above(over_slices, d), 1e-16) << d;
  }
  EXPECT_EQ(cut.reach(0), Footprint(extents, product({plane})).reach(0));
  ASSERT_TRUE(cut.couples_slices());
  EXPECT_LT(cut.slices()[1].taps[0].weight, 0.05 * cut.weight_zero());
}

void expect_factors(const Extents& extents, const FilterSpec& filter) {
  const Footprint footprint(extents, filter);
  ASSERT_TRUE(footprint.factors());
  const oracle::Overlaps f = oracle::overlaps(footprint);
  oracle::Overlaps multiplied(f.size(), 0.0);
  EXPECT_EQ(footprint.factors()->along[0].first, Extents::SliceCoord{});
  for (const auto& [offset, weight] : footprint.factors()->along) {
    for (const PlaneTap& tap : footprint.factors()->plane) {
      oracle::Coord d{tap.dx, tap.dy};
      for (std::size_t k = 0; k < offset.size(); ++k) d[k + 2] = offset[k];
      multiplied[oracle::flat_of(extents, d)] += weight * tap.weight;
    }
  }
  for (std::size_t d = 0; d < f.size(); ++d) EXPECT_NEAR(multiplied[d], f[d], 1e-15);
}

TEST(Footprint, FactorsMultiplyToTheOverlap) {
  const Extents extents({5, 7, 3, 2});
  expect_factors(extents, product({group({0, 1}, box(3)), group({2}, ema(0.1, 0.1))}));
  expect_factors(extents, product({group({0, 1}, gauss_energy(1)), group({2, 3}, gauss_energy(0.7))}));
  expect_factors(extents, product({group({0, 1, 2}, gauss(0.8))}));  // separable, so it does not matter that axes mix
  expect_factors(extents, product({group({3}, box(2))}));
  expect_factors(extents, sum({group({0, 1}, box(3), 0.4), group({0}, gauss(1), 0.6)}));  // no slices are coupled
}

TEST(Footprint, HasNoFactorsWherePlaneAndSlicesMix) {
  const Extents extents({5, 7, 3});
  EXPECT_FALSE(Footprint(extents, product({group({0, 1, 2}, gauss_energy(1))})).factors());
  EXPECT_FALSE(Footprint(extents, sum({group({0, 1}, box(3), 0.5), group({2}, box(2), 0.5)})).factors());
}

TEST(Footprint, OfTableAgreesWithLattice) {
  const TableFile line("line", {4}, {1, 0, -0.5F, 3});
  const TableFile plane("plane", {2, 3}, {1, 2, 4, -8, 0, 32});
  const TableFile cube("cube", {3, 1, 2}, {1, 2, 3, 4, 5, 7});
  for (const Extents& extents : {Extents({11, 7, 5}), Extents({2, 1, 2}), Extents({3, 4, 2})}) {
    expect_equal(extents, product({group({0, 2}, table(line.path()))}));
    expect_equal(extents, product({group({0, 1}, table(plane.path()))}));
    expect_equal(extents, product({group({2, 1, 0}, table(cube.path()))}));
    expect_equal(extents, sum({group({0, 1}, table(plane.path()), 0.5), group({2}, table(line.path()), 0.5)}));
  }
}

TEST(Footprint, TableDimensionsAreInFileOrder) {
  const TableFile row("row", {1, 3}, {1, 1, 1});  // [y][x]: three taps along x
  for (const std::vector<int>& axes : {std::vector<int>{0, 1}, std::vector<int>{1, 0}}) {
    const Footprint footprint(Extents({11, 13}), product({group(axes, table(row.path()))}));
    EXPECT_EQ(footprint.reach(0), 2);
    EXPECT_EQ(footprint.reach(1), 0);
  }
}

// Nothing may take time or memory in proportion to the length of an axis.
TEST(Footprint, OfABillionSlicesIsFoundAtOnce) {
  const Extents extents({5, 5, std::int64_t{1} << 30});
  const Extents shorter({5, 5, 16'384});
  for (const KernelSpec& kernel : {box(31), ema(0.1, 0.1), gauss(2), gauss_energy(3), box(40'000)}) {
    const Footprint wide(extents, product({group({0}, box(3)), group({2}, kernel)}));
    if (kernel.size > 100) continue;  // longer than the other ring
    const Footprint narrow(shorter, product({group({0}, box(3)), group({2}, kernel)}));
    EXPECT_EQ(wide.num_taps(), narrow.num_taps());
    EXPECT_EQ(wide.weight_sum(), narrow.weight_sum());
    EXPECT_EQ(wide.reach(2), narrow.reach(2));
  }
}

std::string refusal(const std::string& file, const std::vector<int>& axes,
                    const Extents& extents = Extents({5, 7, 3})) {
  try {
    Footprint(extents, product({group(axes, table(file))}));
  } catch (const UserError& error) {
    return error.what();
  }
  return "accepted";
}

TEST(Footprint, RefusesUnusableTablesByNameAndPlace) {
  using testing::HasSubstr;
  const TableFile nan("nan", {3}, {1, std::nanf(""), 2});
  const TableFile zeros("zeros", {2}, {0, 0});
  const TableFile plane("dimensions", {1, 2}, {1, 1});
  const TableFile empty("empty", {0}, {});
  EXPECT_THAT(refusal(nan.path(), {0}), testing::AllOf(HasSubstr(nan.path()), HasSubstr("tap 1 is nan")));
  EXPECT_THAT(refusal(zeros.path(), {0}), HasSubstr("all taps are zero"));
  EXPECT_THAT(refusal(empty.path(), {0}), HasSubstr("all taps are zero"));
  EXPECT_THAT(refusal(plane.path(), {0, 1, 2}), HasSubstr("2 dimensions; a group of 3 axes takes 1 or 3"));
  EXPECT_THAT(refusal(plane.path() + ".missing", {0}), HasSubstr(plane.path() + ".missing"));
}

FilterSpec known_taps(const std::vector<int>& axes, const std::vector<double>& taps) {
  FilterSpec filter = product({});
  for (const int axis : axes) {
    filter.groups.push_back(group({axis}, table("known.npy")));
    const InputArray array{{static_cast<std::int64_t>(taps.size())}, taps};
    filter.groups.back().kernel.array = std::make_shared<InputArray>(array);
  }
  return filter;
}

TEST(Footprint, RefusesTablesThatCancelWhereTheyAreFolded) {
  using testing::HasSubstr;
  const TableFile difference("difference", {2}, {1, -1});
  const TableFile waves("waves", {2, 2}, {1, -1, -1, 1});
  EXPECT_EQ(refusal(difference.path(), {1}, Extents({1, 2})), "accepted");
  EXPECT_EQ(refusal(waves.path(), {0, 1}, Extents({2, 2})), "accepted");
  const auto says = [](const TableFile& file) {
    return testing::AllOf(HasSubstr(file.path()), HasSubstr("cancel each other"));
  };
  EXPECT_THAT(refusal(difference.path(), {0}, Extents({1, 2})), says(difference));
  EXPECT_THAT(refusal(waves.path(), {0, 1}, Extents({1, 2})), says(waves));
  const std::vector<double> all_but_rounding = {0.1, 0.2, -0.3};
  EXPECT_NO_THROW(Footprint(Extents({2, 1}), known_taps({0}, all_but_rounding)));
  EXPECT_THROW(Footprint(Extents({1, 2}), known_taps({0}, all_but_rounding)), UserError);
}

TEST(Footprint, RefusesProductsThatAreNoNumbers) {
  const Extents extents({5, 7});
  for (const double tap : {1e-70, 1e70}) EXPECT_NO_THROW(Footprint(extents, known_taps({0, 1}, {tap, tap})));
  for (const double tap : {1e-100, 1e100}) {
    EXPECT_NO_THROW(Footprint(extents, known_taps({0}, {tap, tap})));
    EXPECT_THROW(Footprint(extents, known_taps({0, 1}, {tap, tap})), UserError);
  }
}

// What takes squared time is refused by name; taps that fold onto a short axis do not count.
TEST(Footprint, RefusesTablesTooLongToCorrelate) {
  using testing::HasSubstr;
  const TableFile line("longline", {131'073}, std::vector<float>(131'073, 0.5F));
  const TableFile plane("wideplane", {300, 300}, std::vector<float>(90'000, 0.5F));
  EXPECT_EQ(refusal(line.path(), {0}), "accepted");
  EXPECT_EQ(refusal(plane.path(), {0, 1}), "accepted");
  EXPECT_THAT(refusal(line.path(), {0}, Extents({200'000, 1})),
              testing::AllOf(HasSubstr(line.path()), HasSubstr("131073 taps"), HasSubstr("at most 131072")));
  EXPECT_THAT(refusal(plane.path(), {0, 1}, Extents({512, 512})),
              testing::AllOf(HasSubstr(plane.path()), HasSubstr("90000 taps"), HasSubstr("at most 65536")));
}

}  // namespace
}  // namespace noiseloom
