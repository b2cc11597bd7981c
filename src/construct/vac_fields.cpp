#include "construct/vac_fields.h"

#include <algorithm>
#include <chrono>
#include <thread>

#include "noiseloom/core/partition.h"

namespace noiseloom {

VacFields::VacFields(const VacSpec& spec, const VacKernel& kernel, std::int32_t begin, std::int32_t end,
                     ThreadPool& pool)
    : pool_(pool), sorter_(VacLayout(spec, begin, end), kernel) {
  const auto cells = static_cast<std::uint64_t>(spec.extents.cells_per_slice());
  begin_ = cells * static_cast<std::uint64_t>(begin);
  end_ = cells * static_cast<std::uint64_t>(end);
  const Partition split(end - begin, std::max(1, std::min<int>(pool.num_threads(), end - begin)));
  for (int i = 0; i < split.num_ranks(); ++i) {
    parts_.emplace_back(spec, kernel, begin + split.begin(i), begin + split.end(i));
    part_ends_.push_back(cells * static_cast<std::uint64_t>(begin + split.end(i)));
  }
  progress_ = std::vector<Progress>(parts_.size());
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

// Brings one part up to the portions that have come. False where there is nothing to do, or others are at it.
bool VacFields::lend_a_hand(bool on, std::size_t start, const Turned& turned) {
  for (std::size_t i = 0; i < parts_.size(); ++i) {
    const std::size_t p = (start + i) % parts_.size();
    Progress& progress = progress_[p];
    const bool complete = complete_.load(std::memory_order_acquire);
    const std::size_t have = num_portions_.load(std::memory_order_acquire);
    const auto idle = [&] {
      return progress.num_done.load(std::memory_order_relaxed) == have && (!complete || progress.ended);
    };
    if (idle()) continue;
    if (progress.taken.exchange(true, std::memory_order_acquire)) continue;
    const std::size_t next = progress.num_done.load(std::memory_order_relaxed);
    const bool work = !idle();
    if (next < have) {
      const VacPortion& portion = portions_[next];
      const auto [first, last] = parts_[p].own(portion.positions);
      parts_[p].turn(on, portion.positions, portion.by_line);
      turned(portion, first, last);
      progress.num_done.store(next + 1, std::memory_order_relaxed);
    }
    if (work && complete && progress.num_done.load(std::memory_order_relaxed) == have) {
      parts_[p].end_of_batch();
      progress.ended.store(true, std::memory_order_release);
    }
    progress.taken.store(false, std::memory_order_release);
    if (work) return true;
  }
  return false;
}

bool VacFields::all_ended() const {
  return std::ranges::all_of(progress_, [](const Progress& p) { return p.ended.load(std::memory_order_acquire); });
}

void VacFields::help_to_the_end(bool on, std::size_t start, const Turned& turned) {
  using Clock = std::chrono::steady_clock;
  constexpr std::chrono::microseconds patience{200};  // then the processor is left to programs that have work for it
  auto last_work = Clock::now();
  while (!failed_.load(std::memory_order_relaxed) && !all_ended()) {
    if (lend_a_hand(on, start, turned)) {
      last_work = Clock::now();
    } else if (Clock::now() - last_work < patience) {
      std::this_thread::yield();
    } else {
      std::this_thread::sleep_for(std::chrono::microseconds(50));
    }
  }
}

void VacFields::turn_as_they_come(bool on, bool streamed, const std::function<bool(VacPortion&)>& next,
                                  const Turned& turned) {
  for (Progress& progress : progress_) {
    progress.num_done = 0;
    progress.ended = false;
  }
  num_portions_ = 0;
  complete_ = false;
  const auto hand_on = [&] {
    for (std::size_t n = 0; n < most_portions && next(portions_[n]); ++n) {
      sorter_.sort(portions_[n].positions, portions_[n].by_line);
      num_portions_.store(n + 1, std::memory_order_release);
    }
    complete_.store(true, std::memory_order_release);
  };
  if (!streamed) {
    hand_on();
    return for_each([&](VacField&, std::size_t part) {
      while (lend_a_hand(on, part, turned)) {
      }
    });
  }
  // As many bodies as threads, and one that helps stays to the end: so each thread has one, this thread among them.
  pool_.for_each(pool_.num_threads(), [&](std::int64_t, int worker) {
    try {
      if (worker == 0 && !complete_) hand_on();
      const std::size_t start = parts_.size() * static_cast<std::size_t>(worker);
      help_to_the_end(on, start / static_cast<std::size_t>(pool_.num_threads()), turned);
    } catch (...) {
      failed_ = true;
      throw;
    }
  });
}

}  // namespace noiseloom
