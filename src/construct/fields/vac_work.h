// Work in pieces that are each of one thread, in whose caches what they touch lies. A thread with nothing left to do
// takes pieces of others.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <vector>

#include "noiseloom/core/parallel.h"

namespace noiseloom {

class VacWork {
 public:
  // The pool must outlive the work.
  VacWork(ThreadPool& pool, std::size_t num_pieces) : pool_(pool), taken_(num_pieces) {}

  // Calls body(piece) for each, in parallel; each thread begins with its own.
  void for_each(const std::function<void(std::size_t)>& body) {
    const std::size_t num = taken_.size();
    const auto threads = static_cast<std::size_t>(pool_.num_threads());
    if (threads == 1 || num < 2) {
      for (std::size_t i = 0; i < num; ++i) body(i);
      return;
    }
    for (std::atomic<bool>& taken : taken_) taken.store(false, std::memory_order_relaxed);
    pool_.for_each(pool_.num_threads(), [&](std::int64_t, int worker) {
      for (const bool of_others : {false, true}) {
        for (std::size_t i = 0; i < num; ++i) {
          const bool own = i * threads / num == static_cast<std::size_t>(worker);
          if (own == of_others || taken_[i].exchange(true)) continue;
          body(i);
        }
      }
    });
  }

 private:
  ThreadPool& pool_;
  std::vector<std::atomic<bool>> taken_;
};

}  // namespace noiseloom
