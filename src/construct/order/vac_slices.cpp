#include "construct/order/vac_slices.h"

#include <algorithm>
#include <limits>

#include "construct/fields/vac_sources.h"
#include "noiseloom/core/partition.h"

namespace noiseloom {

VacSlices::VacSlices(const VacSpec& spec, const VacKernel& kernel, std::int32_t begin, std::int32_t end,
                     ThreadPool& pool)
    : layout_(spec, begin, end) {
  const auto cells = static_cast<std::uint64_t>(spec.extents.cells_per_slice());
  begin_ = cells * static_cast<std::uint64_t>(begin);
  end_ = cells * static_cast<std::uint64_t>(end);
  const int threads = pool.num_threads();
  const auto sizes = VacWindows::sizes(layout_, kernel, threads);
  // Where a group reaches other slices pixel by pixel, each part goes through all picks: then more parts are more work.
  const int num_parts = threads == 1 || !acts_by_slices(kernel) ? threads : 8 * threads;
  const Partition split(end - begin, std::max(1, std::min<int>(num_parts, end - begin)));
  for (int i = 0; i < split.num_ranks(); ++i) {
    parts_.emplace_back(spec, kernel, begin + split.begin(i), begin + split.end(i),
                        sizes ? std::numeric_limits<std::int64_t>::max() : VacField::usual_cells_to_wait);
    part_ends_.push_back(cells * static_cast<std::uint64_t>(begin + split.end(i)));
  }
  work_.emplace(pool, parts_.size());
  if (sizes && begin < end) windows_.emplace(spec, kernel, *sizes, parts_.front(), pool);
}

VacField& VacSlices::part_of(std::uint64_t position) {
  const auto part = std::upper_bound(part_ends_.begin(), part_ends_.end(), position);
  return parts_[static_cast<std::size_t>(part - part_ends_.begin())];
}

std::size_t VacSlices::num_leaves() const {
  std::size_t sum = 0;
  for (const VacField& part : parts_) sum += part.bounds().size();
  return sum;
}

void VacSlices::for_each(const std::function<void(VacField&, std::size_t)>& body) {
  work_->for_each([&](std::size_t i) { body(parts_[i], i); });
}

void VacSlices::clear() {
  for_each([](VacField& part, std::size_t) { part.clear(); });
}
void VacSlices::turn_on(std::span<const std::uint64_t> positions) {
  if (windows_) {
    windows_->turn_on(positions);
    return;
  }
  VacPortion portion;
  portion.positions.assign(positions.begin(), positions.end());
  portion.divide(layout_);
  for_each([&](VacField& part, std::size_t) { part.turn(true, portion); });
}
void VacSlices::refresh_bounds(VacView view) {
  for_each([&](VacField& part, std::size_t) { part.refresh_bounds(view); });
}

void VacSlices::turn_batch(bool on, VacPortion& portion, const Turned& turned, bool is_last, const VacScan* then) {
  portion.divide(layout_);
  for_each([&](VacField& part, std::size_t) {
    const auto [first, last] = part.own(portion.positions);
    part.turn(on, portion, then);
    turned(first, last);
    if (is_last && then == nullptr) part.end_of_batch();
  });
}

}  // namespace noiseloom
