#include "noiseloom/bank/bank.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <exception>
#include <filesystem>
#include <memory>
#include <set>
#include <thread>

#include "bank/index.h"
#include "noiseloom/core/console.h"
#include "noiseloom/core/error.h"
#include "noiseloom/core/stopwatch.h"
#include "noiseloom/dist/activity.h"
#include "noiseloom/files/run_lock.h"
#include "noiseloom/run/generate.h"
#include "noiseloom/run/stop_signals.h"

namespace noiseloom {
namespace fs = std::filesystem;
namespace {

// A lock file that was touched since is most likely held: other members are taken first.
constexpr std::chrono::seconds lately_held{60};

bool seems_held(const std::string& path) {
  std::error_code error;
  const auto touched = fs::last_write_time(path + ".lock", error);
  return !error && fs::file_time_type::clock::now() - touched < lately_held;
}

// The work of one group of ranks. Its first rank decides.
class Group {
 public:
  Group(const Bank& bank, const BankRequest& request, const Communicator& ranks, const SayMember& say, const Warn& warn)
      : bank_(bank), request_(request), ranks_(ranks), say_(say), warn_(warn) {}

  BankResult work();

 private:
  std::int64_t next();
  std::int64_t next_of(bool held_too);
  bool others_may_end();
  bool has_more();
  bool is_to_stop() const { return noted_stop_signal() != 0 || (request_.time_limit_s > 0 && left_s() <= 0); }
  bool make(std::size_t number, BankResult& result);
  void note_fault(std::size_t number, bool is_users, const char* words, BankResult& result);
  double left_s() const { return request_.time_limit_s - watch_.seconds(); }
  bool note_done(std::size_t number);

  const Bank& bank_;
  const BankRequest& request_;
  const Communicator& ranks_;
  const SayMember& say_;
  const Warn& warn_;
  const Stopwatch watch_;
  std::unique_ptr<BankIndex> index_;  // on the rank that decides
  std::size_t first_ = 0;             // all members before it are done or failed
  std::set<std::size_t> held_;        // by others when they were tried
  std::set<std::size_t> failed_;      // not tried again
  int failures_in_a_row_ = 0;         // of the surroundings
  std::int64_t done_by_all_ = -1;
  std::chrono::steady_clock::time_point waits_since_;
};

// A member that is neither done nor, unless `held_too`, held; none: -1. What the index does not know of, but is there
// and finished, is put into it: a worker was killed between the two.
std::int64_t Group::next_of(bool held_too) {
  index_->refresh();
  const auto is_over = [&](std::size_t number) { return index_->is_done(number) || failed_.contains(number); };
  while (first_ < bank_.members.size() && is_over(first_)) ++first_;
  for (std::size_t number = first_; number < bank_.members.size(); ++number) {
    if (is_over(number) || held_.contains(number)) continue;
    if (!held_too && seems_held(member_path(request_.folder, bank_.members[number].name))) continue;
    return static_cast<std::int64_t>(number);
  }
  return -1;
}

bool Group::has_more() {
  index_->refresh();
  const auto given_up =
      std::count_if(failed_.begin(), failed_.end(), [&](std::size_t i) { return !index_->is_done(i); });
  return index_->num_done() + given_up < static_cast<std::int64_t>(bank_.members.size());
}

// What others hold is theirs to make; where they die, it is anybody's. False where none of them has made one for long.
bool Group::others_may_end() {
  constexpr std::chrono::seconds patience{10};
  constexpr std::chrono::milliseconds pause{300};
  const auto now = std::chrono::steady_clock::now();
  if (const std::int64_t done = index_->num_done(); done != done_by_all_) {
    done_by_all_ = done;
    waits_since_ = now;
  }
  if (now - waits_since_ > patience) return false;
  std::this_thread::sleep_for(pause);
  note_step();
  return true;
}

// -1 where there is none, the rest is held by others, or it is time to stop.
std::int64_t Group::next() {
  while (!is_to_stop()) {
    std::int64_t number = next_of(false);
    if (number < 0) number = next_of(true);
    if (number >= 0 || held_.empty()) return number;
    held_.clear();
    if (!has_more() || !others_may_end()) return -1;
  }
  return -1;
}

// False where another worker came upon it, finished and not yet in the index, and was quicker.
bool Group::note_done(std::size_t number) {
  const BankMember& member = bank_.members[number];
  const IndexRow row = row_of(member, request_.folder);
  if (!index_->add(number, row)) return false;
  say_({{"member", member.name},
        {"relative_error", std::isfinite(row.relative_error) ? fmt::format("{:.5f}", row.relative_error) : ""},
        {"seconds", fmt::format("{:.2f}", row.seconds)},
        {"done", fmt::format("{}", index_->num_done())},
        {"of", fmt::format("{}", bank_.members.size())}});
  return true;
}

void Group::note_fault(std::size_t number, bool is_users, const char* words, BankResult& result) {
  constexpr int most_in_a_row = 3;
  failed_.insert(number);
  failures_in_a_row_ = is_users ? 0 : failures_in_a_row_ + 1;
  result.gave_up = failures_in_a_row_ == most_in_a_row;
  result.faults.push_back({is_users, fmt::format("{}: {}", bank_.members[number].name, words)});
  if (ranks_.is_root()) {
    warn_(fmt::format("{}; {}", result.faults.back().words,
                      result.gave_up ? "no more members are tried, as three in a row failed" : "the others go on"));
  }
}

// False where it was stopped before it was done.
bool Group::make(std::size_t number, BankResult& result) {
  const BankMember& member = bank_.members[number];
  Progress progress(ranks_.is_root() ? ProgressKind::quiet : ProgressKind::silent);
  GenerateRequest wanted{.config = bank_.base,
                         .overrides = member.overrides,
                         .output = member_path(request_.folder, member.name),
                         .resume = true,
                         .threads = request_.threads,
                         .skip_if_held = true,
                         .loop = {.checkpoint_every_s = request_.checkpoint_every_s},
                         .watch = {.is_on = false}};  // the whole bank has one
  if (request_.time_limit_s > 0) wanted.loop.time_limit_s = std::max(1e-3, ranks_.broadcast(left_s()));
  const GenerateResult made = generate(wanted, ranks_, progress);
  if (made.held) {
    held_.insert(number);
    return true;
  }
  ranks_.on_root([&] {
    if (made.finished && note_done(number)) ++result.made;
  });
  if (made.finished) failures_in_a_row_ = 0;
  return made.finished;
}

BankResult Group::work() {
  BankResult result;
  ranks_.on_root([&] { index_ = std::make_unique<BankIndex>(read_index(bank_, request_.folder)); });
  while (!result.gave_up) {
    std::int64_t next_number = -1;
    const bool stops = ranks_.any_bits(noted_stop_signal() != 0 ? 1U : 0U) != 0;
    ranks_.on_root([&] {
      if (!stops) next_number = next();
      if (next_number < 0) result.stopped = (stops || is_to_stop()) && has_more();
    });
    next_number = static_cast<std::int64_t>(ranks_.broadcast(static_cast<double>(next_number)));
    if (next_number < 0) return result;
    const auto number = static_cast<std::size_t>(next_number);
    // Only what all ranks of the group throw alike: after anything else they would wait for each other for ever.
    try {
      if (make(number, result)) continue;
      result.stopped = true;
      return result;
    } catch (const SharedUserError& error) {
      note_fault(number, true, error.what(), result);
    } catch (const SharedEnvironmentError& error) {
      note_fault(number, false, error.what(), result);
    } catch (const OutputLost& error) {
      note_fault(number, false, error.what(), result);
    }
  }
  return result;
}

// The faults of all groups, each once, on every rank. *Collective*
std::vector<BankFault> gather_faults(const Communicator& communicator, const std::vector<BankFault>& own) {
  std::string text;
  for (const BankFault& fault : own) text += fmt::format("{}{}{}", fault.is_users ? 'u' : 'e', fault.words, '\0');
  const std::vector<std::byte> bytes = communicator.gather_all(std::as_bytes(std::span<const char>(text)));
  std::vector<BankFault> all;
  std::set<std::string> known;
  std::string one;
  for (const std::byte byte : bytes) {
    if (const char c = static_cast<char>(byte); c != '\0') {
      one += c;
      continue;
    }
    if (known.insert(one).second) all.push_back({one.front() == 'u', one.substr(1)});
    one.clear();
  }
  return all;
}

}  // namespace

BankResult work_on_bank(const Bank& bank, const BankRequest& request, const Communicator& communicator,
                        const SayMember& say, const Warn& warn) {
  const Watchdog watchdog(communicator, request.watch, warn,
                          [](const std::string& words) { print_error(fmt::format("noiseloom bank: {}\n", words)); });
  const Communicator group = communicator.group_of(std::min(request.ranks_per_member, communicator.size()));
  BankResult result;
  std::exception_ptr failure;  // of the folder or its index
  const auto note = [&](const std::exception& error) {
    failure = std::current_exception();
    if (group.is_root() && group.size() < communicator.size()) {
      warn(fmt::format("{}; the other ranks go on while they can", error.what()));
    }
  };
  try {
    result = Group(bank, request, group, say, warn).work();
  } catch (const SharedUserError& error) {
    note(error);
  } catch (const SharedEnvironmentError& error) {
    note(error);
  }
  communicator.agree(failure);
  result.faults = gather_faults(communicator, group.is_root() ? result.faults : std::vector<BankFault>{});
  std::int64_t made = group.is_root() ? result.made : 0;
  communicator.sum(std::span(&made, 1));
  result.made = made;
  result.stopped = communicator.any_bits(result.stopped ? 1U : 0U) != 0;
  return result;
}

}  // namespace noiseloom
