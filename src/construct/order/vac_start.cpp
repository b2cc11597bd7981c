#include "construct/order/vac_start.h"

#include <algorithm>

#include "noiseloom/core/decimal.h"
#include "noiseloom/core/random.h"

namespace noiseloom {

std::int64_t vac_num_start_points(const VacSpec& spec) {
  return decimal_of(spec.density).floor_of_times(spec.extents.num_cells());
}

std::uint64_t vac_start_draw(const VacSpec& spec, std::uint64_t draw) {
  const RandomBlock block = random_block(spec.seed, Purpose::start_pattern, 0, 0, draw);
  const std::uint64_t bits = (std::uint64_t{block[0]} << 32) | block[1];
  const auto num_cells = static_cast<std::uint64_t>(spec.extents.num_cells());
  return static_cast<std::uint64_t>((static_cast<unsigned __int128>(bits) * num_cells) >> 64);
}

std::vector<std::uint64_t> vac_start_pattern(const VacSpec& spec) {
  const auto num_points = static_cast<std::size_t>(vac_num_start_points(spec));
  std::vector<bool> on(static_cast<std::size_t>(spec.extents.num_cells()));
  std::vector<std::uint64_t> points;
  points.reserve(num_points);
  for (std::uint64_t draw = 0; points.size() < num_points; ++draw) {
    const std::uint64_t position = vac_start_draw(spec, draw);
    if (on[position]) continue;  // drawn before: a pixel is turned on once
    on[position] = true;
    points.push_back(position);
  }
  std::sort(points.begin(), points.end());
  return points;
}

void vac_turn_on_start(const VacSpec& spec, VacExchange& exchange, VacOrder& order) {
  std::uint64_t draw = 0;
  for (std::int64_t missing = vac_num_start_points(spec); missing > 0;) {
    std::int64_t own = 0;
    for (const std::uint64_t end = draw + static_cast<std::uint64_t>(missing); draw < end; ++draw) {
      const std::uint64_t position = vac_start_draw(spec, draw);
      if (!order.has(position) || order.is_on(position)) continue;
      order.set_on(position);
      ++own;
    }
    missing -= exchange.sum(own);
  }
}

}  // namespace noiseloom
