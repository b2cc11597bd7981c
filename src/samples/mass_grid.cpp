#include "samples/mass_grid.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "noiseloom/core/error.h"

namespace noiseloom {
namespace {

std::size_t index_of(GridAxis axis) { return axis == GridAxis::x ? 0 : 1; }

constexpr double whole_mass = 0x1p62;  // leaves room for what rounding adds

}  // namespace

MassGrid::MassGrid(int width, int height, const MassOf& mass_of)
    : MassGrid(width, height, [&] {
        std::vector<std::uint64_t> sums(num_sums(width, height));
        sum_up(width, height, mass_of, sums);
        return SharedValues<std::uint64_t>(std::move(sums));
      }()) {}

MassGrid::MassGrid(int width, int height, SharedValues<std::uint64_t> sums)
    : size_{width, height}, below_(std::move(sums)) {
  NOISELOOM_CHECK_EQ(below_.size(), num_sums(width, height));
}

std::size_t MassGrid::num_sums(int width, int height) {
  NOISELOOM_CHECK(width >= 1 && height >= 1);
  return (static_cast<std::size_t>(width) + 1) * (static_cast<std::size_t>(height) + 1);
}

void MassGrid::sum_up(int width, int height, const MassOf& mass_of, std::span<std::uint64_t> sums) {
  NOISELOOM_CHECK_EQ(sums.size(), num_sums(width, height));
  // Halves, as the sum of all may be past the largest double.
  double half = 0;
  for (int y = 0; y < height; ++y) {
    double row = 0;
    for (int x = 0; x < width; ++x) row += 0.5 * mass_of(x, y);
    half += row;
  }
  NOISELOOM_CHECK(half > 0 && std::isfinite(half));
  const std::size_t pitch = static_cast<std::size_t>(width) + 1;
  std::fill_n(sums.begin(), pitch, 0);
  for (int y = 0; y < height; ++y) {
    const std::uint64_t* const above = &sums[static_cast<std::size_t>(y) * pitch];
    std::uint64_t* const row = &sums[(static_cast<std::size_t>(y) + 1) * pitch];
    std::uint64_t sum = row[0] = 0;
    for (int x = 0; x < width; ++x) {
      sum += static_cast<std::uint64_t>(0.5 * mass_of(x, y) / half * whole_mass);
      row[x + 1] = above[x + 1] + sum;
    }
  }
}

TexelBox MassGrid::whole() const {
  return trimmed({{0, 0}, {static_cast<double>(size_[0]), static_cast<double>(size_[1])}});
}

bool MassGrid::is_empty(int x, int y) const {
  return below(GridAxis::x, x + 1, y + 1) - below(GridAxis::x, x, y + 1) ==
         below(GridAxis::x, x + 1, y) - below(GridAxis::x, x, y);
}

// A box as seen along one axis: how much of the mass between its two sides lies before an edge. Counted from the edge
// at or before its low end, so that a small box does not lose its digits to all that lies before it.
class MassGrid::Band {
 public:
  Band(const MassGrid& grid, const TexelBox& box, GridAxis along)
      : grid_(grid), along_(along), low_(box.low[index_of(along)]), high_(box.high[index_of(along)]) {
    const GridAxis across = along == GridAxis::x ? GridAxis::y : GridAxis::x;
    const double side_low = box.low[index_of(across)];
    const double side_high = box.high[index_of(across)];
    first_ = static_cast<int>(low_);
    last_ = static_cast<int>(std::ceil(high_)) - 1;
    side_first_ = static_cast<int>(side_low);
    side_end_ = static_cast<int>(side_high);
    if (side_first_ == side_end_) {  // within one texel
      first_part_ = side_high - side_low;
      last_part_ = 0;
    } else {
      first_part_ = side_first_ + 1 - side_low;
      last_part_ = side_high - side_end_;
    }
    from_ = std::max(0.0, low_ - first_) * to(first_ + 1);
    const double before = to(last_);
    until_ = before + (high_ - last_) * (to(last_ + 1) - before);
  }

  // The mass up to the edge `at`, first_ to last_ + 1; never falls as `at` grows.
  double to(int at) const {
    double sum = first_part_ * strip(side_first_, side_first_ + 1, at);
    if (side_end_ > side_first_ + 1) sum += strip(side_first_ + 1, side_end_, at);
    if (last_part_ > 0) sum += last_part_ * strip(side_end_, side_end_ + 1, at);
    return sum;
  }

  // The texel in which the mass up to a position reaches `share` of the box; not an empty one. And that position.
  int texel_of(double share, double& position) const {
    const double target = std::min(from_ + share * (until_ - from_), until_);
    int at = last_within([&](int edge) { return to(edge) <= target; });
    while (at > first_ && !(to(at + 1) > to(at))) --at;
    while (at < last_ && !(to(at + 1) > to(at))) ++at;
    const double before = to(at);
    const double mass = to(at + 1) - before;
    const double part = mass > 0 ? std::clamp((target - before) / mass, 0.0, 1.0) : 0.5;
    position = std::clamp(at + part, std::max<double>(low_, at), std::min<double>(high_, at + 1));
    return at;
  }

  double trimmed_low() const {
    return std::max<double>(low_, last_within([&](int edge) { return to(edge) <= 0; }));
  }
  double trimmed_high() const {
    const double all = to(last_ + 1);
    if (!(to(first_) < all)) return high_;
    return std::min<double>(high_, 1 + last_within([&](int edge) { return to(edge) < all; }));
  }

 private:
  // The last texel whose low edge has a property that the first has and that, once lost, stays lost.
  template <class Holds>
  int last_within(const Holds& holds) const {
    int yes = first_;
    int no = last_ + 1;
    while (no - yes > 1) {
      const int middle = yes + (no - yes) / 2;
      (holds(middle) ? yes : no) = middle;
    }
    return yes;
  }

  double strip(int side_from, int side_to, int at) const {
    const std::uint64_t mass = (grid_.below(along_, at, side_to) - grid_.below(along_, at, side_from)) -
                               (grid_.below(along_, first_, side_to) - grid_.below(along_, first_, side_from));
    return static_cast<double>(mass);
  }

  const MassGrid& grid_;
  GridAxis along_;
  double low_;
  double high_;
  int first_;  // texels that the box touches
  int last_;
  int side_first_;     // the first texel across
  int side_end_;       // the texel that the box's far side lies in or begins
  double first_part_;  // how much of these two lies in the box
  double last_part_;
  double from_ = 0;   // the mass up to low_
  double until_ = 0;  // and up to high_
};

TexelBox MassGrid::trimmed(const TexelBox& box) const {
  TexelBox result = box;
  for (const GridAxis axis : {GridAxis::x, GridAxis::y}) {
    const Band band(*this, result, axis);
    const double low = band.trimmed_low();
    const double high = band.trimmed_high();
    if (!(low < high)) continue;
    result.low[index_of(axis)] = low;
    result.high[index_of(axis)] = high;
  }
  return result;
}

double MassGrid::cut(const TexelBox& box, GridAxis axis, double share) const {
  double position = 0;
  Band(*this, box, axis).texel_of(share, position);
  return position;
}

TexelPoint MassGrid::point(const TexelBox& box, double u, double v) const {
  TexelPoint point{};
  point.texel[0] = Band(*this, box, GridAxis::x).texel_of(u, point.at[0]);
  TexelBox column = box;
  column.low[0] = point.texel[0];
  column.high[0] = point.texel[0] + 1;
  point.texel[1] = Band(*this, column, GridAxis::y).texel_of(v, point.at[1]);
  for (std::size_t axis = 0; axis < 2; ++axis) {
    point.at[axis] = std::min(point.at[axis], std::nextafter(point.texel[axis] + 1.0, 0.0));
  }
  return point;
}

}  // namespace noiseloom
