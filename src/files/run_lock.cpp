#include "noiseloom/files/run_lock.h"

#include <fmt/format.h>
#include <pthread.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <condition_variable>
#include <csignal>
#include <map>
#include <mutex>
#include <optional>
#include <system_error>
#include <thread>
#include <utility>

#include "files/descriptor.h"
#include "files/lock_record.h"
#include "files/system_call.h"
#include "noiseloom/files/digest.h"
#include "noiseloom/files/file_ops.h"

namespace noiseloom {
namespace {

using std::chrono::milliseconds;
using std::chrono::nanoseconds;
using std::chrono::steady_clock;

Descriptor open_lock_file(const std::string& lock_path) {
  Descriptor file = open_or_none(lock_path, O_RDWR | O_CREAT);
  if (file.fd() >= 0) return file;
  const int error = errno;
  const std::string folder = parent_directory(lock_path);
  if (error == ENOENT || error == ENOTDIR) throw UserError(folder, "there is no such folder to write into");
  if (error == ENAMETOOLONG) throw UserError(lock_path, "this name is too long; choose a shorter one for the output");
  throw EnvironmentError(folder + ": cannot write into this folder (" + lock_path +
                         "): " + std::system_category().message(error));
}

SystemLock try_lock(int fd, const std::string& lock_path) {
  if (uninterrupted([&] { return ::flock(fd, LOCK_EX | LOCK_NB); }) == 0) return SystemLock::free;
  if (errno == EWOULDBLOCK) return SystemLock::held;
  if (errno == ENOSYS || errno == ENOLCK || errno == EOPNOTSUPP) return SystemLock::unsupported;
  throw EnvironmentError(lock_path + ": cannot lock: " + std::system_category().message(errno));
}

// False where the file was removed or replaced between our opening and our locking it.
bool still_there(int fd, const std::string& lock_path) {
  struct stat ours {};
  struct stat there {};
  return ::fstat(fd, &ours) == 0 && ::stat(lock_path.c_str(), &there) == 0 && ours.st_ino == there.st_ino &&
         ours.st_dev == there.st_dev;
}

// With `failed`, whether reading ended by an error is told there.
std::string read_start(int fd, std::size_t most, bool* failed = nullptr) {
  std::string text(most, '\0');
  std::size_t size = 0;
  while (size < most) {
    const ssize_t done =
        uninterrupted([&] { return ::pread(fd, text.data() + size, most - size, static_cast<off_t>(size)); });
    if (failed != nullptr) *failed = done < 0;
    if (done <= 0) break;
    size += static_cast<std::size_t>(done);
  }
  text.resize(size);
  return text;
}

constexpr std::size_t longest_record = 4096;

nanoseconds change_time(int fd) {
  struct stat status {};
  if (::fstat(fd, &status) != 0) return nanoseconds(0);
  return std::chrono::seconds(status.st_mtim.tv_sec) + nanoseconds(status.st_mtim.tv_nsec);
}

// What a lock file says now. Opened anew each time: only that makes a network file system ask its server.
struct Sight {
  std::string text;
  nanoseconds changed{0};
  friend bool operator==(const Sight&, const Sight&) = default;
};

std::optional<Sight> look_at(const std::string& lock_path) {
  const Descriptor file = open_or_none(lock_path, O_RDONLY);
  if (file.fd() < 0) return std::nullopt;
  return Sight{read_start(file.fd(), longest_record), change_time(file.fd())};
}

// What stands at a path, for comparing: a run file's first bytes hold the digests of all the rest.
// Empty where nothing stands there; nothing where it cannot be read just now, which says nothing about what it is.
std::optional<std::string> identity_of(const std::string& path) {
  constexpr std::size_t bytes = 4096;
  const Descriptor file = open_or_none(path, O_RDONLY);
  if (file.fd() < 0) return errno == ENOENT ? std::optional<std::string>("") : std::nullopt;
  bool failed = false;
  const std::string start = read_start(file.fd(), bytes, &failed);
  if (failed) return std::nullopt;
  return to_hex(digest_of(std::as_bytes(std::span(start))));
}

std::mutex registry_mutex;
std::map<std::string, RunLock::Impl*>& registry() {  // by the path that is locked, links followed
  static std::map<std::string, RunLock::Impl*> locks;
  return locks;
}

}  // namespace

struct RunLock::Impl {
  Impl(const std::string& output, const std::function<void(const std::string&)>& say, LockTiming times)
      : path(follow_links(output)), lock_path(path + ".lock"), ours(own_record()), timing(times) {
    while (!try_to_hold(say)) {
    }
    identity = identity_of(path);
    start_beating();
    const std::lock_guard guard(registry_mutex);
    registry()[path] = this;
  }
  ~Impl() {
    {
      const std::lock_guard guard(registry_mutex);
      registry().erase(path);
    }
    stop_beating();
    // While it is still held, and only if it is ours, so that nobody else's file is removed.
    const std::optional<Sight> sight = look_at(lock_path);
    if (sight && parse_record(sight->text).number == ours.number) ::unlink(lock_path.c_str());
  }
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;

  bool try_to_hold(const std::function<void(const std::string&)>& say);
  bool falls_silent(const Sight& first, const std::function<void(const std::string&)>& say) const;
  bool ends_in_time(const LockRecord& theirs, const std::function<void(const std::string&)>& say) const;
  std::string side_path() const { return path + ".tmp-" + ours.number; }  // as a temporary, in case we are killed
  nanoseconds file_system_time() const;
  bool replace_lock_file(const std::function<bool(const std::optional<Sight>&)>& is_as_seen);
  void write_record(int fd) const;
  void start_beating();
  void stop_beating();
  void confirm();

  const std::string path;
  const std::string lock_path;
  const LockRecord ours;
  const LockTiming timing;
  Descriptor file;
  bool enforced = true;
  std::optional<std::string> identity;  // of what this run found or wrote at `path`, where it could be read
  std::thread beating;
  std::mutex mutex;  // of what follows, and of `file` once the heartbeat runs
  std::condition_variable wake;
  bool ending = false;
};

// False where somebody else was quicker and everything must be looked at again.
bool RunLock::Impl::try_to_hold(const std::function<void(const std::string&)>& say) {
  file = open_lock_file(lock_path);
  const SystemLock lock = try_lock(file.fd(), lock_path);
  enforced = lock != SystemLock::unsupported;
  if (lock != SystemLock::held && !still_there(file.fd(), lock_path)) return false;
  const Sight seen{read_start(file.fd(), longest_record), change_time(file.fd())};
  const LockRecord theirs = parse_record(seen.text);
  Holder holder = judge(theirs, ours, lock);
  if (holder == Holder::unknown) {
    holder = falls_silent(seen, say) ? Holder::dead : Holder::alive;
    if (lock != SystemLock::held && !still_there(file.fd(), lock_path)) return false;
  }
  if (holder == Holder::superseded && ends_in_time(theirs, say)) return false;
  if (holder == Holder::alive) {
    const std::string who = theirs.holder.empty() ? "a run that has just started" : theirs.holder;
    throw OutputHeld(path, "another run is writing it: " + who + "; wait for it or stop it first");
  }
  // A lock that the server keeps for a dead node lies on the file: a new file has none.
  if (lock == SystemLock::held) {
    return replace_lock_file([&](const std::optional<Sight>& now) {
      if (holder != Holder::superseded) return now == std::optional<Sight>(seen);
      return now && parse_record(now->text).number == theirs.number;  // it may beat on
    });
  }
  write_record(file.fd());
  return true;
}

// The present time by the clock that stamps files here, which need not be this machine's.
nanoseconds RunLock::Impl::file_system_time() const {
  const Descriptor side = open_or_none(side_path(), O_RDWR | O_CREAT | O_EXCL);
  if (side.fd() < 0) return nanoseconds(0);
  const nanoseconds now = change_time(side.fd());
  ::unlink(side_path().c_str());
  return now;
}

bool RunLock::Impl::falls_silent(const Sight& first, const std::function<void(const std::string&)>& say) const {
  // However long ago the last beat seems to be: where that clock has just jumped, the next one tells.
  const nanoseconds least = timing.beat + timing.beat / 2;
  const nanoseconds silent_before = std::max(nanoseconds(0), file_system_time() - first.changed);
  const nanoseconds left = std::max(least, nanoseconds(timing.silence) - silent_before);
  if (say) {
    say(fmt::format("{}: held by {}, last heard of {:.0f} s ago; waiting up to {:.0f} s to see whether it still lives",
                    path, parse_record(first.text).holder, std::chrono::duration<double>(silent_before).count(),
                    std::chrono::duration<double>(left).count()));
  }
  const auto end = steady_clock::now() + left;
  while (steady_clock::now() < end) {
    std::this_thread::sleep_for(timing.beat / 8);
    const std::optional<Sight> now = look_at(lock_path);
    if (!now) return true;  // it ended in these seconds, and properly
    if (*now != first) return false;
  }
  return true;
}

// Whether our predecessor on this machine, which the batch system holds to be over, frees its lock.
bool RunLock::Impl::ends_in_time(const LockRecord& theirs, const std::function<void(const std::string&)>& say) const {
  if (say)
    say(fmt::format("{}: held by {}, which this job has been started anew after; taking over", path, theirs.holder));
  const auto end = steady_clock::now() + timing.dying;
  while (steady_clock::now() < end && !is_suspended(theirs)) {
    std::this_thread::sleep_for(timing.dying / 100);
    const std::optional<Sight> now = look_at(lock_path);
    if (!now || parse_record(now->text).number != theirs.number) return true;
    if (enforced ? try_lock(file.fd(), lock_path) == SystemLock::free : !is_running(theirs)) return true;
  }
  return false;
}

bool RunLock::Impl::replace_lock_file(const std::function<bool(const std::optional<Sight>&)>& is_as_seen) {
  Descriptor fresh = open_or_none(side_path(), O_RDWR | O_CREAT | O_EXCL);
  if (fresh.fd() < 0) {
    throw EnvironmentError(side_path() + ": cannot create: " + std::system_category().message(errno));
  }
  try {
    try_lock(fresh.fd(), side_path());
    write_record(fresh.fd());
    if (!is_as_seen(look_at(lock_path))) {  // somebody else did the same just now, or its holder came back to life
      ::unlink(side_path().c_str());
      return false;
    }
    posix_file_ops().rename(side_path(), lock_path);
  } catch (...) {
    ::unlink(side_path().c_str());
    throw;
  }
  file = std::move(fresh);
  return still_there(file.fd(), lock_path);
}

// That it cannot be written is no reason to stop: on one machine the system's lock is enough.
void RunLock::Impl::write_record(int fd) const {
  const std::string text = to_text(ours);
  if (uninterrupted([&] { return ::ftruncate(fd, 0); }) != 0) return;
  [[maybe_unused]] const ssize_t done = uninterrupted([&] { return ::pwrite(fd, text.data(), text.size(), 0); });
}

void RunLock::Impl::start_beating() {
  // Signals are for the threads that compute.
  sigset_t all;
  sigset_t before;
  sigfillset(&all);
  ::pthread_sigmask(SIG_SETMASK, &all, &before);
  beating = std::thread([this] {
    std::unique_lock guard(mutex);
    while (!wake.wait_for(guard, timing.beat, [this] { return ending; })) ::futimens(file.fd(), nullptr);
  });
  ::pthread_sigmask(SIG_SETMASK, &before, nullptr);
}

void RunLock::Impl::stop_beating() {
  {
    const std::lock_guard guard(mutex);
    ending = true;
  }
  wake.notify_all();
  beating.join();
}

void RunLock::Impl::confirm() {
  const std::lock_guard guard(mutex);
  std::optional<Sight> sight = look_at(lock_path);
  if (!sight) {  // removed by hand
    Descriptor fresh = open_or_none(lock_path, O_RDWR | O_CREAT | O_EXCL);
    if (fresh.fd() >= 0) {
      try_lock(fresh.fd(), lock_path);
      write_record(fresh.fd());
      file = std::move(fresh);
    }
    sight = look_at(lock_path);
  }
  const LockRecord holder = sight ? parse_record(sight->text) : LockRecord{};
  if (!holder.number.empty() && holder.number != ours.number) {
    throw OutputLost(
        fmt::format("{}: taken over by another run ({}) while this one was not heard of; it is left as it "
                    "is",
                    path, holder.holder));
  }
  const std::optional<std::string> found = identity_of(path);
  if (!found) throw EnvironmentError(path + ": cannot be read, so it is not known whose it is; it is left as it is");
  if (!identity) identity = found;
  if (!found->empty() && found != identity) {
    throw OutputLost(path + ": replaced by another run or program since this run last wrote it; it is left as it is");
  }
}

RunLock::RunLock(const std::string& path, const std::function<void(const std::string&)>& say, LockTiming timing)
    : impl_(std::make_unique<Impl>(path, say, timing)) {}
RunLock::~RunLock() = default;
bool RunLock::enforced() const { return impl_->enforced; }
const std::string& RunLock::number() const { return impl_->ours.number; }

struct LockWatch::Impl {
  const std::string lock_path;
  const LockTiming timing;
  const LockRecord ours = own_record();
  Sight seen = {};
  steady_clock::time_point seen_at = {};
};

LockWatch::LockWatch(const std::string& path, LockTiming timing)
    : impl_(new Impl{.lock_path = follow_links(path) + ".lock", .timing = timing}) {}
LockWatch::~LockWatch() = default;

bool LockWatch::is_held() {
  const std::optional<Sight> sight = look_at(impl_->lock_path);
  if (!sight) return posix_file_ops().exists(impl_->lock_path);  // one that others may not read tells no more
  const LockRecord theirs = parse_record(sight->text);
  if (theirs.machine == impl_->ours.machine && is_running(theirs)) return true;
  // The process may still live under another number, in a container: the system's lock knows. It is not tried where
  // nobody has said yet who holds it, as a run that begins would find it taken.
  Holder holder = Holder::unknown;
  if (const Descriptor file = open_or_none(impl_->lock_path, O_RDWR); file.fd() >= 0 && !theirs.machine.empty()) {
    holder = judge(theirs, impl_->ours, try_lock(file.fd(), impl_->lock_path));
  }
  if (holder != Holder::unknown) return holder != Holder::dead;
  if (*sight != impl_->seen) {
    impl_->seen = *sight;
    impl_->seen_at = steady_clock::now();
  }
  return steady_clock::now() - impl_->seen_at < impl_->timing.silence;
}

void LockWatch::remove_if_dead() {
  const Descriptor file = open_or_none(impl_->lock_path, O_RDWR);
  if (file.fd() < 0) return;
  const SystemLock lock = try_lock(file.fd(), impl_->lock_path);
  if (!still_there(file.fd(), impl_->lock_path)) return;
  const Sight now{read_start(file.fd(), longest_record), change_time(file.fd())};
  Holder holder = judge(parse_record(now.text), impl_->ours, lock);
  if (holder == Holder::unknown && now == impl_->seen &&
      steady_clock::now() - impl_->seen_at >= impl_->timing.silence) {
    holder = Holder::dead;
  }
  if (holder == Holder::dead) ::unlink(impl_->lock_path.c_str());
}

void confirm_output(const std::string& path) {
  const std::lock_guard guard(registry_mutex);
  const auto found = registry().find(follow_links(path));
  if (found != registry().end()) found->second->confirm();
}

void written_output(const std::string& path) {
  const std::lock_guard guard(registry_mutex);
  const auto found = registry().find(follow_links(path));
  if (found != registry().end()) found->second->identity = identity_of(found->first);
}

}  // namespace noiseloom
