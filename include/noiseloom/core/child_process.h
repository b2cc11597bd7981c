// Running another program, with a limit of time and signals that ask to stop.
#pragma once

#include <signal.h>

#include <string>
#include <vector>

namespace noiseloom {

// While it lives, SIGINT, SIGTERM, SIGUSR1 and SIGUSR2 do not end the process but wait to be asked for. To be made in
// the main thread before any other thread.
class StopSignals {
 public:
  StopSignals();
  ~StopSignals();
  StopSignals(const StopSignals&) = delete;
  StopSignals& operator=(const StopSignals&) = delete;

  // Whether one has come; it stays so.
  bool come();
  // Waits until a child ends (true), a stop signal comes or `seconds` have passed (false).
  bool wait_for_child(double seconds);
  const sigset_t& mask_before() const { return before_; }

 private:
  sigset_t stop_;
  sigset_t stop_and_child_;
  sigset_t before_;
  bool come_ = false;
};

struct ChildResult {
  enum class End { exited, stopped, overran } end = End::exited;
  int status = 0;      // exited: the exit status; 128 + the signal's number where one killed it
  double seconds = 0;  // from before the start to the end of the process
};

// Runs words[0] (looked up in PATH where it has no slash) to its end. When a stop signal comes, or after `limit_s`, the
// child is sent SIGTERM and, five seconds later, SIGKILL. Should this process die, the child is killed. The child's
// standard output is thrown away. Throws EnvironmentError when it cannot be started.
ChildResult run_child(const std::vector<std::string>& words, double limit_s, StopSignals& signals);

}  // namespace noiseloom
