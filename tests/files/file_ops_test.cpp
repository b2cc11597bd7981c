// Operations on files end whole, whatever signals and short transfers come between.
#include "noiseloom/files/file_ops.h"

#include <dlfcn.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdarg>
#include <cstdio>

#include "support/sample_run_file.h"

// The system calls of this program, some of which a signal "interrupts": before they did anything, or after they did.
namespace {

enum class Interrupted { never, before, after };

struct Trouble {
  Interrupted when = Interrupted::never;
  int times = 0;               // how many calls of each kind in a row
  std::size_t most = 1 << 30;  // bytes that a transfer moves at once
  int left = 0;
  int interrupted = 0;
};
thread_local Trouble trouble;

template <class Function>
Function* real(const char* name) {
  return reinterpret_cast<Function*>(dlsym(RTLD_NEXT, name));
}

template <class Call>
auto maybe_interrupted(Call call) -> decltype(call()) {
  if (trouble.when == Interrupted::never) return call();
  if (trouble.left == 0) trouble.left = trouble.times + 1;
  if (--trouble.left == 0) return call();
  ++trouble.interrupted;
  if (trouble.when == Interrupted::after) call();
  errno = EINTR;
  return -1;
}

}  // namespace

extern "C" {

ssize_t pwrite(int fd, const void* data, size_t size, off_t offset) {
  return maybe_interrupted([&] {
    return real<ssize_t(int, const void*, size_t, off_t)>("pwrite")(fd, data, std::min(size, trouble.most), offset);
  });
}
ssize_t pread(int fd, void* data, size_t size, off_t offset) {
  return maybe_interrupted([&] {
    return real<ssize_t(int, void*, size_t, off_t)>("pread")(fd, data, std::min(size, trouble.most), offset);
  });
}
int ftruncate(int fd, off_t size) noexcept {
  return maybe_interrupted([&] { return real<int(int, off_t)>("ftruncate")(fd, size); });
}
int fsync(int fd) {
  return maybe_interrupted([&] { return real<int(int)>("fsync")(fd); });
}
int rename(const char* from, const char* to) noexcept {
  return maybe_interrupted([&] { return real<int(const char*, const char*)>("rename")(from, to); });
}
int link(const char* from, const char* to) noexcept {
  return maybe_interrupted([&] { return real<int(const char*, const char*)>("link")(from, to); });
}
int unlink(const char* path) noexcept {
  return maybe_interrupted([&] { return real<int(const char*)>("unlink")(path); });
}
}

namespace noiseloom {
namespace {

using testing::AllOf;
using testing::HasSubstr;

// Trouble for the life of the object, in this thread.
class WithTrouble {
 public:
  WithTrouble(Interrupted when, int times, std::size_t most = 1 << 30) { trouble = {when, times, most, 0, 0}; }
  ~WithTrouble() { trouble = {}; }
  WithTrouble(const WithTrouble&) = delete;
  WithTrouble& operator=(const WithTrouble&) = delete;
  int interrupted() const { return trouble.interrupted; }
};

std::vector<std::byte> bytes_of(std::string_view text) {
  const auto bytes = std::as_bytes(std::span(text));
  return {bytes.begin(), bytes.end()};
}

TEST(FileOps, AreRepeatedWhereASignalInterruptsThem) {
  const TemporaryFolder folder;
  FileOps& ops = posix_file_ops();
  for (const Interrupted when : {Interrupted::before, Interrupted::after}) {
    const WithTrouble with(when, 3);
    const int fd = ops.create(folder / "a");
    ops.write(fd, 0, bytes_of("0123456789"));
    ops.truncate(fd, 7);
    ops.sync(fd);
    std::vector<std::byte> found(7);
    ops.read(fd, 0, found);
    EXPECT_EQ(found, bytes_of("0123456"));
    ops.close(fd);
    EXPECT_TRUE(ops.link(folder / "a", folder / "b"));
    ops.rename(folder / "a", folder / "c");
    ops.sync_directory(folder.path());
    ops.remove(folder / "b");
    ops.remove(folder / "c");
    EXPECT_THAT(folder.names(), testing::ElementsAre());
    EXPECT_EQ(with.interrupted(), 3 * 9);  // each kind of call above, the folder's sync too
  }
}

TEST(FileOps, ShortTransfersAreContinued) {
  const TemporaryFolder folder;
  FileOps& ops = posix_file_ops();
  const WithTrouble with(Interrupted::before, 1, 3);
  const int fd = ops.create(folder / "a");
  ops.write(fd, 2, bytes_of("abcdefghijk"));
  std::vector<std::byte> found(11);
  ops.read(fd, 2, found);
  EXPECT_EQ(found, bytes_of("abcdefghijk"));
  std::vector<std::byte> too_many(12);
  try {
    ops.read(fd, 2, too_many);
    ADD_FAILURE() << "read past the end";
  } catch (const EnvironmentError& error) {
    EXPECT_THAT(error.what(), AllOf(HasSubstr(folder / "a"), HasSubstr("ends at byte 13, 1 bytes too early")));
  }
  ops.close(fd);
}

TEST(FileOps, AFailureIsNoSignal) {
  const TemporaryFolder folder;
  FileOps& ops = posix_file_ops();
  EXPECT_THROW(ops.remove(folder / "none"), EnvironmentError);
  const WithTrouble with(Interrupted::before, 2);
  EXPECT_THROW(ops.rename(folder / "none", folder / "a"), EnvironmentError);
  EXPECT_THROW(ops.link(folder / "none", folder / "a"), EnvironmentError);
  write_bytes(folder / "a", "1");
  write_bytes(folder / "b", "2");
  EXPECT_THROW(ops.link(folder / "a", folder / "b"), EnvironmentError);  // there is another file already
}

TEST(FollowLinks, LeadsToTheFileThatWouldBeWritten) {
  const TemporaryFolder folder;
  std::filesystem::create_directory(folder / "disk");
  std::filesystem::create_symlink("disk/run.h5", folder / "one");
  std::filesystem::create_symlink(folder / "one", folder / "two");
  std::filesystem::create_symlink("circle", folder / "circle");
  EXPECT_EQ(follow_links(folder / "two"), folder / "disk/run.h5");  // not there yet
  write_bytes(folder / "disk/run.h5", "x");
  EXPECT_EQ(follow_links(folder / "two"), folder / "disk/run.h5");
  EXPECT_EQ(follow_links(folder / "none/at/all"), folder / "none/at/all");
  EXPECT_EQ(follow_links("run.h5"), "run.h5");
  try {
    follow_links(folder / "circle");
    ADD_FAILURE() << "followed a circle";
  } catch (const EnvironmentError& error) {
    EXPECT_THAT(error.what(), AllOf(HasSubstr(folder / "circle"), HasSubstr("symbolic link")));
  }
}

}  // namespace
}  // namespace noiseloom
