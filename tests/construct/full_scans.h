// What parts of void and cluster find faster, or need not look for: by scans of all pixels.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "construct/fields/vac_field.h"
#include "construct/plane_field.h"
#include "noiseloom/construct/void_and_cluster.h"

namespace noiseloom::oracle {

// Every pixel of a field of one slice, in the order in which they are picked, each from the energies after all before.
std::vector<std::uint64_t> picks_one_by_one(const VacSpec& spec, VacField field, VacView view);

// What a field of `num_cells` pixels, of which the first has this position in the texture, is to pick.
std::optional<std::uint32_t> pick_of(const PlaneField& field, std::uint32_t num_cells, const VacTieHash& hash,
                                     std::uint64_t first_position, VacView view);

// Whether two pixels below `num_pixels` have one hash.
bool has_equals(const VacTieHash& hash, std::uint64_t num_pixels);

}  // namespace noiseloom::oracle
