// How far beyond its limit the estimate of a candidate's dE may lie for the candidate to be judged all the same. Found
// anew in every visit, from the errors of the estimates of its first candidates: the farther two samples are from each
// other, the larger the error.
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>

namespace noiseloom {

class SieveMargin {
 public:
  // `step`: the distance between the ids of the two samples. Before conclude().
  void learn(std::int32_t step, double estimate, double change);
  void conclude();
  // Whether dE <= limit is likely enough, after conclude(). Where estimates turned out to be of no use: true.
  bool lets_through(std::int32_t step, double estimate, double limit) const {
    return !(estimate > limit + margins_[bin(step)]);  // a NaN passes
  }

 private:
  static constexpr std::size_t num_bins = 33;  // by the steps' powers of two
  static std::size_t bin(std::int32_t step) {
    return static_cast<std::size_t>(std::bit_width(static_cast<std::uint32_t>(step < 0 ? -step : step)));
  }

  std::array<double, num_bins> squared_errors_{};
  std::array<double, num_bins> counts_{};
  double squared_changes_ = 0;
  std::array<double, num_bins> margins_{};
};

}  // namespace noiseloom
