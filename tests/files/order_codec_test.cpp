#include "noiseloom/files/order_codec.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <random>
#include <vector>

#include "support/sample_run_file.h"

namespace noiseloom {
namespace {

using testing::AllOf;
using testing::HasSubstr;

using Entries = std::vector<std::uint64_t>;

std::vector<std::byte> bytes_of(const OrderCodec& codec, const Entries& entries) {
  std::vector<std::byte> bytes(entries.size() * codec.bytes_per_pixel());
  codec.write(entries, bytes);
  return bytes;
}

// What a file holds: numbers of so many bytes, the least significant byte first.
std::vector<std::byte> little_endian(std::size_t size, const Entries& numbers) {
  std::vector<std::byte> bytes;
  for (const std::uint64_t number : numbers)
    for (std::size_t byte = 0; byte < size; ++byte) bytes.push_back(static_cast<std::byte>(number >> (8 * byte)));
  return bytes;
}

Entries permutation(std::size_t count) {
  Entries places(count);
  std::iota(places.begin(), places.end(), std::uint64_t{0});
  std::shuffle(places.begin(), places.end(), std::mt19937(1));
  return places;
}

TEST(OrderCodec, TakesSixtyFourBitsWhereTheMarksWouldBePlaces) {
  EXPECT_EQ(OrderCodec::for_pixels(1).type(), ElementType::uint32);
  EXPECT_EQ(OrderCodec::for_pixels(0xFFFFFFFE).type(), ElementType::uint32);
  EXPECT_EQ(OrderCodec::for_pixels(0xFFFFFFFF).type(), ElementType::uint64);
  EXPECT_EQ(OrderCodec::for_pixels(std::int64_t{1} << 48).type(), ElementType::uint64);
  EXPECT_EQ(order_dataset(0xFFFFFFFE), (SliceDataset{"/order", ElementType::uint32, 1, false}));
  EXPECT_EQ(order_dataset(0xFFFFFFFF), (SliceDataset{"/order", ElementType::uint64, 1, false}));
}

class OrderCodecOfType : public testing::TestWithParam<ElementType> {
 protected:
  const OrderCodec codec_{GetParam()};
  const bool wide_ = GetParam() == ElementType::uint64;
  // The largest place of the type, and both marks, as a file holds them.
  const std::uint64_t largest_ = wide_ ? 0xFFFFFFFFFFFFFFFD : 0xFFFFFFFD;
};
INSTANTIATE_TEST_SUITE_P(Types, OrderCodecOfType, testing::Values(ElementType::uint32, ElementType::uint64));

TEST_P(OrderCodecOfType, HoldsPlacesAndMarksAsLittleEndianNumbers) {
  const Entries entries = {0, 1, 0x01020304, largest_, on_without_place, off_without_place};
  const std::vector<std::byte> stored =
      little_endian(wide_ ? 8 : 4, {0, 1, 0x01020304, largest_, largest_ + 1, largest_ + 2});
  EXPECT_EQ(codec_.type(), GetParam());
  EXPECT_EQ(codec_.bytes_per_pixel(), bytes_per_element(GetParam()));
  EXPECT_EQ(codec_.num_pixels(stored), entries.size());
  EXPECT_EQ(bytes_of(codec_, entries), stored);
  Entries back(entries.size());
  codec_.read(stored, back);
  EXPECT_EQ(back, entries);
  std::vector<std::byte> one_by_one(stored.size());
  for (std::size_t pixel = 0; pixel < entries.size(); ++pixel) {
    EXPECT_EQ(codec_.get(stored, pixel), entries[pixel]);
    codec_.set(one_by_one, pixel, entries[pixel]);
  }
  EXPECT_EQ(one_by_one, stored);
}

TEST_P(OrderCodecOfType, TellsPlacesFromMarks) {
  const std::vector<std::byte> stored = little_endian(wide_ ? 8 : 4, {largest_, largest_ + 1, largest_ + 2});
  EXPECT_TRUE(is_place(codec_.get(stored, 0)));
  EXPECT_FALSE(is_place(codec_.get(stored, 1)));
  EXPECT_FALSE(is_place(codec_.get(stored, 2)));
}

TEST_P(OrderCodecOfType, CountsAPermutationAsCompleteWhateverItsSequence) {
  const Entries places = permutation(1000);
  const OrderCensus expected = OrderCensus::of_places(1000, 0, 1000, 0);
  OrderCensus whole(1000);
  whole.add(codec_, bytes_of(codec_, places));
  EXPECT_EQ(whole, expected);
  OrderCensus parts(1000);
  parts.add(codec_, bytes_of(codec_, Entries(places.begin() + 300, places.end())));
  EXPECT_FALSE(parts.is_complete());
  parts.add(codec_, bytes_of(codec_, Entries(places.begin(), places.begin() + 300)));
  EXPECT_EQ(parts, expected);
  EXPECT_TRUE(parts.is_complete());
  EXPECT_EQ(parts.num_placed(), 1000);
  EXPECT_EQ(parts.num_on(), 0);
  EXPECT_NO_THROW(require_complete_order(parts, "mask.h5"));
}

TEST_P(OrderCodecOfType, FindsARepeatedPlaceByTheDigestAlone) {
  Entries places = permutation(1000);
  places[5] = places[6];
  OrderCensus census(1000);
  census.add(codec_, bytes_of(codec_, places));
  const OrderCensus expected = OrderCensus::of_places(1000, 0, 1000, 0);
  EXPECT_TRUE(census.is_complete());  // each pixel has a place
  EXPECT_EQ(census.num_placed(), expected.num_placed());
  EXPECT_NE(census.digest(), expected.digest());
  EXPECT_NE(census, expected);
}

TEST_P(OrderCodecOfType, CountsAnUnfinishedOrder) {
  // As within the drain: places 4, 5, 6 are given, four pixels are on, the rest is off.
  OrderCensus census(12);
  const Entries entries = {off_without_place, 5, on_without_place, 6, off_without_place, on_without_place, 4};
  census.add(codec_, bytes_of(codec_, entries));
  census.add(codec_, bytes_of(codec_, {on_without_place, on_without_place, off_without_place}));
  EXPECT_EQ(census, OrderCensus::of_places(12, 4, 7, 4));
  EXPECT_NE(census, OrderCensus::of_places(12, 4, 7, 3));
  EXPECT_NE(census, OrderCensus::of_places(12, 0, 3, 4));
  EXPECT_EQ(census.num_placed(), 3);
  EXPECT_EQ(census.num_on(), 4);
  EXPECT_FALSE(census.is_complete());
  try {
    require_complete_order(census, "mask.h5");
    ADD_FAILURE() << "was accepted";
  } catch (const UserError& error) {
    EXPECT_THAT(error.what(), AllOf(HasSubstr("mask.h5"), HasSubstr("not finished: 3 of 12 pixels")));
  }
}

TEST_P(OrderCodecOfType, CountsAPlacePastTheLastAsNone) {
  Entries places = permutation(10);
  *std::ranges::find(places, 9U) = 10;
  OrderCensus census(10);
  census.add(codec_, bytes_of(codec_, places));
  EXPECT_EQ(census.num_placed(), 10);
  EXPECT_EQ(census.num_in_range(), 9);
  EXPECT_FALSE(census.is_complete());
}

TEST_P(OrderCodecOfType, CountsTheOrderOfARunFile) {
  const TemporaryFolder folder;
  RunFileContent content;
  content.extents = Extents({5, 3, 4});
  content.datasets = {{"/samples", ElementType::float32, 1, true}, {order_name, GetParam(), 1, false}};
  const Entries places = permutation(60);
  const std::vector<float> samples(15);
  {
    RunFileWriter writer(posix_file_ops(), folder / "mask.h5", content);
    for (std::size_t s = 0; s < 4; ++s) {
      const auto first = places.begin() + static_cast<std::ptrdiff_t>(15 * s);
      writer.write_slice(0, SliceIndex(s), std::as_bytes(std::span(samples)));
      writer.write_slice(1, SliceIndex(s), bytes_of(codec_, Entries(first, first + 15)));
    }
    writer.publish();
  }
  const RunFileReader reader(folder / "mask.h5");
  EXPECT_TRUE(is_order_run(reader.content()));
  EXPECT_EQ(why_order_cannot_be_read(reader.content()), "");
  EXPECT_EQ(census_of_order(reader), OrderCensus::of_places(60, 0, 60, 0));
}

TEST(OrderCodec, IsNoneForDatasetsOfAnotherKind) {
  EXPECT_EQ(order_codec_of({order_name, ElementType::uint32, 1, false}), OrderCodec(ElementType::uint32));
  EXPECT_EQ(order_codec_of({order_name, ElementType::uint64, 1, false}), OrderCodec(ElementType::uint64));
  EXPECT_EQ(order_codec_of({order_name, ElementType::float32, 1, false}), std::nullopt);
  EXPECT_EQ(order_codec_of({order_name, ElementType::uint32, 2, true}), std::nullopt);
  RunFileContent content;
  EXPECT_THAT(why_order_cannot_be_read(content), HasSubstr("holds no /order"));
  content.datasets = {{order_name, ElementType::float32, 1, false}};
  EXPECT_THAT(why_order_cannot_be_read(content), HasSubstr("uint32 or uint64"));
}

}  // namespace
}  // namespace noiseloom
