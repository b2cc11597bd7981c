#include "noiseloom/run/loop.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <limits>
#include <thread>

#include "noiseloom/core/quantity_text.h"
#include "noiseloom/dist/activity.h"
#include "noiseloom/run/stop_signals.h"

namespace noiseloom {
namespace {

// What the ranks tell each other at every safe point.
constexpr std::uint32_t signal_bit = 1;
constexpr std::uint32_t limit_bit = 2;
constexpr std::uint32_t reader_bit = 4;
constexpr std::uint32_t checkpoint_bit = 8;

constexpr double first_retry_s = 30;
// Before the further tries of the last save. Short, as whoever asked for the stop may kill soon.
constexpr std::array<double, 2> last_waits_s = {1, 4};

}  // namespace

Surroundings real_surroundings() {
  const auto begun = std::chrono::steady_clock::now();
  return {[begun] { return std::chrono::duration<double>(std::chrono::steady_clock::now() - begun).count(); },
          noted_stop_signal,
          [](double seconds) { std::this_thread::sleep_for(std::chrono::duration<double>(seconds)); }};
}

RunLoop::RunLoop(Job& job, const LoopSettings& settings, double earlier_s, const Surroundings& surroundings,
                 const SaveRun& save, const Communicator& communicator, Progress& progress)
    : job_(job),
      settings_(settings),
      earlier_s_(earlier_s),
      surroundings_(surroundings),
      save_(save),
      communicator_(communicator),
      progress_(progress),
      next_save_s_(surroundings.part_s() + settings.checkpoint_every_s),
      retry_s_(first_retry_s),
      reported_s_(surroundings.part_s()),
      waited_s_(seconds_waited()) {}

std::uint32_t RunLoop::bits_due() const {
  std::uint32_t bits = surroundings_.stop_signal() != 0 ? signal_bit : 0;
  if (!communicator_.is_root()) return bits;
  const double now = surroundings_.part_s();
  // Not before the first step: a limit shorter than the start-up would otherwise be resumed for ever.
  if (settings_.time_limit_s > 0 && has_moved_ && now >= settings_.time_limit_s) bits |= limit_bit;
  if (progress_.reader_is_gone()) bits |= reader_bit;
  if (now >= next_save_s_) bits |= checkpoint_bit;
  return bits;
}

std::string RunLoop::stop_cause(std::uint32_t bits) const {
  const int number = surroundings_.stop_signal();
  if ((bits & signal_bit) != 0) return number != 0 ? signal_name(number) : "a signal to another rank";
  if ((bits & limit_bit) != 0) return "--time-limit";
  return "a log that nobody reads any more";
}

LoopResult RunLoop::run() {
  const bool as_json = communicator_.any_bits(progress_.is_json() ? 1U : 0U) != 0;
  while (!job_.finished()) {
    const std::uint32_t bits = communicator_.any_bits(bits_due());
    if ((bits & (signal_bit | limit_bit | reader_bit)) != 0) return {false, stop_cause(bits), save_at_stop()};
    if ((bits & checkpoint_bit) != 0) checkpoint();
    {
      const Activity computing(Activity::Kind::computing, "computes a step");
      job_.step(run_s());
    }
    note_step();
    has_moved_ = true;
    report(as_json);
  }
  return {true, "", save_at_last()};
}

// All ranks have a part in a report for programs.
void RunLoop::report(bool as_json) {
  const double now = surroundings_.part_s();
  const auto figures = [&] { return job_.figures(run_s(), surroundings_.part_s()); };
  if (!as_json) return progress_.update(job_.num_rows(), now, figures);
  const bool is_due = progress_.is_due(job_.num_rows(), now);
  if (communicator_.any_bits(is_due ? 1U : 0U) == 0) return;
  const std::vector<JsonMember> of_ranks = figures_of_ranks();
  progress_.update(job_.num_rows(), now, [&] {
    ProgressFigures f = figures();
    f.json.emplace_back("seconds_since_save", saved_s_ < 0 ? std::numeric_limits<double>::quiet_NaN() : now - saved_s_);
    f.json.insert(f.json.end(), of_ranks.begin(), of_ranks.end());
    return f;
  });
}

// Since the last report: the rank that computed for the largest part of the time is the slowest, for which the others
// wait. *Collective*
std::vector<JsonMember> RunLoop::figures_of_ranks() {
  constexpr double parts = 1e6;
  const double now = surroundings_.part_s();
  const double waited = seconds_waited();
  const double elapsed = now - reported_s_;
  const double busy = elapsed > 0 ? std::clamp(1 - (waited - waited_s_) / elapsed, 0.0, 1.0) : 1;
  reported_s_ = now;
  waited_s_ = waited;
  const std::uint64_t own[] = {static_cast<std::uint64_t>(busy * parts), static_cast<std::uint64_t>(job_.bytes_sent())};
  const std::vector<std::uint64_t> all = communicator_.gather_all(own);
  std::size_t slowest = 0;
  std::size_t fastest = 0;
  std::uint64_t bytes = 0;
  for (std::size_t rank = 0; 2 * rank < all.size(); ++rank) {
    if (all[2 * rank] > all[2 * slowest]) slowest = rank;
    if (all[2 * rank] < all[2 * fastest]) fastest = rank;
    bytes += all[2 * rank + 1];
  }
  return {{"bytes_sent", static_cast<std::int64_t>(bytes)},
          {"slowest_rank", static_cast<std::int64_t>(slowest)},
          {"slowest_computed", static_cast<double>(all[2 * slowest]) / parts},
          {"fastest_rank", static_cast<std::int64_t>(fastest)},
          {"fastest_computed", static_cast<double>(all[2 * fastest]) / parts}};
}

void RunLoop::checkpoint() {
  const std::string position = job_.position();
  try {
    save_();
  } catch (const SharedEnvironmentError& error) {
    const double wait_s = std::min(retry_s_, settings_.checkpoint_every_s);
    progress_.warn(
        fmt::format("not saved at {}: {}; {}; going on, and trying again in {}", position, error.what(),
                    saved_position_.empty() ? "nothing of this part is saved yet" : "still saved: " + saved_position_,
                    duration_text(wait_s)));
    next_save_s_ = surroundings_.part_s() + wait_s;
    retry_s_ *= 2;
    return;
  }
  saved_position_ = position;
  saved_s_ = surroundings_.part_s();
  next_save_s_ = surroundings_.part_s() + settings_.checkpoint_every_s;
  retry_s_ = first_retry_s;
  progress_.say("saved at " + position);
}

// What the file says of the run at its stop belongs into it. Where that takes long to find out, the run is saved first,
// as a second signal would end it; whatever fails from then on costs those words alone, and no part of the run.
std::string RunLoop::save_at_stop() {
  if (job_.refreshes_quickly()) {
    job_.refresh();
    return save_at_last();
  }
  const std::string checksum = save_at_last();
  try {
    job_.refresh();
    return save_();
  } catch (const SharedEnvironmentError& error) {
    progress_.warn(fmt::format("saved, but not once more with what is known of the run at its stop ({}): {}",
                               job_.position(), error.what()));
    return checksum;
  }
}

std::string RunLoop::save_at_last() {
  for (const double wait_s : last_waits_s) {
    try {
      return save_();
    } catch (const SharedEnvironmentError& error) {
      progress_.warn(fmt::format("not saved: {}; trying again in {}", error.what(), duration_text(wait_s)));
    }
    surroundings_.wait_s(wait_s);
  }
  try {
    return save_();
  } catch (const SharedEnvironmentError& error) {
    throw SharedEnvironmentError(fmt::format("{}\n{} is not saved; {}", error.what(), job_.position(),
                                             saved_position_.empty()
                                                 ? "what was saved before this part of the run is as it was"
                                                 : "what was saved last is whole: " + saved_position_));
  }
}

}  // namespace noiseloom
