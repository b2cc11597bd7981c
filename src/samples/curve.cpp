#include "samples/curve.h"

#include <algorithm>
#include <bit>
#include <utility>

#include "noiseloom/core/error.h"

namespace noiseloom {
namespace {

// Words of `width` bits, turned round.
std::uint32_t rotated_left(std::uint32_t word, unsigned by, unsigned width) {
  by %= width;
  return (word << by | word >> (width - by)) & ((1U << width) - 1);
}

std::uint32_t gray_code(std::uint32_t rank) { return rank ^ rank >> 1; }

std::uint32_t rank_of_gray(std::uint32_t code) {
  for (unsigned shift = 1; shift < 8; shift *= 2) code ^= code >> shift;  // codes of four bits at most
  return code;
}

// The Hilbert curve passes through the 2^d parts of a cube in the order of the Gray code; in each part it is the same
// curve once more, turned so that it enters at the corner `entry` and leaves along the axis `axis` [Hamilton06].
class Turn {
 public:
  explicit Turn(unsigned dimensions) : dimensions_(dimensions) {}

  // Which part, in the order of the curve, holds the corner `part`, a bit an axis; goes on inside it.
  std::uint32_t descend(std::uint32_t part) {
    const std::uint32_t rank = rank_of_gray(rotated_left(part ^ entry_, 2 * dimensions_ - axis_ - 1, dimensions_));
    const std::uint32_t entered = rank == 0 ? 0 : gray_code((rank - 1) & ~1U);
    const std::uint32_t changing = rank == 0 ? 0 : rank % 2 == 0 ? rank - 1 : rank;
    entry_ ^= rotated_left(entered, axis_ + 1, dimensions_);
    axis_ = (axis_ + static_cast<unsigned>(std::countr_one(changing)) + 1) % dimensions_;
    return rank;
  }

 private:
  unsigned dimensions_;
  std::uint32_t entry_ = 0;
  unsigned axis_ = 0;
};

}  // namespace

std::uint64_t curve_place(Curve curve, int dimensions, const float* point) {
  NOISELOOM_CHECK(curve != Curve::none && dimensions >= 2 && dimensions <= 4);
  const auto axes = static_cast<unsigned>(dimensions);
  const unsigned levels = std::min(24U, 64 / axes);
  std::uint32_t cell[4] = {};
  for (unsigned axis = 0; axis < axes; ++axis) {
    const double scaled = static_cast<double>(point[axis]) * static_cast<double>(1U << levels);
    cell[axis] = static_cast<std::uint32_t>(std::clamp(scaled, 0.0, static_cast<double>((1U << levels) - 1)));
  }
  Turn turn(axes);
  std::uint64_t place = 0;
  for (unsigned level = levels; level-- > 0;) {
    std::uint32_t part = 0;
    for (unsigned axis = 0; axis < axes; ++axis) part |= (cell[axis] >> level & 1U) << axis;
    place = place << axes | (curve == Curve::hilbert ? turn.descend(part) : part);
  }
  return place;
}

std::vector<float> along_curve(Curve curve, int channels, const std::vector<float>& list) {
  const auto step = static_cast<std::size_t>(channels);
  std::vector<std::pair<std::uint64_t, std::size_t>> order;
  for (std::size_t i = 0; i < list.size(); i += step) order.emplace_back(curve_place(curve, channels, &list[i]), i);
  std::sort(order.begin(), order.end());
  std::vector<float> sorted;
  sorted.reserve(list.size());
  for (const auto& [place, i] : order) {
    for (std::size_t c = 0; c < step; ++c) sorted.push_back(list[i + c]);
  }
  return sorted;
}

}  // namespace noiseloom
