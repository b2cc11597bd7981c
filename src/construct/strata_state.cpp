#include "construct/strata_state.h"

#include <algorithm>

#include "noiseloom/core/index.h"

namespace noiseloom {

StrataState::StrataState(const Extents& extents, const FilterSpec& filter, int axis, double sharpness,
                         std::uint64_t seed)
    : extents_(extents),
      cells_(narrow<std::uint32_t>(extents.cells_per_slice())),
      kernel_(extents, filter, sharpness, energy_bits(Retiring::yes)),
      hash_(seed),
      places_(static_cast<std::size_t>(extents.num_slices()), std::vector<std::uint32_t>(cells_, pixel_is_off)),
      stack_of_(places_.size()) {
  for (const SliceIndex slice : extents.slices()) {
    const auto s = static_cast<std::size_t>(slice);
    fields_.emplace_back(kernel_, hash_, first_position(s), Retiring::yes);
    fields_.back().clear();
    fields_.back().watch(true, false);
    Extents::SliceCoord first = extents.slice_coord(slice);
    first[static_cast<std::size_t>(axis - 2)] = 0;
    const auto of_first = static_cast<std::size_t>(extents.slice_index(first));
    if (of_first == s) stacks_.emplace_back();
    stack_of_[s] = of_first == s ? stacks_.size() - 1 : stack_of_[of_first];
    stacks_[stack_of_[s]].push_back(static_cast<std::int32_t>(slice));
  }
  filled_in_.resize(stacks_.size() * cells_);
}

void StrataState::begin_stratum() {
  std::fill(filled_in_.begin(), filled_in_.end(), nobody);
  for (PlaneField& field : fields_) field.open_all();
}

void StrataState::act(std::size_t slice, bool on, std::span<const std::uint32_t> cells) {
  for (const SliceStamp& stamp : std::span(kernel_.stamps()).subspan(1)) {
    const SliceIndex to = extents_.slice_at(SliceIndex(slice), stamp.offset);
    fields_[static_cast<std::size_t>(to)].act(stamp, on, cells);
  }
}

template <class Do>
void StrataState::for_others_that_lack(std::size_t slice, std::uint32_t cell, const Do& change) {
  for (const std::int32_t other : stack_of(slice)) {
    const auto o = static_cast<std::size_t>(other);
    if (o != slice && lacks(o, cell)) change(fields_[o]);
  }
}

void StrataState::fill(std::size_t slice, std::uint32_t cell, std::uint32_t place) {
  places_[slice][cell] = place;
  filled_in(slice, cell) = static_cast<std::int32_t>(slice);
  for_others_that_lack(slice, cell, [cell](PlaneField& field) { field.close(cell); });
}

void StrataState::fill_open(std::size_t slice, std::uint32_t cell, std::uint32_t place) {
  fill(slice, cell, place);
  fields_[slice].turn_on(cell);
  act(slice, true, std::span(&cell, 1));
}

void StrataState::fill_closed(std::size_t slice, std::uint32_t cell, std::uint32_t place) {
  places_[slice][cell] = place;
  filled_in(slice, cell) = static_cast<std::int32_t>(slice);
  fields_[slice].open(cell);
  fields_[slice].turn_on(cell);
  act(slice, true, std::span(&cell, 1));
}

void StrataState::empty(std::size_t slice, std::uint32_t cell) {
  places_[slice][cell] = pixel_is_off;
  fields_[slice].turn_off(cell);
  act(slice, false, std::span(&cell, 1));
}

void StrataState::free(std::size_t slice, std::uint32_t cell) {
  filled_in(slice, cell) = nobody;
  for_others_that_lack(slice, cell, [cell](PlaneField& field) { field.reopen(cell); });
}

}  // namespace noiseloom
