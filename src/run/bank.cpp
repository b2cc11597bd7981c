#include "noiseloom/run/bank.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <exception>
#include <filesystem>
#include <set>
#include <thread>

#include "noiseloom/core/console.h"
#include "noiseloom/core/error.h"
#include "noiseloom/core/stopwatch.h"
#include "noiseloom/dist/activity.h"
#include "noiseloom/files/run_lock.h"
#include "noiseloom/run/generate.h"
#include "noiseloom/run/stop_signals.h"
#include "run/bank_index.h"

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
  std::string next();
  std::string next_of(bool held_too);
  bool others_may_end();
  bool has_more() const;
  bool is_to_stop() const { return noted_stop_signal() != 0 || (request_.time_limit_s > 0 && left_s() <= 0); }
  bool make(const BankMember& member, BankResult& result);
  void note_fault(const std::string& name, bool is_users, const char* words, BankResult& result);
  double left_s() const { return request_.time_limit_s - watch_.seconds(); }
  bool note_done(const BankMember& member);

  const Bank& bank_;
  const BankRequest& request_;
  const Communicator& ranks_;
  const SayMember& say_;
  const Warn& warn_;
  const Stopwatch watch_;
  std::set<std::string> held_;    // by others when they were tried
  std::set<std::string> failed_;  // not tried again
  int failures_in_a_row_ = 0;     // of the surroundings
  std::int64_t done_by_all_ = -1;
  std::chrono::steady_clock::time_point waits_since_;
};

// A member that is neither done nor, unless `held_too`, held. What the index does not know of, but is there and
// finished, is put into it: a worker was killed between the two.
std::string Group::next_of(bool held_too) {
  const BankIndex index = read_index(bank_, request_.folder);
  for (const BankMember& member : bank_.members) {
    if (is_done(index, member) || held_.contains(member.name) || failed_.contains(member.name)) continue;
    if (!held_too && seems_held(member_path(request_.folder, member.name))) continue;
    return member.name;
  }
  return "";
}

bool Group::has_more() const {
  const BankIndex index = read_index(bank_, request_.folder);
  return std::any_of(bank_.members.begin(), bank_.members.end(), [&](const BankMember& member) {
    return !is_done(index, member) && !failed_.contains(member.name);
  });
}

// What others hold is theirs to make; where they die, it is anybody's. False where none of them has made one for long.
bool Group::others_may_end() {
  constexpr std::chrono::seconds patience{10};
  constexpr std::chrono::milliseconds pause{300};
  const auto now = std::chrono::steady_clock::now();
  if (const auto done = count_done(bank_, request_.folder).first; done != done_by_all_) {
    done_by_all_ = done;
    waits_since_ = now;
  }
  if (now - waits_since_ > patience) return false;
  std::this_thread::sleep_for(pause);
  note_step();
  return true;
}

// "" where there is none, the rest is held by others, or it is time to stop.
std::string Group::next() {
  while (!is_to_stop()) {
    std::string name = next_of(false);
    if (name.empty()) name = next_of(true);
    if (!name.empty() || held_.empty()) return name;
    held_.clear();
    if (!has_more() || !others_may_end()) return "";
  }
  return "";
}

// False where another worker came upon it, finished and not yet in the index, and was quicker.
bool Group::note_done(const BankMember& member) {
  const IndexRow row = row_of(member, request_.folder);
  if (!update_index(bank_, request_.folder, member.name, row)) return false;
  const auto [done, all] = count_done(bank_, request_.folder);
  say_({{"member", member.name},
        {"relative_error", std::isfinite(row.relative_error) ? fmt::format("{:.5f}", row.relative_error) : ""},
        {"seconds", fmt::format("{:.2f}", row.seconds)},
        {"done", fmt::format("{}", done)},
        {"of", fmt::format("{}", all)}});
  return true;
}

void Group::note_fault(const std::string& name, bool is_users, const char* words, BankResult& result) {
  constexpr int most_in_a_row = 3;
  failed_.insert(name);
  failures_in_a_row_ = is_users ? 0 : failures_in_a_row_ + 1;
  result.gave_up = failures_in_a_row_ == most_in_a_row;
  result.faults.push_back({is_users, fmt::format("{}: {}", name, words)});
  if (ranks_.is_root()) {
    warn_(fmt::format("{}; {}", result.faults.back().words,
                      result.gave_up ? "no more members are tried, as three in a row failed" : "the others go on"));
  }
}

// False where it was stopped before it was done.
bool Group::make(const BankMember& member, BankResult& result) {
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
    held_.insert(member.name);
    return true;
  }
  ranks_.on_root([&] {
    if (!made.finished) {
      update_index(bank_, request_.folder, "", {});
    } else if (note_done(member)) {
      ++result.made;
    }
  });
  if (made.finished) failures_in_a_row_ = 0;
  return made.finished;
}

BankResult Group::work() {
  BankResult result;
  while (!result.gave_up) {
    std::string name;
    const bool stops = ranks_.any_bits(noted_stop_signal() != 0 ? 1U : 0U) != 0;
    ranks_.on_root([&] {
      if (!stops) name = next();
      if (name.empty()) result.stopped = (stops || is_to_stop()) && has_more();
    });
    ranks_.broadcast(name);
    if (name.empty()) return result;
    const auto member = std::find_if(bank_.members.begin(), bank_.members.end(),
                                     [&](const BankMember& one) { return one.name == name; });
    // Only what all ranks of the group throw alike: after anything else they would wait for each other for ever.
    try {
      if (make(*member, result)) continue;
      result.stopped = true;
      return result;
    } catch (const SharedUserError& error) {
      note_fault(name, true, error.what(), result);
    } catch (const SharedEnvironmentError& error) {
      note_fault(name, false, error.what(), result);
    } catch (const OutputLost& error) {
      note_fault(name, false, error.what(), result);
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

std::pair<std::int64_t, std::int64_t> count_done(const Bank& bank, const std::string& folder) {
  const BankIndex index = read_index(bank, folder);
  const auto done = std::count_if(bank.members.begin(), bank.members.end(),
                                  [&](const BankMember& member) { return is_done(index, member); });
  return {done, static_cast<std::int64_t>(bank.members.size())};
}

}  // namespace noiseloom
