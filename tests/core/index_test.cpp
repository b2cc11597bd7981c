// That to take one kind of index for another does not compile, and that indices cost what their integers do.
#include "noiseloom/core/index.h"

#include <gtest/gtest.h>

#include <cstring>
#include <sstream>
#include <type_traits>

#include "noiseloom/core/distribution.h"

namespace noiseloom {
namespace {

template <class A, class B>
concept Comparable = requires(A a, B b) {
  a == b;
}
|| requires(A a, B b) { a < b; };
template <class A, class B>
concept Subtractable = requires(A a, B b) {
  a - b;
};
template <class A, class B>
concept Addable = requires(A a, B b) {
  a + b;
};

// An index of one kind is neither made from, nor assigned, compared or subtracted with anything but its own kind, and
// becomes an integer only where value() or a cast is written out.
template <class I, class Other>
constexpr bool mixes =
    std::is_convertible_v<Other, I> || std::is_convertible_v<I, Other> || std::is_assignable_v<I&, Other> ||
    Comparable<I, Other> || Subtractable<I, Other> || Addable<I, Other>;
template <class A, class B>
constexpr bool kinds_mix = mixes<A, B> || mixes<B, A> || std::is_constructible_v<A, B> || std::is_constructible_v<B, A>;

static_assert(!mixes<Rank, int> && !mixes<Rank, std::int64_t> && !mixes<Rank, std::size_t>);
static_assert(!mixes<SliceIndex, int> && !mixes<SliceIndex, std::int64_t>);
static_assert(!mixes<LocalSlice, int> && !mixes<LocalSlice, std::int64_t>);
static_assert(!kinds_mix<Rank, SliceIndex> && !kinds_mix<LocalSlice, SliceIndex>);
static_assert(!kinds_mix<Rank, LocalSlice>);
static_assert(Comparable<Rank, Rank> && Subtractable<Rank, Rank> && !Addable<Rank, Rank>);

// As their integers lie in memory, alone and in vectors, so that MPI and HDF5 take them as those.
template <class I>
constexpr bool is_its_integer =
    sizeof(I) == sizeof(typename I::Integer) &&
    alignof(I) == alignof(typename I::Integer) && std::is_trivially_copyable_v<I>&& std::is_standard_layout_v<I>;
static_assert(is_its_integer<Rank> && is_its_integer<LocalSlice>);

template <class D>
concept OwnerOfLocalSlice = requires(D d) {
  d.owner(LocalSlice(0));
};
template <class D>
concept OwnerOfRank = requires(D d) {
  d.owner(Rank(0));
};
template <class D>
concept SlicesOfSlice = requires(D d, SliceIndex slice) {
  d.slices_of(slice);
};
template <class D>
concept LocalFromLocal = requires(D d) {
  d.local_slice_from_global(LocalSlice(0));
};
template <class D>
concept GlobalFromGlobal = requires(D d, SliceIndex slice) {
  d.global_slice_from_local(slice);
};
static_assert(!OwnerOfLocalSlice<Distribution> && !OwnerOfRank<Distribution> && !SlicesOfSlice<Distribution>);
static_assert(!LocalFromLocal<Distribution> && !GlobalFromGlobal<Distribution>);
static_assert(!std::is_constructible_v<Distribution, SliceIndex, int, SliceIndex>);

template <class V, class Key>
concept LookedIntoWith = requires(V v, Key key) {
  v[key];
};
static_assert(LookedIntoWith<IndexedVector<Rank, int>, Rank>);
static_assert(!LookedIntoWith<IndexedVector<Rank, int>, int> && !LookedIntoWith<IndexedVector<Rank, int>, LocalSlice>);

TEST(Index, CountsComparesAndPrintsAsItsInteger) {
  Rank rank;
  EXPECT_EQ(rank, Rank(0));
  ++rank;
  EXPECT_EQ(rank.value(), 1);
  EXPECT_LT(Rank(-1), Rank(0));
  EXPECT_EQ(Rank(7) - Rank(-4), 11);
  std::ostringstream text;
  text << Rank(12);
  EXPECT_EQ(text.str(), "12");
}

TEST(Index, DistancesAreThoseOfUnsignedIntegersToo) {
  using Wide = Index<struct WideTag, std::uint32_t>;
  EXPECT_EQ(Wide(1U) - Wide(4'000'000'000U), -3'999'999'999);
}

TEST(IndexDeathTest, IsNotMadeFromAValueThatItCannotHold) {
  EXPECT_DEATH(Rank(std::int64_t{1} << 32), "internal error");
  EXPECT_DEATH((Index<struct SmallTag, std::uint32_t>(-1)), "internal error");
}

TEST(IndexRange, HoldsWhatItRunsOver) {
  std::vector<int> seen;
  for (const Rank rank : IndexRange(Rank(3), Rank(6))) seen.push_back(rank.value());
  EXPECT_EQ(seen, (std::vector<int>{3, 4, 5}));
  const IndexRange slices(SliceIndex(2), SliceIndex(4));
  EXPECT_EQ(std::vector<SliceIndex>(slices.begin(), slices.end()),
            (std::vector<SliceIndex>{SliceIndex(2), SliceIndex(3)}));
  EXPECT_EQ(slices.size(), 2);
  for (const int slice : {1, 2, 3, 4}) EXPECT_EQ(slices.contains(SliceIndex(slice)), slice == 2 || slice == 3);
  EXPECT_EQ(IndexRange(Rank(5), Rank(5)).size(), 0);
}

TEST(IndexedVector, LiesInMemoryAsItsIntegers) {
  IndexedVector<LocalSlice, Rank> owners(3);
  for (const LocalSlice slice : owners.keys()) owners[slice] = Rank(10 * slice.value());
  const int expected[] = {0, 10, 20};
  EXPECT_EQ(std::memcmp(owners.data(), expected, sizeof expected), 0);
}

}  // namespace
}  // namespace noiseloom
