#include "optimize/vac_swapper.h"

#include <algorithm>
#include <cstring>

namespace noiseloom {

VacSwapper::VacSwapper(const VacSpec& spec, const VacKernel& kernel, VacFields& fields, VacExchange& exchange,
                       const VacTieHash& hash)
    : fields_(fields),
      exchange_(exchange),
      hash_(hash),
      search_(fields, exchange, hash),
      layout_(spec, 0, spec.extents.num_slices()),
      is_tracked_(fields.end() - fields.begin()),
      parts_(fields.num_parts()) {
  for (const VacGroupKernel& group : kernel.groups()) bins_.emplace_back(layout_, group);
}

std::uint64_t VacSwapper::key_of(const Side& side, std::uint64_t position, std::uint32_t word) const {
  const auto flip = static_cast<std::uint32_t>(side.view);
  return VacCandidate{position, word ^ flip, hash_(position) ^ flip}.key();
}

void VacSwapper::track(std::uint64_t position, std::uint32_t word) {
  const VacLayout::Coord at = layout_.coord(position);
  VacBins::Coord& narrow_at = at_.emplace_back();
  std::transform(at.begin(), at.end(), narrow_at.begin(), [](std::int64_t c) { return static_cast<std::int32_t>(c); });
  for (VacBins& bins : bins_) bins.add(narrow_at);
  positions_.push_back(position);
  words_.push_back(word);
  if (fields_.has(position)) is_tracked_[position - fields_.begin()] = true;
  push(static_cast<std::uint32_t>(words_.size() - 1));
}

// Files a pixel under its present key where that is within the limit of its side. A pixel that can be picked has an
// entry with its key or a smaller one.
void VacSwapper::push(std::uint32_t index) {
  Side& side = side_of(words_[index]);
  const std::uint64_t key = key_of(side, positions_[index], words_[index]);
  if (key > side.limit) return;
  const std::uint64_t order = side.view == VacView::clusters ? ~positions_[index] : positions_[index];
  side.heap.push_back({key, order, index});
  std::push_heap(side.heap.begin(), side.heap.end());
}

// Turns a tracked pixel on or off, for the tracked ones.
void VacSwapper::toggle(std::uint32_t index) {
  words_[index] ^= vac_flag;
  const std::uint32_t on = words_[index] & vac_flag;
  for (const VacBins& bins : bins_) {
    bins.visit(at_[index], [&](std::uint32_t j, std::uint32_t weight) {
      if (weight == 0) return;
      words_[j] += on != 0 ? weight : 0 - weight;
      if ((words_[j] & vac_flag) == on) push(j);  // its key fell
    });
  }
  push(index);
}

// The next pick of a side; nothing when only pixels that are not tracked may be left.
std::optional<VacSwapper::Pick> VacSwapper::take(Side& side) {
  while (!side.heap.empty()) {
    std::pop_heap(side.heap.begin(), side.heap.end());
    const Entry top = side.heap.back();
    side.heap.pop_back();
    if (&side_of(words_[top.index]) != &side) continue;
    const std::uint64_t key = key_of(side, positions_[top.index], words_[top.index]);
    if (key == top.key) return Pick{top.index, key};
    if (key > top.key) push(top.index);  // a smaller key has an entry of its own
  }
  return std::nullopt;
}

void VacSwapper::refill() {
  constexpr double fraction = 0.25;
  ++num_refills_;
  for (const std::uint64_t position : positions_) {
    if (fields_.has(position)) is_tracked_[position - fields_.begin()] = false;
  }
  positions_.clear();
  words_.clear();
  at_.clear();
  for (VacBins& bins : bins_) bins.clear();
  std::vector<VacCandidate> found;
  for (Side* side : {&clusters_, &voids_}) {
    side->heap.clear();
    fields_.refresh_bounds(side->view);
    side->limit = search_.find(side->view, fraction, found);
    for (const VacCandidate& c : found) track(c.position, c.energy ^ static_cast<std::uint32_t>(side->view));
  }
}

void VacSwapper::pick_ahead(std::size_t max_picks) {
  picks_.clear();
  std::optional<std::uint64_t> from = from_;
  while (picks_.size() < max_picks) {
    const bool picks_void = from.has_value();
    const std::optional<Pick> pick = take(picks_void ? voids_ : clusters_);
    if (!pick) return;
    toggle(pick->index);
    picks_.push_back(*pick);
    const std::uint64_t position = positions_[pick->index];
    if (picks_void && position == *from) return;  // the last pick of all
    from = picks_void ? std::nullopt : std::optional(position);
  }
}

// Carries the picks out in one part of this rank's slices, up to one that an intruder makes wrong.
void VacSwapper::carry_out(VacField& field, Part& part) {
  part.valid = picks_.size();
  part.intruders.clear();
  for (part.applied = 0; part.applied < part.valid; ++part.applied) {
    const std::size_t now = part.applied;
    const std::uint64_t position = positions_[picks_[now].index];
    part.hits.clear();
    const bool on = picks_void(now);
    if (on) {
      field.turn_on_watching(position, ~static_cast<std::uint32_t>(clusters_.limit >> 32), part.hits);
    } else {
      field.turn_off_watching(position, static_cast<std::uint32_t>(voids_.limit >> 32), part.hits);
    }
    const Side& side = on ? clusters_ : voids_;  // where keys fell
    for (const std::uint64_t hit : part.hits) {
      if (is_tracked_[hit - fields_.begin()]) continue;
      const std::uint64_t key = key_of(side, hit, field.word(hit));
      if (key > side.limit) continue;
      part.intruders.push_back(hit);
      for (std::size_t later = now + 1; later < part.valid; later += 2) {  // the picks of that side
        if (picks_[later].key >= key) part.valid = later;
      }
    }
  }
}

void VacSwapper::take_back(VacField& field, const Part& part, std::size_t valid) const {
  std::vector<std::uint64_t> on;
  std::vector<std::uint64_t> off;
  for (std::size_t i = valid; i < part.applied; ++i) {
    (picks_void(i) ? on : off).push_back(positions_[picks_[i].index]);
  }
  std::sort(on.begin(), on.end());
  std::sort(off.begin(), off.end());
  field.turn_off(on);
  field.turn_on(off);
}

// How many picks of the batch are right; takes the others back.
std::size_t VacSwapper::agree_on_valid() {
  std::size_t valid = picks_.size();
  for (const Part& part : parts_) valid = std::min(valid, part.valid);
  const std::uint64_t own = valid;
  for (const std::uint64_t of_rank : exchange_.gather(std::span(&own, 1))) {
    valid = std::min(valid, static_cast<std::size_t>(of_rank));
  }
  if (valid == picks_.size()) return valid;
  num_taken_back_ += static_cast<std::int64_t>(picks_.size() - valid);
  fields_.for_each([&](VacField& field, std::size_t i) { take_back(field, parts_[i], valid); });
  for (std::size_t i = picks_.size(); i > valid; --i) toggle(picks_[i - 1].index);
  return valid;
}

void VacSwapper::track_intruders() {
  std::vector<std::uint64_t> own;  // position, word
  for (Part& part : parts_) {
    std::sort(part.intruders.begin(), part.intruders.end());
    part.intruders.erase(std::unique(part.intruders.begin(), part.intruders.end()), part.intruders.end());
    for (const std::uint64_t position : part.intruders) {
      own.push_back(position);
      own.push_back(fields_.word(position));
    }
  }
  const std::vector<std::byte> bytes = exchange_.gather(std::as_bytes(std::span(own)));
  std::vector<std::uint64_t> all(bytes.size() / sizeof(std::uint64_t));
  std::memcpy(all.data(), bytes.data(), bytes.size());
  for (std::size_t i = 0; i < all.size(); i += 2) track(all[i], static_cast<std::uint32_t>(all[i + 1]));
}

bool VacSwapper::advance(std::int64_t max_swaps, std::int64_t max_batch, std::vector<Swap>& swaps) {
  constexpr std::int64_t largest_batch = 1024;
  while (max_swaps > 0) {
    const std::int64_t batch = std::min({batch_, max_batch, max_swaps});
    pick_ahead(static_cast<std::size_t>(2 * batch - (from_ ? 1 : 0)));
    if (picks_.empty()) {
      refill();
      continue;
    }
    ++num_batches_;
    fields_.for_each([&](VacField& field, std::size_t i) { carry_out(field, parts_[i]); });
    const std::size_t valid = agree_on_valid();
    track_intruders();
    batch_ = valid == picks_.size() ? std::min(2 * batch_, largest_batch)
                                    : std::clamp<std::int64_t>(static_cast<std::int64_t>(valid), 16, largest_batch);
    for (std::size_t i = 0; i < valid; ++i) {
      const std::uint64_t position = positions_[picks_[i].index];
      if (!from_) {
        from_ = position;
        continue;
      }
      const std::uint64_t from = *from_;
      from_.reset();
      if (from == position) return false;
      swaps.push_back({from, position});
      --max_swaps;
    }
  }
  return true;
}

}  // namespace noiseloom
