// Equal-measure strata of a box: the box is halved again and again, floor(n/2) strata to the low side and the rest to
// the high side with volumes in that proportion, always across its longest side, until every part is one stratum. Any n
// works, primes too. Strata are numbered in the order of the recursion, so near numbers lie near each other.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace noiseloom {

inline constexpr std::size_t max_dimensions = 8;

// Half open: low <= u < high on each of `dimensions` axes.
struct Box {
  std::size_t dimensions = 0;
  std::array<double, max_dimensions> low{};
  std::array<double, max_dimensions> high{};

  bool contains(const double* u) const {
    for (std::size_t axis = 0; axis < dimensions; ++axis) {
      if (!(u[axis] >= low[axis] && u[axis] < high[axis])) return false;
    }
    return true;
  }
};

class Strata {
 public:
  // Requires num_strata >= 1.
  Strata(const Box& root, std::int64_t num_strata) : root_(root), num_strata_(num_strata) {}

  Box box(std::int64_t id) const;
  // The stratum that holds u; for points outside the root, one at its border.
  std::int64_t find(const double* u) const;
  // Calls visit(id, box) for every stratum in order of id; the boxes are box(id), bit for bit.
  template <class Visit>
  void for_each(const Visit& visit) const {
    descend(root_, 0, num_strata_, visit);
  }

 private:
  // The cut of a box that holds `count` > 1 strata: `below` of them have u[axis] < at.
  struct Cut {
    std::size_t axis;
    double at;
    std::int64_t below;
  };
  static Cut cut(const Box& box, std::int64_t count);

  template <class Visit>
  static void descend(const Box& box, std::int64_t first, std::int64_t count, const Visit& visit) {
    if (count == 1) {
      visit(first, box);
      return;
    }
    const Cut c = cut(box, count);
    Box part = box;
    part.high[c.axis] = c.at;
    descend(part, first, c.below, visit);
    part.high[c.axis] = box.high[c.axis];
    part.low[c.axis] = c.at;
    descend(part, first + c.below, count - c.below, visit);
  }

  Box root_;
  std::int64_t num_strata_;
};

}  // namespace noiseloom
