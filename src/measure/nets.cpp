#include "noiseloom/measure/nets.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <vector>

#include "noiseloom/core/error.h"

namespace noiseloom {
namespace {

constexpr int code_bits = 30;

class Intervals {
 public:
  Intervals(std::span<const float> points, int channels)
      : channels_(static_cast<std::size_t>(channels)), num_points_(points.size() / channels_) {
    codes_.reserve(points.size());
    for (const float value : points) {
      const double code = std::floor(static_cast<double>(value) * (1 << code_bits));
      codes_.push_back(static_cast<std::uint32_t>(std::clamp(code, 0.0, (1 << code_bits) - 1.0)));
    }
  }

  // Whether each of the intervals with 2^-digits[c] as sides holds the same number of points.
  bool are_even(const std::vector<int>& digits) {
    int all_digits = 0;
    for (const int d : digits) all_digits += d;
    counts_.assign(std::size_t{1} << all_digits, 0);
    const std::size_t share = num_points_ >> all_digits;
    for (std::size_t i = 0; i < num_points_; ++i) {
      std::size_t interval = 0;
      for (std::size_t c = 0; c < channels_; ++c) {
        interval = interval << digits[c] | codes_[i * channels_ + c] >> (code_bits - digits[c]);
      }
      if (++counts_[interval] > share) return false;
    }
    return true;
  }

  // The same for every shape of that many digits; digits from `channel` on are to be chosen.
  bool are_even(std::vector<int>& digits, std::size_t channel, int left) {
    if (channel + 1 == channels_) {
      digits[channel] = left;
      return are_even(digits);
    }
    for (int d = 0; d <= left; ++d) {
      digits[channel] = d;
      if (!are_even(digits, channel + 1, left - d)) return false;
    }
    return true;
  }

 private:
  std::size_t channels_;
  std::size_t num_points_;
  std::vector<std::uint32_t> codes_;
  std::vector<std::uint32_t> counts_;
};

}  // namespace

std::optional<int> net_quality(std::span<const float> points, int channels) {
  NOISELOOM_CHECK(channels >= 1 && points.size() % static_cast<std::size_t>(channels) == 0);
  const std::size_t n = points.size() / static_cast<std::size_t>(channels);
  if (!std::has_single_bit(n)) return std::nullopt;
  const int m = std::countr_zero(n);
  if (m > code_bits) return std::nullopt;
  Intervals intervals(points, channels);
  std::vector<int> digits(static_cast<std::size_t>(channels), 0);
  int t = 0;
  while (t < m && !intervals.are_even(digits, 0, m - t)) ++t;
  return t;
}

}  // namespace noiseloom
