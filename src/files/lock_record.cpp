#include "files/lock_record.h"

#include <fmt/format.h>
#include <unistd.h>

#include <chrono>
#include <cstdlib>
#include <ctime>
#include <fstream>
#include <random>
#include <sstream>

#include "noiseloom/files/digest.h"

namespace noiseloom {
namespace {

std::string variable(const char* name) {
  const char* value = std::getenv(name);
  return value ? value : "";
}

std::string host_name() {
  char host[256] = "unknown host";
  ::gethostname(host, sizeof host - 1);
  return host;
}

// The kernel's number of this boot, the same in all containers; where it is hidden, the name of the host.
std::string machine_of_this_process() {
  std::string boot;
  std::ifstream("/proc/sys/kernel/random/boot_id") >> boot;
  return boot.empty() ? host_name() : boot;
}

// /proc/PID/stat from its third field on: after the name, which is in brackets and may hold anything. Empty if there is
// no such process.
std::istringstream status_fields(std::int64_t pid) {
  std::ifstream file(fmt::format("/proc/{}/stat", pid));
  std::string text;
  std::getline(file, text);
  return std::istringstream(text.substr(std::min(text.size(), text.rfind(')') + 1)));
}

// Field 22; 0 if there is no such process.
std::int64_t start_of(std::int64_t pid) {
  std::istringstream words = status_fields(pid);
  std::string word;
  for (int field = 3; field < 22; ++field) words >> word;
  std::int64_t start = 0;
  words >> start;
  return words ? start : 0;
}

std::string now_text() {
  const std::time_t now = std::time(nullptr);
  std::tm utc{};
  ::gmtime_r(&now, &utc);
  char text[32] = {};
  std::strftime(text, sizeof text, "%Y-%m-%d %H:%M:%S UTC", &utc);
  return text;
}

}  // namespace

LockRecord own_record() {
  LockRecord record;
  record.pid = ::getpid();
  record.holder = fmt::format("process {} on {}, since {}", record.pid, host_name(), now_text());
  record.machine = machine_of_this_process();
  record.started = start_of(record.pid);
  const std::string seed = fmt::format("{} {} {} {}", record.holder, record.machine, std::random_device()(),
                                       std::chrono::steady_clock::now().time_since_epoch().count());
  record.number = to_hex(digest_of(std::as_bytes(std::span(seed))));
  // The number of a job is that of one cluster.
  if (const std::string job = variable("SLURM_JOB_ID"); !job.empty()) {
    record.slurm_job = variable("SLURM_CLUSTER_NAME") + "/" + job;
    record.slurm_restarts = std::atoll(variable("SLURM_RESTART_COUNT").c_str());
  }
  return record;
}

std::string to_text(const LockRecord& record) {
  std::string text = fmt::format("{}\nmachine {}\npid {}\nstarted {}\nnumber {}\n", record.holder, record.machine,
                                 record.pid, record.started, record.number);
  if (!record.slurm_job.empty()) {
    text += fmt::format("slurm_job {}\nslurm_restarts {}\n", record.slurm_job, record.slurm_restarts);
  }
  return text;
}

LockRecord parse_record(const std::string& text) {
  LockRecord record;
  std::istringstream lines(text);
  std::getline(lines, record.holder);
  for (std::string line; std::getline(lines, line);) {
    std::istringstream words(line);
    std::string key;
    words >> key;
    if (key == "machine") words >> record.machine;
    if (key == "pid") words >> record.pid;
    if (key == "started") words >> record.started;
    if (key == "number") words >> record.number;
    if (key == "slurm_job") words >> record.slurm_job;
    if (key == "slurm_restarts") words >> record.slurm_restarts;
  }
  return record;
}

Holder judge(const LockRecord& theirs, const LockRecord& ours, SystemLock lock) {
  const bool held = lock == SystemLock::held;
  // A holder that has just started and not said who it is, or one of another program.
  if (theirs.machine.empty()) return held ? Holder::alive : Holder::dead;
  const bool predecessor =
      !theirs.slurm_job.empty() && theirs.slurm_job == ours.slurm_job && theirs.slurm_restarts < ours.slurm_restarts;
  if (theirs.machine == ours.machine) {
    const bool alive = lock == SystemLock::unsupported ? is_running(theirs) : held;
    if (!alive) return Holder::dead;
    return predecessor ? Holder::superseded : Holder::alive;
  }
  return predecessor ? Holder::dead : Holder::unknown;
}

bool is_running(const LockRecord& record) {
  std::string state;
  status_fields(record.pid) >> state;
  return record.pid > 0 && state != "Z" && state != "X" && start_of(record.pid) == record.started;
}

bool is_suspended(const LockRecord& record) {
  std::string state;
  status_fields(record.pid) >> state;
  return is_running(record) && (state == "T" || state == "t");
}

}  // namespace noiseloom
