// Who holds a lock: another process of this machine, or a machine that a file plays.
#pragma once

#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <string>

#include "files/lock_record.h"
#include "noiseloom/core/error.h"
#include "noiseloom/files/run_lock.h"

namespace noiseloom {

// A child process that runs `body` and says through a pipe when it got there; killed and collected at the end.
class Child {
 public:
  template <class Body>
  explicit Child(Body body) {
    int ends[2] = {};
    if (::pipe(ends) != 0) throw EnvironmentError("pipe");
    pid_ = ::fork();
    if (pid_ == 0) {
      body([&] { [[maybe_unused]] const ssize_t done = ::write(ends[1], "x", 1); });
      ::_exit(0);
    }
    ::close(ends[1]);
    from_child_ = ends[0];
  }
  ~Child() {
    kill_and_wait();
    ::close(from_child_);
  }
  Child(const Child&) = delete;
  Child& operator=(const Child&) = delete;

  bool wait_until_ready() const {
    char byte = 0;
    return ::read(from_child_, &byte, 1) == 1;
  }
  void kill_and_wait() {
    if (pid_ <= 0) return;
    ::kill(pid_, SIGKILL);
    ::waitpid(pid_, nullptr, 0);
    pid_ = -1;
  }
  pid_t pid() const { return pid_; }

 private:
  pid_t pid_ = -1;
  int from_child_ = -1;
};

// "locked", or what a second run is told.
inline std::string refusal(const std::string& path) {
  try {
    const RunLock lock(path);
    return "locked";
  } catch (const UserError& error) {
    return error.what();
  }
}

// Waits that a test can afford.
inline constexpr LockTiming quick{.beat = std::chrono::milliseconds(20), .silence = std::chrono::milliseconds(200)};

inline LockRecord record_of_another_machine() {
  LockRecord record = own_record();
  record.holder = "process 4711 on node7, since 2026-01-31 12:00:00 UTC";
  record.machine = "another";
  record.pid = 4711;
  record.slurm_job = "";
  return record;
}

}  // namespace noiseloom
