#include "samples/strata.h"

namespace noiseloom {

Strata::Cut Strata::cut(const Box& box, std::int64_t count) {
  std::size_t longest = 0;
  for (std::size_t axis = 1; axis < box.dimensions; ++axis) {
    if (box.high[axis] - box.low[axis] > box.high[longest] - box.low[longest]) longest = axis;
  }
  const std::int64_t below = count / 2;
  const double fraction = static_cast<double>(below) / static_cast<double>(count);
  return {longest, box.low[longest] + (box.high[longest] - box.low[longest]) * fraction, below};
}

Box Strata::box(std::int64_t id) const {
  Box box = root_;
  for (std::int64_t count = num_strata_; count > 1;) {
    const Cut c = cut(box, count);
    if (id < c.below) {
      box.high[c.axis] = c.at;
      count = c.below;
    } else {
      box.low[c.axis] = c.at;
      count -= c.below;
      id -= c.below;
    }
  }
  return box;
}

std::int64_t Strata::find(const double* u) const {
  Box box = root_;
  std::int64_t id = 0;
  for (std::int64_t count = num_strata_; count > 1;) {
    const Cut c = cut(box, count);
    if (u[c.axis] < c.at) {
      box.high[c.axis] = c.at;
      count = c.below;
    } else {
      box.low[c.axis] = c.at;
      count -= c.below;
      id += c.below;
    }
  }
  return id;
}

}  // namespace noiseloom
