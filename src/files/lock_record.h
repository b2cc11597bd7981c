// What a lock file says of its holder.
//
//   process 123 on node7, since 2026-01-31 12:00:00 UTC       for people
//   machine 5e3c...                                           this boot of this machine
//   pid 123
//   started 4567                                              clock ticks after the boot: tells pids used again
//   number 0123456789abcdef                                   drawn for this holder
//   slurm_job cluster 123
//   slurm_restarts 1
#pragma once

#include <cstdint>
#include <string>

namespace noiseloom {

struct LockRecord {
  std::string holder;  // the line for people
  std::string machine;
  std::int64_t pid = 0;
  std::int64_t started = 0;
  std::string number;
  std::string slurm_job;  // "" outside Slurm
  std::int64_t slurm_restarts = 0;
};

// Of this process, with a new number.
LockRecord own_record();

std::string to_text(const LockRecord& record);
// Fields that the text lacks keep their defaults.
LockRecord parse_record(const std::string& text);

enum class SystemLock { free, held, unsupported };
enum class Holder {
  alive,
  dead,
  superseded,  // lives on this machine still, but the batch system has started its job anew: this process
  unknown,     // only its heartbeat can tell
};

// What can be said of the holder of a lock file at once. `lock` is what the system said when we tried to lock the file.
Holder judge(const LockRecord& theirs, const LockRecord& ours, SystemLock lock);

// Whether the process of a holder on this machine still lives; one that is dead and not yet collected does not.
bool is_running(const LockRecord& record);
// Whether it is suspended (SIGSTOP), so that it does not end by itself.
bool is_suspended(const LockRecord& record);

}  // namespace noiseloom
