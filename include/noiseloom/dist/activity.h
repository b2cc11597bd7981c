// What this rank is doing, as its watchdog (dist/watchdog.h) sees it from another thread.
#pragma once

#include <chrono>
#include <cstdint>

#include "noiseloom/core/distribution.h"

namespace noiseloom {

// While one lives, the rank does what it says; then again what it did before. To make one takes some ten nanoseconds.
class Activity {
 public:
  enum class Kind : std::uint32_t {
    computing,
    writing,  // may take as long as the disk likes
    waiting,  // for other ranks
  };

  // `words` live as long as the program: "waits for the swaps of". `other`: the rank that is waited for, -1: any.
  explicit Activity(Kind kind, const char* words, Rank other = Rank(-1));
  ~Activity();
  Activity(const Activity&) = delete;
  Activity& operator=(const Activity&) = delete;

  struct Now {
    Kind kind = Kind::computing;
    const char* words = "";
    Rank other{-1};
  };
  static Now now();

 private:
  Now before_;
  std::chrono::steady_clock::time_point begun_{};  // where it is the outermost one of waiting
};

// How long this rank has waited for others since it began.
double seconds_waited();

// A step of the run has been made: what the watchdog takes for progress.
void note_step();
std::uint64_t num_steps_noted();

}  // namespace noiseloom
