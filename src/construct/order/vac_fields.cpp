#include "construct/order/vac_fields.h"

#include <algorithm>
#include <chrono>
#include <thread>

#include "construct/order/vac_sources.h"
#include "noiseloom/core/partition.h"

namespace noiseloom {

VacFields::VacFields(const VacSpec& spec, const VacKernel& kernel, std::int32_t begin, std::int32_t end,
                     ThreadPool& pool)
    : pool_(pool), layout_(spec, begin, end) {
  const auto cells = static_cast<std::uint64_t>(spec.extents.cells_per_slice());
  begin_ = cells * static_cast<std::uint64_t>(begin);
  end_ = cells * static_cast<std::uint64_t>(end);
  // Where a group reaches other slices pixel by pixel, each part goes through all picks: then more parts are more work.
  const bool by_slices = std::ranges::all_of(
      kernel.groups(), [](const VacGroupKernel& group) { return group.stays_in_slice() || is_of_slices(group); });
  const int threads = pool.num_threads();
  const int num_parts = threads == 1 || !by_slices ? threads : 8 * threads;
  const Partition split(end - begin, std::max(1, std::min<int>(num_parts, end - begin)));
  for (int i = 0; i < split.num_ranks(); ++i) {
    parts_.emplace_back(spec, kernel, begin + split.begin(i), begin + split.end(i));
    part_ends_.push_back(cells * static_cast<std::uint64_t>(begin + split.end(i)));
  }
  progress_ = std::vector<Progress>(parts_.size());
  for (std::size_t i = 0; i < parts_.size(); ++i) {
    progress_[i].owner = static_cast<int>(i * static_cast<std::size_t>(threads) / parts_.size());
  }
}

VacField& VacFields::part_of(std::uint64_t position) {
  const auto part = std::upper_bound(part_ends_.begin(), part_ends_.end(), position);
  return parts_[static_cast<std::size_t>(part - part_ends_.begin())];
}

std::size_t VacFields::num_leaves() const {
  std::size_t sum = 0;
  for (const VacField& part : parts_) sum += part.bounds().size();
  return sum;
}

void VacFields::for_each(const std::function<void(VacField&, std::size_t)>& body) {
  if (!has_helpers()) {
    for (std::size_t i = 0; i < parts_.size(); ++i) body(parts_[i], i);
    return;
  }
  for (Progress& progress : progress_) progress.taken = false;
  pool_.for_each(pool_.num_threads(), [&](std::int64_t, int worker) {
    for (const bool of_others : {false, true}) {
      for (std::size_t i = 0; i < parts_.size(); ++i) {
        if ((progress_[i].owner != worker) != of_others || progress_[i].taken.exchange(true)) continue;
        body(parts_[i], i);
      }
    }
  });
}

void VacFields::clear() {
  for_each([](VacField& part, std::size_t) { part.clear(); });
}
void VacFields::turn_on(std::span<const std::uint64_t> positions) {
  VacPortion portion;
  portion.positions.assign(positions.begin(), positions.end());
  portion.divide(layout_);
  for_each([&](VacField& part, std::size_t) { part.turn(true, portion); });
}
void VacFields::refresh_bounds(VacView view) {
  for_each([&](VacField& part, std::size_t) { part.refresh_bounds(view); });
}

void VacFields::turn(std::size_t part, bool on, const VacPortion& portion, const Picks& picks, const VacScan* then) {
  const auto [first, last] = parts_[part].own(portion.positions);
  parts_[part].turn(on, portion, then);
  picks.turned(portion, first, last);
}

// Brings one part up to the portions that have come. False where there is nothing to do, or another thread is at it.
bool VacFields::bring_up(std::size_t part, bool on, const Picks& picks, const VacScan* then) {
  Progress& progress = progress_[part];
  const bool complete = complete_.load(std::memory_order_acquire);
  const std::size_t have = num_portions_.load(std::memory_order_acquire);
  const auto idle = [&] {
    return complete ? progress.ended.load(std::memory_order_relaxed)
                    : progress.num_done.load(std::memory_order_relaxed) >= have;
  };
  if (idle() || progress.taken.exchange(true, std::memory_order_acquire)) return false;
  const bool work = !idle();
  const std::size_t done = progress.num_done.load(std::memory_order_relaxed);
  if (work && complete && done == 0) {
    turn(part, on, whole_, picks, then);
  } else if (work && done < have) {
    for (std::size_t n = done; n < have; ++n) {
      turn(part, on, portions_[n], picks, complete && n + 1 == have ? then : nullptr);
    }
  } else if (work && complete && then != nullptr) {
    parts_[part].scan(*then);
  }
  progress.num_done.store(std::max(done, have), std::memory_order_relaxed);
  if (work && complete) {
    if (then == nullptr) parts_[part].end_of_batch();
    progress.ended.store(true, std::memory_order_release);
  }
  progress.taken.store(false, std::memory_order_release);
  return work;
}

// Works on one part: an own one, or, where no more portions will come, one of another thread. False: there is none.
bool VacFields::lend_a_hand(bool on, int worker, const Picks& picks, const VacScan* then) {
  for (std::size_t i = 0; i < parts_.size(); ++i) {
    if (progress_[i].owner == worker && bring_up(i, on, picks, then)) return true;
  }
  for (std::size_t i = 0; i < parts_.size() && complete_; ++i) {
    if (progress_[i].owner == worker || !bring_up(i, on, picks, then)) continue;
    progress_[i].owner = worker;
    return true;
  }
  return false;
}

bool VacFields::all_ended() const {
  return std::ranges::all_of(progress_, [](const Progress& p) { return p.ended.load(std::memory_order_acquire); });
}

void VacFields::help_to_the_end(bool on, int worker, const Picks& picks, const VacScan* then) {
  using Clock = std::chrono::steady_clock;
  constexpr std::chrono::microseconds patience{200};  // then the processor is left to programs that have work for it
  auto last_work = Clock::now();
  while (!failed_.load(std::memory_order_relaxed) && !all_ended()) {
    if (lend_a_hand(on, worker, picks, then)) {
      last_work = Clock::now();
    } else if (Clock::now() - last_work < patience) {
      std::this_thread::yield();
    } else {
      std::this_thread::sleep_for(std::chrono::microseconds(50));
    }
  }
}

void VacFields::hand_on(bool streamed, const Picks& picks) {
  for (std::size_t n = 0; streamed && n < most_portions && picks.next(portions_[n]); ++n) {
    portions_[n].divide(layout_);
    num_portions_.store(n + 1, std::memory_order_release);
  }
  picks.all(whole_);
  whole_.divide(layout_);
  complete_.store(true, std::memory_order_release);
}

void VacFields::turn_as_they_come(bool on, bool streamed, const Picks& picks, const VacScan* then) {
  for (Progress& progress : progress_) {
    progress.taken = false;
    progress.num_done = 0;
    progress.ended = false;
  }
  num_portions_ = 0;
  complete_ = false;
  failed_ = false;
  if (!streamed) {
    hand_on(false, picks);
    return for_each([&](VacField& part, std::size_t i) {
      turn(i, on, whole_, picks, then);
      if (then == nullptr) part.end_of_batch();
    });
  }
  // As many bodies as threads, and one that helps stays to the end: so each thread has one, this thread among them.
  pool_.for_each(pool_.num_threads(), [&](std::int64_t, int worker) {
    try {
      if (worker == 0 && !complete_) hand_on(true, picks);
      help_to_the_end(on, worker, picks, then);
    } catch (...) {
      failed_ = true;
      throw;
    }
  });
}

}  // namespace noiseloom
