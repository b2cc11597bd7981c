#include "noiseloom/core/child_process.h"

#include <fcntl.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <optional>
#include <system_error>

#include "noiseloom/core/error.h"
#include "noiseloom/core/stopwatch.h"

namespace noiseloom {
namespace {

constexpr double grace_s = 5;  // between SIGTERM and SIGKILL
constexpr int cannot_start = 127;
constexpr int stopped_early = 75;

// In the child, between fork and exec: system calls alone.
[[noreturn]] void become(char* const* words, const sigset_t& mask, pid_t parent) {
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (::getppid() != parent) ::_exit(cannot_start);  // it died before that was set
  const int nowhere = ::open("/dev/null", O_WRONLY);
  if (nowhere >= 0) ::dup2(nowhere, STDOUT_FILENO);
  ::sigprocmask(SIG_SETMASK, &mask, nullptr);
  ::execvp(words[0], words);
  ::_exit(cannot_start);
}

std::optional<int> ended_status(pid_t pid) {
  int status = 0;
  const pid_t ended = ::waitpid(pid, &status, WNOHANG);
  if (ended == 0 || (ended < 0 && errno == EINTR)) return std::nullopt;
  if (ended < 0) throw EnvironmentError("a run was lost: " + std::system_category().message(errno));
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

void end_child(pid_t pid, StopSignals& signals) {
  ::kill(pid, SIGTERM);
  const Stopwatch watch;
  for (double left = grace_s; left > 0; left = grace_s - watch.seconds()) {
    signals.wait_for_child(std::min(left, 0.2));
    if (ended_status(pid)) return;
  }
  ::kill(pid, SIGKILL);
  while (::waitpid(pid, nullptr, 0) < 0 && errno == EINTR) {
  }
}

}  // namespace

StopSignals::StopSignals() {
  ::sigemptyset(&stop_);
  for (const int number : {SIGINT, SIGTERM, SIGUSR1, SIGUSR2}) ::sigaddset(&stop_, number);
  stop_and_child_ = stop_;
  ::sigaddset(&stop_and_child_, SIGCHLD);
  ::pthread_sigmask(SIG_BLOCK, &stop_and_child_, &before_);
}

StopSignals::~StopSignals() { ::pthread_sigmask(SIG_SETMASK, &before_, nullptr); }

bool StopSignals::come() {
  const timespec at_once{};
  if (::sigtimedwait(&stop_, nullptr, &at_once) > 0) come_ = true;
  return come_;
}

bool StopSignals::wait_for_child(double seconds) {
  constexpr double longest = 1e6;
  const double wait = std::clamp(seconds, 0.0, longest);
  const timespec time{static_cast<time_t>(wait), static_cast<long>(1e9 * (wait - std::floor(wait)))};
  const int number = ::sigtimedwait(&stop_and_child_, nullptr, &time);
  if (number > 0 && number != SIGCHLD) come_ = true;
  return number == SIGCHLD;
}

ChildResult run_child(const std::vector<std::string>& words, double limit_s, StopSignals& signals) {
  std::vector<char*> arguments;
  for (const std::string& word : words) arguments.push_back(const_cast<char*>(word.c_str()));
  arguments.push_back(nullptr);
  const pid_t parent = ::getpid();
  const Stopwatch watch;
  const pid_t pid = ::fork();
  if (pid < 0) throw EnvironmentError(words[0] + ": cannot be started: " + std::system_category().message(errno));
  if (pid == 0) become(arguments.data(), signals.mask_before(), parent);
  for (;;) {
    if (const auto status = ended_status(pid)) {
      const double seconds = watch.seconds();
      if (*status == cannot_start) throw EnvironmentError(words[0] + ": cannot be started");
      // A signal from the terminal reaches the child too, which then saves and ends by itself.
      return {*status == stopped_early ? ChildResult::End::stopped : ChildResult::End::exited, *status, seconds};
    }
    const bool overran = watch.seconds() >= limit_s;
    if (overran || signals.come()) {
      end_child(pid, signals);
      return {signals.come() ? ChildResult::End::stopped : ChildResult::End::overran, 0, watch.seconds()};
    }
    signals.wait_for_child(limit_s - watch.seconds());
  }
}

}  // namespace noiseloom
