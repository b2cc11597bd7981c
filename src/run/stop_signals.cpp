#include "noiseloom/run/stop_signals.h"

#include <signal.h>

#include <array>
#include <utility>

namespace noiseloom {
namespace {

constexpr std::array<std::pair<int, const char*>, 7> stop_signals = {{{SIGTERM, "SIGTERM"},
                                                                      {SIGINT, "SIGINT"},
                                                                      {SIGUSR1, "SIGUSR1"},
                                                                      {SIGUSR2, "SIGUSR2"},
                                                                      {SIGHUP, "SIGHUP"},
                                                                      {SIGXCPU, "SIGXCPU"},
                                                                      {SIGPIPE, "SIGPIPE"}}};

volatile sig_atomic_t noted = 0;
extern "C" void note_signal(int number) { noted = number; }

bool is_ignored(int number) {
  struct sigaction present {};
  return sigaction(number, nullptr, &present) == 0 && present.sa_handler == SIG_IGN;
}

}  // namespace

void note_stop_signals() {
  struct sigaction action {};
  action.sa_handler = note_signal;
  action.sa_flags = SA_RESTART;  // no write, fsync or MPI call is to fail with EINTR because of a note
  for (const auto& [number, name] : stop_signals) {
    if ((number == SIGHUP || number == SIGINT) && is_ignored(number)) continue;
    sigaction(number, &action, nullptr);
  }
  signal(SIGXFSZ, SIG_IGN);
}

int noted_stop_signal() { return noted; }

void forget_stop_signal() { noted = 0; }

std::string signal_name(int number) {
  for (const auto& [known, name] : stop_signals) {
    if (known == number) return name;
  }
  return "signal " + std::to_string(number);
}

}  // namespace noiseloom
