#include "noiseloom/run/stop_signals.h"

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

namespace noiseloom {
namespace {

// Runs `body` in a process of its own and returns how that ended: exit status, or minus the signal.
template <class Body>
int in_a_child(const Body& body) {
  const pid_t child = ::fork();
  if (child == 0) ::_exit(body());
  int status = 0;
  ::waitpid(child, &status, 0);
  return WIFSIGNALED(status) ? -WTERMSIG(status) : WEXITSTATUS(status);
}

TEST(StopSignals, AreNotedAndDoNotEndTheProcess) {
  for (const int number : {SIGTERM, SIGINT, SIGUSR1, SIGUSR2, SIGHUP, SIGXCPU, SIGPIPE}) {
    const auto body = [number] {
      note_stop_signals();
      if (noted_stop_signal() != 0) return 100;
      ::raise(number);
      return noted_stop_signal();
    };
    EXPECT_EQ(in_a_child(body), number) << signal_name(number);
  }
}

TEST(StopSignals, WhatTheParentIgnoresStaysIgnoredWhereThatIsTheCustom) {
  for (const int number : {SIGHUP, SIGINT}) {
    const auto body = [number] {
      ::signal(number, SIG_IGN);
      note_stop_signals();
      ::raise(number);
      return noted_stop_signal();
    };
    EXPECT_EQ(in_a_child(body), 0) << signal_name(number);
  }
  // A batch script that ignores its own warning still passes it on.
  const auto body = [] {
    ::signal(SIGUSR1, SIG_IGN);
    note_stop_signals();
    ::raise(SIGUSR1);
    return noted_stop_signal();
  };
  EXPECT_EQ(in_a_child(body), SIGUSR1);
}

TEST(StopSignals, TakeTheirPlaceBackFromALibrary) {
  const auto body = [] {
    note_stop_signals();
    ::signal(SIGTERM, SIG_DFL);
    note_stop_signals();
    ::raise(SIGTERM);
    return noted_stop_signal();
  };
  EXPECT_EQ(in_a_child(body), SIGTERM);
}

TEST(StopSignals, CanBeForgotten) {
  const auto body = [] {
    note_stop_signals();
    ::raise(SIGUSR2);
    forget_stop_signal();
    return noted_stop_signal();
  };
  EXPECT_EQ(in_a_child(body), 0);
}

TEST(StopSignals, HaveNames) {
  EXPECT_EQ(signal_name(SIGXCPU), "SIGXCPU");
  EXPECT_EQ(signal_name(SIGCHLD), "signal " + std::to_string(SIGCHLD));
}

}  // namespace
}  // namespace noiseloom
