#include "construct/course.h"

#include <algorithm>

namespace noiseloom {
namespace {

// A visit picks one cell in so many. Of 64x64x32, gauss 1.3435 x ema, sharpness 1.4, R is 0.0466 with 256, 0.0462 with
// 1024 and with 4096, which takes a third more time (construct_bench).
constexpr std::int64_t cells_per_point = 1024;

// What relaxing may take at most, in picks for each point of the start pattern, of which about 0.4 are usual; and for
// each point of the half of a circular scale, of which about 0.02 are.
constexpr double most_swaps_per_point = 4;
constexpr double most_swaps_per_point_of_half = 0.25;

}  // namespace

Exchanged::Exchanged(const ConstructProgress& progress)
    : off(std::min(progress.num_placed / 2, progress.num_start_points)), on(progress.num_placed - off) {}

Course::Course(std::int64_t cells, SampleScale scale)
    : cells_(cells), scale_(scale), points_(std::max<std::int64_t>(1, cells / cells_per_point)) {}

ConstructProgress Course::start(std::int64_t num_start_points) const {
  if (is_circular()) return {.phase = ConstructPhase::spread, .num_start_points = cells_ / 2};
  return {.phase = ConstructPhase::relax, .num_start_points = num_start_points};
}

std::int64_t Course::picks_of_visit(const ConstructProgress& progress) const {
  const std::int64_t half = progress.num_start_points;
  switch (progress.phase) {
    case ConstructPhase::relax:
      return points_;
    case ConstructPhase::spread:
      return std::min(points_, half - num_on(progress));
    case ConstructPhase::drain:
      return std::min(points_, half - progress.num_placed);
    case ConstructPhase::exchange:
      return std::min(points_, cells_ - half - Exchanged(progress).on);
    default:
      return std::min(points_, cells_ - progress.num_placed);
  }
}

std::int64_t Course::most_rounds_of_relax(const ConstructProgress& progress) const {
  const double swaps_per_point = is_circular() ? most_swaps_per_point_of_half : most_swaps_per_point;
  return static_cast<std::int64_t>(swaps_per_point * static_cast<double>(progress.num_start_points)) / points_ + 1;
}

std::int64_t Course::num_placed_after(const ConstructProgress& progress) const {
  const std::int64_t picks = picks_of_visit(progress);
  if (progress.phase == ConstructPhase::spread) return 0;
  if (progress.phase != ConstructPhase::exchange) return progress.num_placed + picks;
  return std::min(progress.num_placed + 2 * picks, cells_);
}

std::int64_t Course::num_on(const ConstructProgress& progress) const {
  const std::int64_t start = progress.num_start_points;
  switch (progress.phase) {
    case ConstructPhase::spread:
      return progress.rounds > start / points_ ? start : progress.rounds * points_;
    case ConstructPhase::relax:
      return start;
    case ConstructPhase::drain:
      return start - progress.num_placed;
    case ConstructPhase::exchange:
      return start - Exchanged(progress).off;
    default:
      return 0;
  }
}

// A pixel that is swapped on may be swapped off again in the same visit, so swaps go one by one.
void Course::carry_out(const ConstructProgress& progress, const Changes& changes,
                       std::vector<std::uint32_t>& places) const {
  const auto start_points = static_cast<std::uint32_t>(progress.num_start_points);
  auto place = static_cast<std::uint32_t>(progress.num_placed);
  switch (progress.phase) {
    case ConstructPhase::spread:
      for (const std::uint32_t cell : changes.on) places[cell] = pixel_is_on;
      break;
    case ConstructPhase::relax:
      for (std::size_t k = 0; k < changes.on.size(); ++k) {
        places[changes.off[k]] = pixel_is_off;
        places[changes.on[k]] = pixel_is_on;
      }
      break;
    case ConstructPhase::drain:
      for (const std::uint32_t cell : changes.off) places[cell] = start_points - 1 - place++;
      break;
    case ConstructPhase::exchange: {
      const Exchanged done(progress);
      auto lower = static_cast<std::uint32_t>(done.off);
      auto upper = start_points + static_cast<std::uint32_t>(done.on);
      for (const std::uint32_t cell : changes.off) places[cell] = lower++;
      for (const std::uint32_t cell : changes.on) places[cell] = upper++;
      break;
    }
    default:
      for (const std::uint32_t cell : changes.on) places[cell] = place++;
  }
}

bool Course::is_on(const ConstructProgress& progress, std::uint32_t entry) {
  const bool has_place = entry < pixel_is_on;
  switch (progress.phase) {
    case ConstructPhase::fill:
      return has_place;
    case ConstructPhase::exchange:
      return has_place ? std::int64_t{entry} >= progress.num_start_points : entry == pixel_is_on;
    default:
      return entry == pixel_is_on;
  }
}

// By picks.
double Course::fraction(const ConstructProgress& progress) const {
  const auto points = static_cast<double>(progress.num_start_points);
  const auto cells = static_cast<double>(cells_);
  const auto placed = static_cast<double>(progress.num_placed);
  const double relax = (is_circular() ? 0.02 : 0.5) * points;
  const double relaxed = std::min(relax, static_cast<double>(progress.rounds * points_));
  const double all = relax + points + cells;
  switch (progress.phase) {
    case ConstructPhase::spread:
      return static_cast<double>(num_on(progress)) / all;
    case ConstructPhase::relax:
      return ((is_circular() ? points : 0) + relaxed) / all;
    case ConstructPhase::drain:
      return (relax + placed) / all;
    case ConstructPhase::fill:
    case ConstructPhase::exchange:
      return (relax + points + placed) / all;
    case ConstructPhase::done:
      break;
  }
  return 1;
}

}  // namespace noiseloom
