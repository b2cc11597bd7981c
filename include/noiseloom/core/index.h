// Numbers that name one thing of many: a type for each kind, so that a program that takes one for another does not
// compile. An index costs what its integer costs, and a vector of indices lies in memory as one of integers does.
//
//   Rank          a process of the run
//   LocalSlice    a slice of a rank, counted from the rank's first (core/distribution.h)
//   SliceIndex    a slice of the texture
//   SampleId      a sample of a slice's list (samples/sample_space.h)
//
// What folders say to each other names things by these types; a loop that does arithmetic on positions takes the
// integer out once and keeps it to itself. Counts and coordinates are integers, and so is a cell of a slice, which
// coordinates make up: every other kind being a type, they can be mistaken for none of them.
#pragma once

#include <compare>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <limits>
#include <ostream>
#include <utility>
#include <vector>

#include "noiseloom/core/error.h"

namespace noiseloom {

// Narrows an integer, checking that the value survives.
template <class To, class From>
constexpr To narrow(From value) {
  const To result = static_cast<To>(value);
  NOISELOOM_CHECK(static_cast<From>(result) == value && ((result < To{}) == (value < From{})));
  return result;
}

// A number of the kind `Tag`, held as an `Int`. It is made from an integer and read as one only where that is written
// out: Rank(0), rank.value().
template <class Tag, std::integral Int>
class Index {
 public:
  using Integer = Int;

  constexpr Index() = default;  // 0
  constexpr explicit Index(Int value) : value_(value) {}
  // From another type of integer, checking that the value survives.
  template <std::integral From>
  constexpr explicit Index(From value) : value_(narrow<Int>(value)) {}

  constexpr Int value() const { return value_; }
  // Where an array is looked into: values[static_cast<std::size_t>(slice)].
  template <std::integral To>
  constexpr explicit operator To() const {
    return static_cast<To>(value_);
  }
  constexpr Index& operator++() {
    ++value_;
    return *this;
  }

  friend constexpr auto operator<=>(Index, Index) = default;
  // How far `to` lies after `from`.
  friend constexpr std::int64_t operator-(Index to, Index from) {
    return static_cast<std::int64_t>(to.value_) - static_cast<std::int64_t>(from.value_);
  }
  friend std::ostream& operator<<(std::ostream& out, Index index) { return out << index.value_; }

 private:
  Int value_ = 0;
};

}  // namespace noiseloom

// An index has no limits of its own: those of its integer are asked for.
template <class Tag, class Int>
class std::numeric_limits<noiseloom::Index<Tag, Int>>;

namespace noiseloom {

using SliceIndex = Index<struct SliceTag, std::int32_t>;
using Rank = Index<struct RankTag, int>;
using LocalSlice = Index<struct LocalSliceTag, std::int32_t>;

// Indices begin, ..., end - 1, or integers that count something: for (const Rank rank : first_indices<Rank>(4)).
template <class I>
class IndexRange {
 public:
  class Iterator {
   public:
    using iterator_category = std::input_iterator_tag;
    using value_type = I;
    using difference_type = std::ptrdiff_t;
    using pointer = const I*;
    using reference = I;

    explicit constexpr Iterator(I at) : at_(at) {}
    constexpr I operator*() const { return at_; }
    constexpr Iterator& operator++() {
      ++at_;
      return *this;
    }
    constexpr Iterator operator++(int) {
      const Iterator before = *this;
      ++at_;
      return before;
    }
    friend constexpr bool operator==(Iterator, Iterator) = default;

   private:
    I at_;
  };

  constexpr IndexRange(I begin, I end) : begin_(begin), end_(end < begin ? begin : end) {}
  constexpr Iterator begin() const { return Iterator(begin_); }
  constexpr Iterator end() const { return Iterator(end_); }
  constexpr I first() const { return begin_; }
  constexpr I past_last() const { return end_; }
  constexpr std::int64_t size() const { return static_cast<std::int64_t>(end_ - begin_); }
  constexpr bool contains(I index) const { return begin_ <= index && index < end_; }

 private:
  I begin_;
  I end_;
};

template <class I>
constexpr IndexRange<I> first_indices(std::int64_t count) {
  return {I(0), I(count)};
}

// A vector that is looked into with indices of one kind.
template <class Key, class T>
class IndexedVector {
 public:
  IndexedVector() = default;
  explicit IndexedVector(std::vector<T> values) : values_(std::move(values)) {}
  explicit IndexedVector(std::size_t size) : values_(size) {}

  decltype(auto) operator[](Key key) { return values_[static_cast<std::size_t>(key.value())]; }
  decltype(auto) operator[](Key key) const { return values_[static_cast<std::size_t>(key.value())]; }
  std::size_t size() const { return values_.size(); }
  // All keys, in order.
  IndexRange<Key> keys() const { return first_indices<Key>(std::ssize(values_)); }
  auto begin() { return values_.begin(); }
  auto begin() const { return values_.begin(); }
  auto end() { return values_.end(); }
  auto end() const { return values_.end(); }
  // As they lie in memory.
  T* data() { return values_.data(); }
  const T* data() const { return values_.data(); }

  friend bool operator==(const IndexedVector&, const IndexedVector&) = default;

 private:
  std::vector<T> values_;
};

}  // namespace noiseloom
