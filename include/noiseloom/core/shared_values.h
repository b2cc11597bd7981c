// Numbers that nobody changes any more, in memory that any number of holders share: copies of a config, or the ranks of
// a node (dist/node_memory.h).
#pragma once

#include <algorithm>
#include <cstddef>
#include <memory>
#include <span>
#include <utility>
#include <vector>

namespace noiseloom {

template <class T>
class SharedValues {
 public:
  SharedValues() = default;
  // What a vector holds; it is not copied when it is given away.
  SharedValues(std::vector<T> values)  // NOLINT(google-explicit-constructor): a vector of numbers is such numbers
      : SharedValues(std::make_shared<const std::vector<T>>(std::move(values))) {}
  // Numbers that stay where they are as long as `owner` lives.
  SharedValues(std::shared_ptr<const void> owner, std::span<const T> values)
      : owner_(std::move(owner)), values_(values) {}

  const T* data() const { return values_.data(); }
  std::size_t size() const { return values_.size(); }
  bool empty() const { return values_.empty(); }
  auto begin() const { return values_.begin(); }
  auto end() const { return values_.end(); }
  const T& operator[](std::size_t i) const { return values_[i]; }

  friend bool operator==(const SharedValues& a, const SharedValues& b) {
    return std::equal(a.begin(), a.end(), b.begin(), b.end());
  }

 private:
  explicit SharedValues(std::shared_ptr<const std::vector<T>> values) : values_(*values) { owner_ = std::move(values); }

  std::shared_ptr<const void> owner_;
  std::span<const T> values_;
};

}  // namespace noiseloom
