#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <limits>
#include <numeric>
#include <utility>

#include "noiseloom/core/error.h"
#include "noiseloom/core/random.h"
#include "noiseloom/files/npy.h"
#include "noiseloom/samples/sample_space.h"

namespace noiseloom {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using Shape = std::vector<std::int64_t>;

constexpr float nan = std::numeric_limits<float>::quiet_NaN();
constexpr float infinity = std::numeric_limits<float>::infinity();

// A .npy file for the time of a test.
class SampleFileTest : public ::testing::Test {
 protected:
  SampleFileTest() : path_(::testing::TempDir() + "noiseloom_samples_" + std::to_string(::getpid()) + ".npy") {}
  ~SampleFileTest() override { std::filesystem::remove(path_); }

  SampleSource source(const Shape& shape, const std::vector<float>& values, std::int64_t cells, std::int32_t slices,
                      DistanceKind distance = DistanceKind::euclidean) const {
    write_npy(path_, shape, values);
    return opened(cells, slices, distance);
  }
  SampleSource opened(std::int64_t cells, std::int32_t slices, DistanceKind distance) const {
    SampleSpec spec;
    spec.space = "file";
    spec.file = path_;
    spec.distance = distance;
    return SampleSource(spec, cells, slices, 1);
  }
  std::vector<Fault> faults(const Shape& shape, const std::vector<float>& values, std::int64_t cells,
                            std::int32_t slices, DistanceKind distance = DistanceKind::euclidean) const {
    try {
      source(shape, values, cells, slices, distance);
    } catch (const UserError& error) {
      return error.faults();
    }
    return {};
  }
  std::string fault(const Shape& shape, const std::vector<float>& values, std::int64_t cells, std::int32_t slices,
                    DistanceKind distance = DistanceKind::euclidean) const {
    const std::vector<Fault> all = faults(shape, values, cells, slices, distance);
    EXPECT_EQ(all.size(), 1U);
    if (all.empty()) return "";
    EXPECT_EQ(all[0].where, path_);
    return all[0].text;
  }

  std::string path_;
};

// The samples' bits, each sample a row, rows sorted.
std::vector<std::vector<std::uint32_t>> sorted_rows(const std::vector<float>& values, std::size_t channels) {
  std::vector<std::vector<std::uint32_t>> rows;
  for (std::size_t i = 0; i < values.size(); i += channels) {
    std::vector<std::uint32_t> row;
    for (std::size_t c = 0; c < channels; ++c) row.push_back(std::bit_cast<std::uint32_t>(values[i + c]));
    rows.push_back(row);
  }
  std::sort(rows.begin(), rows.end());
  return rows;
}

std::vector<float> random_values(std::size_t count, std::uint64_t seed) {
  std::vector<float> values;
  for (std::size_t i = 0; i < count; ++i) {
    values.push_back(to_unit_float(random_block(seed, Purpose::subset, 0, 0, i)[0]));
  }
  return values;
}

TEST_F(SampleFileTest, OneListServesEverySliceInAscendingOrder) {
  const SampleSource samples = source({5}, {3, -1, 0.5F, 2, -7}, 5, 4);
  EXPECT_EQ(samples.channels(), 1);
  EXPECT_EQ(samples.distance(), DistanceKind::absolute);
  EXPECT_FALSE(samples.has_pdf());
  for (const SliceIndex slice : first_indices<SliceIndex>(4))
    EXPECT_THAT(samples.list(slice), ElementsAre(-7, -1, 0.5F, 2, 3));
}

TEST_F(SampleFileTest, OneListPerSliceStaysWithItsSlice) {
  const SampleSource samples = source({2, 3}, {3, 1, 2, 30, 10, 20}, 3, 2);
  EXPECT_THAT(samples.list(SliceIndex(0)), ElementsAre(1, 2, 3));
  EXPECT_THAT(samples.list(SliceIndex(1)), ElementsAre(10, 20, 30));
  const SampleSource vectors = source({2, 3, 2}, {3, 0, 1, 0, 2, 0, 0, 30, 0, 10, 0, 20}, 3, 2);
  EXPECT_EQ(vectors.channels(), 2);
  EXPECT_THAT(vectors.list(SliceIndex(0)), ElementsAre(1, 0, 2, 0, 3, 0));
  EXPECT_THAT(vectors.list(SliceIndex(1)), ElementsAre(0, 10, 0, 20, 0, 30));
}

TEST_F(SampleFileTest, SamplesAreKeptBitForBit) {
  for (const std::size_t channels : {1U, 2U, 3U, 8U}) {
    const std::int64_t n = 1009;
    std::vector<float> values = random_values(static_cast<std::size_t>(n) * channels, channels);
    values[0] = -0.0F;
    values[7] = 0.0F;
    values[9] = std::numeric_limits<float>::min();
    values[11] = 9e17F;
    values[12] = -9e17F;
    const SampleSource samples = source({n, static_cast<std::int64_t>(channels)}, values, n, 3);
    EXPECT_EQ(sorted_rows(samples.list(SliceIndex(1)), channels), sorted_rows(values, channels));
    EXPECT_EQ(samples.list(SliceIndex(1)), samples.list(SliceIndex(1)));
  }
}

TEST_F(SampleFileTest, EqualAndTwoValuedSamplesAreLegal) {
  EXPECT_EQ(source({101, 3}, std::vector<float>(303, 0.25F), 101, 1).list(SliceIndex(0)),
            std::vector<float>(303, 0.25F));
  std::vector<float> two(202);
  for (std::size_t i = 0; i < 101; ++i) two[2 * i] = i % 2 == 0 ? 1 : -1;
  const std::vector<float> list = source({101, 2}, two, 101, 1).list(SliceIndex(0));
  EXPECT_EQ(sorted_rows(list, 2), sorted_rows(two, 2));
  EXPECT_EQ(std::count(list.begin(), list.begin() + 100, -1.0F), 50);
}

TEST_F(SampleFileTest, NeighboursInTheListAreNeighboursInSpace) {
  const std::int64_t n = 4099;
  const std::vector<float> values = random_values(2 * static_cast<std::size_t>(n), 5);
  const std::vector<float> list = source({n, 2}, values, n, 1).list(SliceIndex(0));
  double near = 0;
  double as_given = 0;
  for (std::size_t i = 2; i < list.size(); i += 2) {
    near += distance(DistanceKind::euclidean, 2, &list[i - 2], &list[i]);
    as_given += distance(DistanceKind::euclidean, 2, &values[i - 2], &values[i]);
  }
  EXPECT_LT(near, 0.1 * as_given);
}

// The slow twin: sorts whole ranges by (widest channel, place in the file).
void order_slowly(const std::vector<float>& values, std::size_t channels, std::vector<std::size_t>& ids,
                  std::size_t first, std::size_t last) {
  if (last - first < 2) return;
  const auto begin = ids.begin() + static_cast<std::ptrdiff_t>(first);
  const auto end = ids.begin() + static_cast<std::ptrdiff_t>(last);
  std::size_t widest = 0;
  float width = -1;
  for (std::size_t c = 0; c < channels; ++c) {
    const auto by_value = [&](std::size_t a, std::size_t b) {
      return values[a * channels + c] < values[b * channels + c];
    };
    const auto [low, high] = std::minmax_element(begin, end, by_value);
    const float extent = values[*high * channels + c] - values[*low * channels + c];
    if (extent > width) widest = c;
    width = std::max(width, extent);
  }
  std::sort(begin, end, [&](std::size_t a, std::size_t b) {
    return std::pair(values[a * channels + widest], a) < std::pair(values[b * channels + widest], b);
  });
  order_slowly(values, channels, ids, first, first + (last - first) / 2);
  order_slowly(values, channels, ids, first + (last - first) / 2, last);
}

TEST_F(SampleFileTest, OrderOfVectorsEqualsItsSlowTwin) {
  const std::size_t n = 4099;
  const std::vector<float> random = random_values(3 * n, 8);
  for (int pattern = 0; pattern < 4; ++pattern) {
    std::vector<float> values = random;
    for (std::size_t i = 0; i < n && pattern > 0; ++i) {
      const float organ_pipe = static_cast<float>(std::min(i, n - i));
      const float x = static_cast<float>(i);
      values[3 * i] = pattern == 1 ? x : pattern == 2 ? organ_pipe : std::floor(4 * random[i]);
      values[3 * i + 1] = pattern == 1 ? -x : pattern == 2 ? organ_pipe / 2 : std::floor(4 * random[i + n]);
    }
    std::vector<std::size_t> ids(n);
    std::iota(ids.begin(), ids.end(), std::size_t{0});
    order_slowly(values, 3, ids, 0, n);
    const std::vector<float> list = source({static_cast<std::int64_t>(n), 3}, values, 4099, 1).list(SliceIndex(0));
    for (std::size_t i = 0; i < n; ++i) {
      for (std::size_t c = 0; c < 3; ++c) ASSERT_EQ(list[3 * i + c], values[3 * ids[i] + c]) << "pattern " << pattern;
    }
  }
}

TEST_F(SampleFileTest, DoublesAreRoundedToFloat) {
  const std::string header = "{'descr': '<f8', 'fortran_order': False, 'shape': (2,)}";
  const std::vector<double> values = {0.1, -1e-30};
  std::ofstream file(path_, std::ios::binary);
  file << std::string("\x93NUMPY\x01\x00", 8) << static_cast<char>(header.size()) << '\0' << header;
  file.write(reinterpret_cast<const char*>(values.data()), 16);
  file.close();
  EXPECT_THAT(opened(2, 1, DistanceKind::absolute).list(SliceIndex(0)), ElementsAre(-1e-30F, 0.1F));
}

TEST_F(SampleFileTest, NamesValuesThatAreNotFiniteByPosition) {
  EXPECT_EQ(fault({3}, {1, nan, 2}, 3, 2), "sample 1 = nan: samples must be finite");
  EXPECT_EQ(fault({3, 2}, {1, 2, 3, 4, 5, -infinity}, 3, 2), "sample 2, channel 1 = -inf: samples must be finite");
  EXPECT_EQ(fault({2, 3}, {1, 2, 3, 4, infinity, 5}, 3, 2), "slice 1, sample 1 = inf: samples must be finite");
  EXPECT_EQ(fault({2, 2, 2}, {1, 2, 3, 4, 5, 6, nan, 8}, 2, 2),
            "slice 1, sample 1, channel 0 = nan: samples must be finite");
}

TEST_F(SampleFileTest, NamesDenormalsByPosition) {
  EXPECT_THAT(fault({3}, {1, 0, -1e-40F}, 3, 2), HasSubstr("sample 2 = -9.99994610111476e-41: a denormal of float32"));
  EXPECT_EQ(source({3}, {1, 0, -2e-38F}, 3, 2).channels(), 1);
}

TEST_F(SampleFileTest, RefusesScalarsWhoseSumsDoNotFit) {
  EXPECT_THAT(fault({3}, {0, 2e37F, 1}, 3, 1), AllOf(HasSubstr("sample 1 = "), HasSubstr("must lie within 1e18")));
  EXPECT_THAT(fault({2, 3}, {0, 1, 2, -1.5e18F, 1, 2}, 3, 2), HasSubstr("slice 1, sample 0 = "));
}

TEST_F(SampleFileTest, RefusesPointsWhoseSquaredDistancesDoNotFit) {
  EXPECT_THAT(fault({2, 2}, {0, 1e25F, 0, 1}, 2, 1),
              AllOf(HasSubstr("sample 0, channel 1 = "), HasSubstr("must lie within 1e18")));
  EXPECT_THAT(fault({2, 2}, {0, 1e-25F, 0, 2e-25F}, 2, 1), HasSubstr("too small for distances"));
  EXPECT_EQ(source({2, 2}, {0, 1e17F, 0, 1e-25F}, 2, 1).channels(), 2);
  EXPECT_EQ(source({2, 2}, {0, 0, 0, 0}, 2, 1).channels(), 2);
}

TEST_F(SampleFileTest, NamesTheFirstFaultsAndCountsTheRest) {
  const std::vector<Fault> all = faults({11}, std::vector<float>(11, nan), 11, 1);
  ASSERT_EQ(all.size(), 6U);
  EXPECT_THAT(all[4].text, HasSubstr("sample 4"));
  EXPECT_EQ(all[5].text, "and 6 more");
}

TEST_F(SampleFileTest, RefusesShapesSayingWhichItAccepts) {
  const std::vector<float> six = {1, 2, 3, 4, 5, 6};
  EXPECT_EQ(
      fault({6}, six, 5, 2),
      "shape (6,): the texture has 2 slices of 5 cells; accepted: (5,), (5, C), (2, 5) or (2, 5, C) with C from 1 "
      "to 8, or those of the texture itself, (..., y, x) or (..., y, x, C)");
  EXPECT_THAT(fault({3, 2}, six, 2, 5), HasSubstr("shape (3, 2): the texture has 5 slices of 2 cells"));
  EXPECT_THAT(fault({1, 6, 1}, six, 6, 2), HasSubstr("accepted"));
  EXPECT_THAT(fault({1, 1, 6, 1}, six, 6, 2), HasSubstr("accepted"));
  EXPECT_THAT(fault({2, 3, 2}, std::vector<float>(12, 0.5F), 6, 3), HasSubstr("accepted"));
  EXPECT_THAT(fault({0}, {}, 1, 1), HasSubstr("accepted"));
  EXPECT_THAT(fault({2, 9}, std::vector<float>(18, 0.5F), 2, 3), HasSubstr("accepted"));
  EXPECT_THAT(fault({2, 2}, {1, 2, 3, 4}, 2, 2), HasSubstr("could be 2 samples of 2 channels or 2 slices of 2"));
}

TEST_F(SampleFileTest, TakesAWholeTexture) {
  std::vector<float> values(24);
  std::iota(values.begin(), values.end(), 1.0F);
  EXPECT_EQ(source({2, 3, 4}, values, 12, 2, DistanceKind::euclidean).list(SliceIndex(1)).front(), 13);
  EXPECT_EQ(source({2, 2, 2, 3}, values, 6, 4, DistanceKind::euclidean).list(SliceIndex(3)).back(), 24);
  EXPECT_EQ(source({2, 3, 2, 2}, values, 6, 2, DistanceKind::euclidean).channels(), 2);
  EXPECT_EQ(source({3, 8}, values, 24, 1, DistanceKind::euclidean).channels(), 1);
}

TEST_F(SampleFileTest, ChecksWhatTheDistanceNeeds) {
  EXPECT_EQ(fault({3}, {0.5F, 1, 0}, 3, 1, DistanceKind::circle), "sample 1 = 1: must lie in [0, 1) on the circle");
  EXPECT_THAT(fault({2}, {0.5F, -0.25F}, 2, 1, DistanceKind::circle), HasSubstr("sample 1 = -0.25"));
  EXPECT_THAT(fault({2, 3}, {1, 0, 0, 0, 0, 1.002F}, 2, 1, DistanceKind::angle),
              HasSubstr("sample 1 has length 1.002"));
  EXPECT_THAT(fault({2, 3}, {1, 0, 0, 0, 0, 0}, 2, 1, DistanceKind::angle), HasSubstr("sample 1 has length 0"));
  EXPECT_EQ(source({2, 3}, {1, 0, 0, 0, 0, 1.0009F}, 2, 1, DistanceKind::angle).distance(), DistanceKind::angle);
  EXPECT_EQ(source({2}, {0, 0.75F}, 2, 1, DistanceKind::circle).distance(), DistanceKind::circle);
  EXPECT_EQ(source({2}, {0, 0.75F}, 2, 1, DistanceKind::manhattan).distance(), DistanceKind::absolute);
  EXPECT_EQ(source({2, 2}, {0, 7, 0, 9}, 2, 1, DistanceKind::manhattan).distance(), DistanceKind::manhattan);
  EXPECT_THAT(fault({2, 2}, {1, 0, 0, 1.5F}, 2, 1, DistanceKind::cosine), HasSubstr("needs length 1"));
  EXPECT_THAT(fault({2}, {1, 1}, 2, 1, DistanceKind::cosine), HasSubstr("the distance \"cosine\" is for 2 to 4"));
  EXPECT_THAT(fault({2}, {1, 1}, 2, 1, DistanceKind::angle), HasSubstr("1 channel, but"));
  EXPECT_THAT(fault({2, 3}, {1, 0, 0, 0, 0, 1}, 2, 1, DistanceKind::circle), HasSubstr("3 channels, but"));
  EXPECT_THAT(fault({2, 3}, {1, 0, 0, 0, 0, 1}, 2, 1, DistanceKind::absolute), HasSubstr("3 channels, but"));
}

TEST_F(SampleFileTest, NamesAFileThatIsNotThere) { EXPECT_THROW(opened(2, 1, DistanceKind::euclidean), UserError); }

}  // namespace
}  // namespace noiseloom
