#include "noiseloom/run/bank.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <exception>
#include <filesystem>
#include <set>

#include "noiseloom/core/console.h"
#include "noiseloom/core/error.h"
#include "noiseloom/core/stopwatch.h"
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
  Group(const Bank& bank, const BankRequest& request, const Communicator& ranks, const SayMember& say)
      : bank_(bank), request_(request), ranks_(ranks), say_(say) {}

  BankResult work();

 private:
  std::string next();
  std::string next_of(bool held_too);
  bool has_time() const { return request_.time_limit_s <= 0 || left_s() > 0; }
  double left_s() const { return request_.time_limit_s - watch_.seconds(); }
  bool note_done(const BankMember& member);

  const Bank& bank_;
  const BankRequest& request_;
  const Communicator& ranks_;
  const SayMember& say_;
  const Stopwatch watch_;
  std::set<std::string> refused_;  // held by others when they were tried
};

// A member that is neither done nor, unless `held_too`, held. What the index does not know of, but is there and
// finished, is put into it: a worker was killed between the two.
std::string Group::next_of(bool held_too) {
  const BankIndex index = read_index(bank_, request_.folder);
  for (const BankMember& member : bank_.members) {
    if (is_done(index, member) || refused_.contains(member.name)) continue;
    if (!held_too && seems_held(member_path(request_.folder, member.name))) continue;
    return member.name;
  }
  return "";
}

std::string Group::next() {
  const std::string free = next_of(false);
  return free.empty() ? next_of(true) : free;
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

BankResult Group::work() {
  BankResult result;
  for (;;) {
    std::string name;
    const bool stops = ranks_.any_bits(noted_stop_signal() != 0 ? 1U : 0U) != 0;
    ranks_.on_root([&] {
      if (!stops && has_time()) name = next();
      if (name.empty() && !next_of(true).empty()) name = "/";  // there is more to do
    });
    ranks_.broadcast(name);
    if (name.empty() || name == "/") {
      result.stopped = name == "/";
      return result;
    }
    const auto member = std::find_if(bank_.members.begin(), bank_.members.end(),
                                     [&](const BankMember& one) { return one.name == name; });
    Progress progress(ranks_.is_root() ? ProgressKind::quiet : ProgressKind::silent);
    GenerateRequest wanted{.config = bank_.base,
                           .overrides = member->overrides,
                           .output = member_path(request_.folder, name),
                           .resume = true,
                           .threads = request_.threads,
                           .skip_if_held = true,
                           .loop = {.checkpoint_every_s = request_.checkpoint_every_s},
                           .watch = {.is_on = false}};  // the whole bank has one
    if (request_.time_limit_s > 0) wanted.loop.time_limit_s = std::max(1e-3, ranks_.broadcast(left_s()));
    const GenerateResult made = generate(wanted, ranks_, progress);
    if (made.held) {
      refused_.insert(name);
    } else if (made.finished) {
      ranks_.on_root([&] {
        if (note_done(*member)) ++result.made;
      });
    } else {
      ranks_.on_root([&] { update_index(bank_, request_.folder, "", {}); });
      result.stopped = true;
      return result;
    }
  }
}

}  // namespace

BankResult work_on_bank(const Bank& bank, const BankRequest& request, const Communicator& communicator,
                        const SayMember& say, const std::function<void(const std::string&)>& warn) {
  const Watchdog watchdog(communicator, request.watch, warn,
                          [](const std::string& words) { print_error(fmt::format("noiseloom bank: {}\n", words)); });
  const Communicator group = communicator.group_of(std::min(request.ranks_per_member, communicator.size()));
  BankResult result;
  std::exception_ptr failure;
  try {
    result = Group(bank, request, group, say).work();
  } catch (...) {
    failure = std::current_exception();
    if (group.is_root() && group.size() < communicator.size())
      warn("a member failed; the other ranks end what they have begun");
  }
  communicator.agree(failure);
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
