#include "construct/vac_fields.h"

#include <algorithm>

#include "noiseloom/core/partition.h"

namespace noiseloom {

VacFields::VacFields(const VacSpec& spec, const VacKernel& kernel, std::int32_t begin, std::int32_t end,
                     ThreadPool& pool)
    : pool_(pool) {
  const auto cells = static_cast<std::uint64_t>(spec.extents.cells_per_slice());
  begin_ = cells * static_cast<std::uint64_t>(begin);
  end_ = cells * static_cast<std::uint64_t>(end);
  const Partition split(end - begin, std::max(1, std::min<int>(pool.num_threads(), end - begin)));
  for (int i = 0; i < split.num_ranks(); ++i) {
    parts_.emplace_back(spec, kernel, begin + split.begin(i), begin + split.end(i));
    part_ends_.push_back(cells * static_cast<std::uint64_t>(begin + split.end(i)));
  }
}

VacField& VacFields::part_of(std::uint64_t position) {
  std::size_t i = 0;
  while (position >= part_ends_[i]) ++i;
  return parts_[i];
}

std::size_t VacFields::num_leaves() const {
  std::size_t sum = 0;
  for (const VacField& part : parts_) sum += part.bounds().size();
  return sum;
}

void ThreadTrial::begin_batch() {
  if (batch_ < batches_of_trial) {
    by_threads_ = true;
  } else if (batch_ < 2 * batches_of_trial) {
    by_threads_ = false;
  } else {
    by_threads_ = better_;
  }
  begun_ = std::chrono::steady_clock::now();
}

void ThreadTrial::end_batch(std::size_t num_picks) {
  Tried& tried = tried_[by_threads_ ? 1 : 0];
  tried.seconds += std::chrono::duration<double>(std::chrono::steady_clock::now() - begun_).count();
  tried.picks += static_cast<double>(num_picks);
  ++batch_;
  if (batch_ == 2 * batches_of_trial) {
    const bool better = tried_[1].seconds * tried_[0].picks <= tried_[0].seconds * tried_[1].picks;
    stretch_ = better == better_ ? std::min(2 * stretch_, longest_stretch) : shortest_stretch;
    better_ = better;
  } else if (batch_ >= stretch_) {
    batch_ = 0;
    tried_ = {};
  }
}

void VacFields::for_each(const std::function<void(VacField&, std::size_t)>& body) {
  if (!trial_.by_threads()) {
    for (std::size_t i = 0; i < parts_.size(); ++i) body(parts_[i], i);
    return;
  }
  pool_.for_each(static_cast<std::int64_t>(parts_.size()),
                 [&](std::int64_t i, int) { body(parts_[static_cast<std::size_t>(i)], static_cast<std::size_t>(i)); });
}

void VacFields::clear() {
  for_each([](VacField& part, std::size_t) { part.clear(); });
}
void VacFields::turn_on(std::span<const std::uint64_t> positions) {
  for_each([&](VacField& part, std::size_t) { part.turn_on(positions); });
}
void VacFields::refresh_bounds(VacView view) {
  for_each([&](VacField& part, std::size_t) { part.refresh_bounds(view); });
}

}  // namespace noiseloom
