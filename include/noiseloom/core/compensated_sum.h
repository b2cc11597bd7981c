// Sums in a fixed order whose rounding error does not grow with their length [Neumaier74]: what an addition rounds off
// is summed beside it.
#pragma once

#include <cmath>

namespace noiseloom {

class CompensatedSum {
 public:
  void add(double term) {
    const double next = sum_ + term;
    lost_ += std::abs(sum_) >= std::abs(term) ? (sum_ - next) + term : (term - next) + sum_;
    sum_ = next;
  }
  double value() const { return sum_ + lost_; }

 private:
  double sum_ = 0;
  double lost_ = 0;
};

}  // namespace noiseloom
