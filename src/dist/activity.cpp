#include "noiseloom/dist/activity.h"

#include <atomic>

namespace noiseloom {
namespace {

// One of each a process: the thread that talks to other ranks sets them, the watchdog's reads them. That it may see
// parts of two activities costs a wrong word in a message.
std::atomic<Activity::Kind> present_kind{Activity::Kind::computing};
std::atomic<const char*> present_words{"starts"};
std::atomic<int> present_other{-1};
std::atomic<std::uint64_t> steps{0};
std::atomic<std::int64_t> waited_ns{0};

void set_activity(const Activity::Now& now) {
  present_kind.store(now.kind, std::memory_order_relaxed);
  present_words.store(now.words, std::memory_order_relaxed);
  present_other.store(now.other.value(), std::memory_order_relaxed);
}

}  // namespace

Activity::Activity(Kind kind, const char* words, Rank other) : before_(now()) {
  if (kind == Kind::waiting && before_.kind != Kind::waiting) begun_ = std::chrono::steady_clock::now();
  set_activity({kind, words, other});
}

Activity::~Activity() {
  set_activity(before_);
  if (begun_ == std::chrono::steady_clock::time_point{}) return;
  const std::chrono::nanoseconds waited = std::chrono::steady_clock::now() - begun_;
  waited_ns.fetch_add(waited.count(), std::memory_order_relaxed);
}

double seconds_waited() { return 1e-9 * static_cast<double>(waited_ns.load(std::memory_order_relaxed)); }

Activity::Now Activity::now() {
  return {present_kind.load(std::memory_order_relaxed), present_words.load(std::memory_order_relaxed),
          Rank(present_other.load(std::memory_order_relaxed))};
}

void note_step() { steps.fetch_add(1, std::memory_order_relaxed); }
std::uint64_t num_steps_noted() { return steps.load(std::memory_order_relaxed); }

}  // namespace noiseloom
