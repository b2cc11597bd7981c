// What construction within strata over time (time_strata.h) is at, and the steps that every part of it is made of: who
// has filled a pixel in this stratum, and the energies of all slices.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "construct/plane_field.h"
#include "construct/stamp_kernel.h"
#include "noiseloom/construct/slice_construction.h"
#include "noiseloom/core/extents.h"

namespace noiseloom {

class StrataState {
 public:
  static constexpr std::int32_t nobody = -1;

  // `axis`: the slice axis along which the slices of a stack lie.
  StrataState(const Extents& extents, const FilterSpec& filter, int axis, double sharpness, std::uint64_t seed);
  StrataState(const StrataState&) = delete;
  StrataState& operator=(const StrataState&) = delete;

  const Extents& extents() const { return extents_; }
  const StampKernel& kernel() const { return kernel_; }
  std::uint32_t cells() const { return cells_; }
  std::size_t num_slices() const { return fields_.size(); }
  // Slices that differ in the axis alone.
  const std::vector<std::vector<std::int32_t>>& stacks() const { return stacks_; }
  const std::vector<std::int32_t>& stack_of(std::size_t slice) const { return stacks_[stack_of_[slice]]; }

  // The slice of its stack that has filled a cell in this stratum, or nobody.
  std::int32_t holder(std::size_t stack, std::uint32_t cell) const { return filled_in_[stack * cells_ + cell]; }
  std::int32_t holder_beside(std::size_t slice, std::uint32_t cell) const { return holder(stack_of_[slice], cell); }
  bool lacks(std::size_t slice, std::uint32_t cell) const { return places_[slice][cell] == pixel_is_off; }
  std::uint32_t place(std::size_t slice, std::uint32_t cell) const { return places_[slice][cell]; }
  void set_place(std::size_t slice, std::uint32_t cell, std::uint32_t place) { places_[slice][cell] = place; }
  std::vector<std::vector<std::uint32_t>> take_places() { return std::move(places_); }
  // Without what the pixel itself contributes.
  std::uint32_t energy(std::size_t slice, std::uint32_t cell) const { return fields_[slice].word(cell) & energy_mask; }
  // What breaks a tie of energies.
  std::uint32_t tie(std::size_t slice, std::uint32_t cell) const { return hash_(first_position(slice) + cell); }
  // The same for whatever is told apart by a moment and a slice.
  std::uint32_t tie_at(std::uint32_t moment, std::size_t slice) const {
    return hash_((std::uint64_t{moment} + 1) << 32 | slice);
  }
  // What it adds to the energies of two slices when one has a cell instead of the other, which has filled it. Far more
  // than any where it has it already.
  std::int64_t cost_of_handing(std::uint32_t cell, std::size_t from, std::size_t to) const {
    const std::uint32_t word = fields_[to].word(cell);
    constexpr auto never = std::int64_t{1} << 32;
    return ((word & vac_flag) != 0 ? never : std::int64_t{word & energy_mask}) - energy(from, cell);
  }
  PlaneField& field(std::size_t slice) { return fields_[slice]; }

  void begin_stratum();
  // What is turned on (off) in a slice, as the others see it.
  void act(std::size_t slice, bool on, std::span<const std::uint32_t> cells);
  // A cell that is open, and so is closed in the other slices of the stack from here on; whoever calls turns it on.
  void fill(std::size_t slice, std::uint32_t cell, std::uint32_t place);
  void fill_open(std::size_t slice, std::uint32_t cell, std::uint32_t place);
  // A cell that another slice of the stack had filled, so that all others have it closed already.
  void fill_closed(std::size_t slice, std::uint32_t cell, std::uint32_t place);
  // The slice lacks the cell again. It is to be filled by another slice next, or to be freed.
  void empty(std::size_t slice, std::uint32_t cell);
  void close(std::size_t slice, std::uint32_t cell) { fields_[slice].close(cell); }
  void free(std::size_t slice, std::uint32_t cell);

 private:
  static constexpr std::uint32_t energy_mask = (std::uint32_t{1} << energy_bits(Retiring::yes)) - 1;

  std::uint64_t first_position(std::size_t slice) const { return std::uint64_t{cells_} * slice; }
  std::int32_t& filled_in(std::size_t slice, std::uint32_t cell) {
    return filled_in_[stack_of_[slice] * cells_ + cell];
  }
  template <class Do>
  void for_others_that_lack(std::size_t slice, std::uint32_t cell, const Do& change);

  const Extents extents_;
  const std::uint32_t cells_;
  StampKernel kernel_;
  VacTieHash hash_;
  std::vector<PlaneField> fields_;
  std::vector<std::vector<std::uint32_t>> places_;
  std::vector<std::vector<std::int32_t>> stacks_;
  std::vector<std::size_t> stack_of_;
  std::vector<std::int32_t> filled_in_;
};

}  // namespace noiseloom
