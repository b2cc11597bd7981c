#include "noiseloom/dist/watchdog.h"

#include <fmt/format.h>
#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstring>
#include <exception>
#include <random>
#include <span>
#include <thread>
#include <utility>
#include <vector>

#include "dist/beat_channel.h"
#include "noiseloom/core/error.h"
#include "noiseloom/core/quantity_text.h"
#include "noiseloom/dist/activity.h"

namespace noiseloom {
namespace {

using std::chrono::steady_clock;

constexpr double usual_tick_s = 0.5;
constexpr double usual_stuck_s = 1800;
constexpr double steps_until_stuck = 100;
// A rank gives rank 0, which knows more, time to speak first.
constexpr double patience_with_root = 1.25;
constexpr int connect_patience_ms = 2000;

void copy_text(std::array<char, 64>& to, const std::string& text) {
  to.fill('\0');
  std::copy_n(text.begin(), std::min(text.size(), to.size() - 1), to.begin());
}

std::string text_of(const std::array<char, 64>& from) { return std::string(from.data(), ::strnlen(from.data(), 63)); }

// What rank 0 knows of another rank.
struct Peer {
  Socket socket;
  BeatReader reader;
  Beat last;
  double silent_s = 0;
  double in_activity_s = 0;  // how long it says the same
  bool is_watched = false;
  bool has_left = false;
};

std::string named(const Beat& beat) {
  return fmt::format("rank {} on {} (process {})", beat.rank, text_of(beat.host), beat.pid);
}

std::string activity_of(const Beat& beat) {
  return beat.other >= 0 ? fmt::format("{} rank {}", text_of(beat.words), beat.other) : text_of(beat.words);
}

// The seconds of the clock, less those in which this process did not run.
class AwakeClock {
 public:
  explicit AwakeClock(double tick_s) : tick_s_(tick_s), before_(steady_clock::now()) {}
  // Since the last call.
  double elapsed_s() {
    const auto now = steady_clock::now();
    const double elapsed = std::chrono::duration<double>(now - std::exchange(before_, now)).count();
    return std::min(elapsed, 2 * tick_s_);
  }

 private:
  double tick_s_;
  steady_clock::time_point before_;
};

// Waits for something to be read, for a part of a tick at most.
void wait_for_any(std::span<pollfd> entries, double seconds) {
  ::poll(entries.data(), entries.size(), static_cast<int>(1000 * seconds));
}

}  // namespace

struct Watchdog::Impl {
  Impl(const Communicator& ranks, const WatchSettings& watch_settings,
       const std::function<void(const std::string&)>& printer)
      : settings(watch_settings),
        print(printer),
        rank(ranks.rank()),
        size(ranks.size()),
        tick_s(std::min(usual_tick_s, settings.silence_s / 8)) {}

  void connect(const Communicator& communicator, const std::function<void(const std::string&)>& warn);
  void start(void (Impl::*body)());
  void watch_ranks();
  void hear_newcomers();
  void hear(Peer& peer, double elapsed_s);
  void judge(double elapsed_s);
  double stuck_limit_s() const;
  void watch_root();
  Beat own_beat(bool is_last = false) const;
  [[noreturn]] void end(const std::string& why) const;
  [[noreturn]] void end_stuck() const;

  const WatchSettings settings;
  const std::function<void(const std::string&)> print;
  const Rank rank;
  const int size;
  const double tick_s;
  std::uint64_t token = 0;

  // Rank 0.
  std::unique_ptr<BeatListener> listener;
  std::vector<std::pair<Socket, BeatReader>> newcomers;  // that have not said who they are
  IndexedVector<Rank, Peer> peers;
  std::uint64_t steps = 0;  // of all ranks
  double without_step_s = 0;
  double longest_step_s = 0;

  // The others.
  Socket to_root;
  Beat root_beat;  // the last of rank 0

  std::atomic<bool> ending = false;
  std::thread thread;
};

Beat Watchdog::Impl::own_beat(bool is_last) const {
  const Activity::Now now = Activity::now();
  Beat beat;
  beat.token = token;
  beat.steps = num_steps_noted();
  beat.rank = rank.value();
  beat.other = now.other.value();
  beat.kind = static_cast<std::uint32_t>(now.kind);
  beat.is_last = is_last ? 1 : 0;
  beat.pid = ::getpid();
  copy_text(beat.words, now.words);
  std::array<char, 64> host{};
  ::gethostname(host.data(), host.size() - 1);
  beat.host = host;
  return beat;
}

void Watchdog::Impl::connect(const Communicator& communicator, const std::function<void(const std::string&)>& warn) {
  std::string address;
  std::string trouble;
  if (rank == Communicator::root) {
    try {
      std::random_device draw;
      token = std::uint64_t{draw()} << 32 | draw() | 1U;
      listener = std::make_unique<BeatListener>();
      peers = IndexedVector<Rank, Peer>(static_cast<std::size_t>(size));
      address = listener->address();
      start(&Impl::watch_ranks);
    } catch (const std::exception& error) {
      trouble = error.what();
      address.clear();
    }
  }
  communicator.broadcast(address);
  std::string token_text = std::to_string(token);
  communicator.broadcast(token_text);
  if (rank != Communicator::root && !address.empty()) {
    token = std::stoull(token_text);
    to_root = connect_beats(address, own_beat(), connect_patience_ms, root_beat);
    try {
      if (to_root.is_open()) start(&Impl::watch_root);
    } catch (const std::exception&) {  // no thread: not watched
      to_root = Socket();
    }
  }
  const std::uint64_t is_watched = rank == Communicator::root ? !address.empty() : to_root.is_open();
  const auto all = communicator.gather_all(std::span(&is_watched, 1));
  std::string unwatched;
  for (std::size_t r = 0; r < all.size(); ++r) {
    if (all[r] == 0) unwatched += (unwatched.empty() ? "" : ", ") + std::to_string(r);
  }
  if (!unwatched.empty() && rank == Communicator::root) {
    warn(fmt::format("not noticed if they stop: ranks {} ({}); --watchdog off is silent about it", unwatched,
                     trouble.empty() ? "no connection to rank 0 beside MPI's" : trouble));
  }
}

void Watchdog::Impl::start(void (Impl::*body)()) {
  // Signals are for the threads that compute.
  sigset_t all;
  sigset_t before;
  sigfillset(&all);
  ::pthread_sigmask(SIG_SETMASK, &all, &before);
  try {
    thread = std::thread([this, body] { (this->*body)(); });
  } catch (...) {
    ::pthread_sigmask(SIG_SETMASK, &before, nullptr);
    throw;
  }
  ::pthread_sigmask(SIG_SETMASK, &before, nullptr);
}

void Watchdog::Impl::end(const std::string& why) const {
  print(why + "; ended, so that it can be started again: what was saved last is whole, go on with --resume");
  ::_exit(exit_lost_rank);
}

// --- rank 0 ---

void Watchdog::Impl::watch_ranks() {
  AwakeClock clock(tick_s);
  double until_beat_s = 0;
  std::vector<pollfd> entries;
  while (!ending) {
    entries.assign(1, {listener->fd(), POLLIN, 0});
    for (const auto& [socket, reader] : newcomers) entries.push_back({socket.fd(), POLLIN, 0});
    wait_for_any(entries, tick_s / 4);
    const double elapsed_s = clock.elapsed_s();
    hear_newcomers();
    for (Peer& peer : peers) hear(peer, elapsed_s);
    judge(elapsed_s);
    until_beat_s -= elapsed_s;
    if (until_beat_s > 0) continue;
    until_beat_s = tick_s;
    for (Peer& peer : peers) {
      if (peer.socket.is_open() && !send_beat(peer.socket, own_beat())) peer.socket = Socket();
    }
  }
  for (const Peer& peer : peers) {
    if (peer.socket.is_open()) send_beat(peer.socket, own_beat(true));
  }
}

void Watchdog::Impl::hear_newcomers() {
  for (Socket one = listener->accept_one(); one.is_open(); one = listener->accept_one()) {
    newcomers.emplace_back(std::move(one), BeatReader());
  }
  for (auto& [socket, reader] : newcomers) {
    bool is_gone = false;
    const std::optional<Beat> beat = reader.read(socket, is_gone);
    if (!beat) {
      if (is_gone) socket = Socket();
      continue;
    }
    if (beat->token == token && beat->rank > 0 && beat->rank < size && !is_gone) {
      Peer& peer = peers[Rank(beat->rank)];
      send_beat(socket, own_beat());
      peer.socket = std::move(socket);
      peer.reader = reader;
      peer.last = *beat;
      peer.is_watched = true;
    }
    socket = Socket();  // a stranger's, or moved away
  }
  std::erase_if(newcomers, [](const auto& one) { return !one.first.is_open(); });
}

void Watchdog::Impl::hear(Peer& peer, double elapsed_s) {
  if (!peer.is_watched || peer.has_left) return;
  peer.silent_s += elapsed_s;
  peer.in_activity_s += elapsed_s;
  if (!peer.socket.is_open()) return;
  bool is_gone = false;
  const std::optional<Beat> beat = peer.reader.read(peer.socket, is_gone);
  if (beat) {
    peer.silent_s = 0;
    if (beat->words != peer.last.words || beat->other != peer.last.other || beat->steps != peer.last.steps) {
      peer.in_activity_s = 0;
    }
    peer.has_left = beat->is_last != 0;
    peer.last = *beat;
  }
  if (is_gone) peer.socket = Socket();
}

double Watchdog::Impl::stuck_limit_s() const {
  return settings.stuck_s > 0 ? settings.stuck_s : std::max(usual_stuck_s, steps_until_stuck * longest_step_s);
}

void Watchdog::Impl::judge(double elapsed_s) {
  std::uint64_t total = num_steps_noted();
  bool is_writing = Activity::now().kind == Activity::Kind::writing;
  for (const Peer& peer : peers) {
    if (!peer.is_watched || peer.has_left) continue;
    total += peer.last.steps;
    is_writing = is_writing || peer.last.kind == static_cast<std::uint32_t>(Activity::Kind::writing);
    if (peer.silent_s <= settings.silence_s) continue;
    end(fmt::format("{} has not been heard of for {}; its last word was that it {}; rank 0 {}", named(peer.last),
                    duration_text(peer.silent_s), activity_of(peer.last), activity_of(own_beat())));
  }
  if (total != steps) {
    if (steps > 0) longest_step_s = std::max(longest_step_s, without_step_s);
    steps = total;
    without_step_s = 0;
  } else if (steps > 0 && !is_writing) {
    without_step_s += elapsed_s;
  }
  if (without_step_s > stuck_limit_s()) end_stuck();
}

// All live, and nothing moves: the rank that waits for nobody is what the others wait for.
void Watchdog::Impl::end_stuck() const {
  std::vector<Beat> all = {own_beat()};
  for (const Peer& peer : peers) {
    if (peer.is_watched && !peer.has_left) all.push_back(peer.last);
  }
  const auto is_waiting = [](const Beat& beat) {
    return beat.kind == static_cast<std::uint32_t>(Activity::Kind::waiting);
  };
  const auto busy = std::find_if_not(all.begin(), all.end(), is_waiting);
  const std::string what = busy == all.end()
                               ? "all ranks wait, " + named(all.front()) + " in " + activity_of(all.front())
                               : fmt::format("{} {}", named(*busy), activity_of(*busy));
  end(fmt::format("no rank has made a step for {}: {}", duration_text(without_step_s), what));
}

// --- the other ranks ---

void Watchdog::Impl::watch_root() {
  AwakeClock clock(tick_s);
  BeatReader reader;
  double silent_s = 0;
  double until_beat_s = 0;
  bool is_gone = false;
  while (!ending && root_beat.is_last == 0) {
    pollfd entry{to_root.fd(), POLLIN, 0};
    if (is_gone) {
      std::this_thread::sleep_for(std::chrono::duration<double>(tick_s / 4));
    } else {
      wait_for_any(std::span(&entry, 1), tick_s / 4);
    }
    const double elapsed_s = clock.elapsed_s();
    silent_s += elapsed_s;
    if (!is_gone) {
      if (const std::optional<Beat> beat = reader.read(to_root, is_gone)) {
        root_beat = *beat;
        silent_s = 0;
      }
    }
    if (silent_s > patience_with_root * settings.silence_s) {
      // One voice is enough, where it reaches somebody.
      std::this_thread::sleep_for(std::chrono::duration<double>(rank == Rank(1) ? 0 : 8 * tick_s));
      end(fmt::format("{} has not been heard of for {}; its last word was that it {}; rank {} {}", named(root_beat),
                      duration_text(silent_s), activity_of(root_beat), rank.value(), activity_of(own_beat())));
    }
    until_beat_s -= elapsed_s;
    if (until_beat_s > 0 || is_gone) continue;
    until_beat_s = tick_s;
    send_beat(to_root, own_beat());
  }
  send_beat(to_root, own_beat(true));
}

Watchdog::Watchdog(const Communicator& communicator, const WatchSettings& settings,
                   const std::function<void(const std::string&)>& warn,
                   const std::function<void(const std::string&)>& print) {
  if (!settings.is_on || communicator.size() == 1) return;
  impl_ = std::make_unique<Impl>(communicator, settings, print);
  impl_->connect(communicator, warn);
}

Watchdog::~Watchdog() {
  if (!impl_) return;
  impl_->ending = true;
  if (impl_->thread.joinable()) impl_->thread.join();
}

}  // namespace noiseloom
