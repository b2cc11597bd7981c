// The vector loops of VacField, compiled for every instruction set and chosen at run time. Integers only, so the width
// of the vectors cannot change a result.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "construct/fields/vac_field.h"

namespace noiseloom::vac_simd {

// Adds (on) or subtracts (off) the rows of `group`, which contains axis x, around every pixel. `data` holds at least
// VacGroupKernel::padding words past the last slice and behind every slice.
void add_rows(const VacLayout& layout, const VacGroupKernel& group, std::uint32_t* data, bool on,
              std::span<const std::uint64_t> positions);

// The same for one pixel; appends the indices of words that are on (off), changed, and are now >= (<=) limit.
void add_rows_watching(const VacLayout& layout, const VacGroupKernel& group, std::uint32_t* data, bool on,
                       std::uint64_t position, std::uint32_t limit, std::vector<std::size_t>& hits);

// The smallest value of each leaf.
void leaf_minima(const VacLayout& layout, const std::uint32_t* data, VacView view, std::uint32_t* bounds);

// See VacField::scan; of leaves [begin, end) of a slice. Leaves that are opened get what waits for them, where
// `pending` is not null.
bool scan_leaves(const VacLayout& layout, std::int64_t slice, std::int64_t begin, std::int64_t end, std::uint32_t* data,
                 VacPending* pending, const VacScan& scan, std::uint32_t* bounds, std::vector<VacCandidate>& found);

// Gives all leaves what waits for them.
void bring_up_all(const VacLayout& layout, std::uint32_t* data, VacPending& pending);

}  // namespace noiseloom::vac_simd
