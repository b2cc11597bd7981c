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

void VacFields::for_each(const std::function<void(VacField&, std::size_t)>& body) {
  pool_.for_each(static_cast<std::int64_t>(parts_.size()),
                 [&](std::int64_t i, int) { body(parts_[static_cast<std::size_t>(i)], static_cast<std::size_t>(i)); });
}

void VacFields::clear() {
  for_each([](VacField& part, std::size_t) { part.clear(); });
}
void VacFields::turn_on(std::span<const std::uint64_t> positions) {
  for_each([&](VacField& part, std::size_t) { part.turn_on(positions); });
}
void VacFields::turn_off(std::span<const std::uint64_t> positions) {
  for_each([&](VacField& part, std::size_t) { part.turn_off(positions); });
}
void VacFields::refresh_bounds(VacView view) {
  for_each([&](VacField& part, std::size_t) { part.refresh_bounds(view); });
}

}  // namespace noiseloom
