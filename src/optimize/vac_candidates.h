// The next candidates of a field: all pixels with a key up to some limit, a few thousandths of the field at a time.
#pragma once

#include "optimize/vac_field.h"

namespace noiseloom {

// A limit that a share of about `fraction` of the leaves may reach, going by their bounds; 0 when no leaf has a pixel
// left.
std::uint64_t vac_propose_limit(std::span<const std::uint32_t> bounds, double fraction);

// Replaces `found` by all pixels with a key up to the limit that is returned, ascending in position; at least one
// unless none is left, at most `max_found` >= 1. Bounds must be right for `view`.
std::uint64_t vac_find_candidates(VacField& field, VacView view, const VacTieHash& hash, double fraction,
                                  std::size_t max_found, std::vector<VacCandidate>& found);

}  // namespace noiseloom
