// The random pattern that void and cluster starts from, drawn by all ranks together.
#pragma once

#include "construct/order/vac_exchange.h"
#include "construct/order/vac_order.h"
#include "noiseloom/construct/void_and_cluster.h"

namespace noiseloom {

// The position that draw number `draw` hits.
std::uint64_t vac_start_draw(const VacSpec& spec, std::uint64_t draw);

// Turns on the pixels of vac_start_pattern(spec) that lie in `order`, whose pixels must be off. Every rank makes all
// draws and keeps those that hit its slices; how many were hit before is summed over ranks, and as many drawn again.
// *Collective*
void vac_turn_on_start(const VacSpec& spec, VacExchange& exchange, VacOrder& order);

}  // namespace noiseloom
