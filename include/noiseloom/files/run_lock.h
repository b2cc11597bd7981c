// Holds an output for one run, against other processes, other nodes, and runs that come back from the dead.
//
// PATH.lock is locked with flock, which the system frees when the process ends. That is enough on one machine. Between
// machines it is not: the server of a network file system may keep the lock of a node that died, and a file system may
// lock for one node alone. So the file also says who holds it (host, boot of the machine, process, Slurm's job and how
// often it was requeued, a number drawn for this holder), and its time of change is a heartbeat, renewed while the
// holder lives. A newcomer decides by what can be known:
//
//   holder on the same machine             the system's lock is right; without locks: whether the process lives
//   the same Slurm job, requeued since     the holder is our own predecessor, and dead; where it is dying on this
//                                          machine, it is given LockTiming::dying to end
//   holder on another machine              alive if its heartbeat goes on, else dead: watched until LockTiming::silence
//                                          is over, and always for longer than a beat, as a clock may have jumped
//
// A holder that was cut off or suspended and comes back finds another number in the file, and writes nothing more.
// Where it was stopped on its way from that look to the rename of its new file, it finds that file gone: whoever takes
// a lock over removes the temporary files of those before (remove_stale_temporaries).
#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <string>

#include "noiseloom/core/error.h"

namespace noiseloom {

// The output is no longer this run's to write: another run took it over or replaced what stood there. To try again is
// of no use.
class OutputLost : public EnvironmentError {
  using EnvironmentError::EnvironmentError;
};

// Somebody else holds the output, and lives.
class OutputHeld : public UserError {
  using UserError::UserError;
};

struct LockTiming {
  std::chrono::milliseconds beat{15'000};     // between heartbeats
  std::chrono::milliseconds silence{60'000};  // after which a holder on another machine counts as dead
  std::chrono::milliseconds dying{10'000};    // how long our own predecessor on this machine may take to end
};

class RunLock {
 public:
  // Throws OutputHeld saying who holds it (host, process, since when); UserError where the folder does not exist;
  // EnvironmentError, naming the folder, if it cannot be written. May wait for LockTiming::silence where a holder on
  // another machine may be dead; `say` is told so before.
  explicit RunLock(const std::string& path, const std::function<void(const std::string&)>& say = {},
                   LockTiming timing = {});
  ~RunLock();
  RunLock(const RunLock&) = delete;
  RunLock& operator=(const RunLock&) = delete;
  // False where the file system has no locks: two runs that start at the same moment are then not kept apart, which the
  // user should be told.
  bool enforced() const;
  // Drawn for this holder: tells the parts of a run, and runs, from each other.
  const std::string& number() const;

  struct Impl;

 private:
  std::unique_ptr<Impl> impl_;
};

// Tells somebody who only looks on whether anybody works on an output. Takes nothing from a run that begins meanwhile
// as long as the holder can be seen to live.
class LockWatch {
 public:
  explicit LockWatch(const std::string& path, LockTiming timing = {});
  ~LockWatch();
  // Never waits. A holder on another machine counts as alive until its heartbeat has not been seen for
  // LockTiming::silence, from the first call on.
  bool is_held();
  // Removes a lock file that nobody holds. Never waits: of a holder on another machine it believes what is_held() saw.
  void remove_if_dead();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

// Before `path` is replaced: throws OutputLost if this process has a RunLock on it that another run has taken over, or
// if `path` is not what it was when the lock was taken or written_output was last called. Does nothing without a lock.
// A lock file that was removed by hand is put back.
void confirm_output(const std::string& path);

// After `path` was replaced by this process.
void written_output(const std::string& path);

}  // namespace noiseloom
