// One run at a time writes an output.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <optional>

#include "noiseloom/files/run_file.h"
#include "support/sample_run_file.h"

namespace noiseloom {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;

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

std::string refusal(const std::string& path) {
  try {
    const RunLock lock(path);
    return "locked";
  } catch (const UserError& error) {
    return error.what();
  }
}

TEST(RunLock, ASecondRunIsToldWhoHoldsIt) {
  const TemporaryFolder folder;
  const std::string path = folder / "run.h5";
  Child holder([&](auto ready) {
    const RunLock lock(path);
    ready();
    ::pause();
  });
  ASSERT_TRUE(holder.wait_until_ready());
  char host[256] = {};
  ::gethostname(host, sizeof host - 1);
  EXPECT_THAT(refusal(path), AllOf(HasSubstr(path), HasSubstr("process " + std::to_string(holder.pid())),
                                   HasSubstr(host), HasSubstr("since 2"), HasSubstr("UTC")));
  EXPECT_EQ(refusal(folder / "other.h5"), "locked");
}

TEST(RunLock, AKilledHolderFreesIt) {
  const TemporaryFolder folder;
  const std::string path = folder / "run.h5";
  Child holder([&](auto ready) {
    const RunLock lock(path);
    ready();
    ::pause();
  });
  ASSERT_TRUE(holder.wait_until_ready());
  holder.kill_and_wait();
  EXPECT_TRUE(std::filesystem::exists(path + ".lock"));
  const RunLock lock(path);
  EXPECT_TRUE(lock.enforced());
  EXPECT_THAT(read_bytes(path + ".lock"), HasSubstr("process " + std::to_string(::getpid())));
}

TEST(RunLock, LeavesNoFileBehind) {
  const TemporaryFolder folder;
  { const RunLock lock(folder / "run.h5"); }
  EXPECT_THAT(folder.names(), ElementsAre());
}

// Holders come and go, each removing the file that the others may just have opened; a file that each holder measures
// and then lengthens by a byte loses no byte only if there never are two holders.
TEST(RunLock, IsNeverHeldTwiceWhileFilesAreRemoved) {
  const TemporaryFolder folder;
  const std::string path = folder / "run.h5";
  const std::string counter = folder / "counter";
  write_bytes(counter, "");
  constexpr int num_children = 4;
  constexpr int steps = 150;
  {
    std::vector<std::unique_ptr<Child>> children;
    for (int i = 0; i < num_children; ++i) {
      children.push_back(std::make_unique<Child>([&](auto ready) {
        for (int done = 0; done < steps;) {
          try {
            const RunLock lock(path);
            const std::size_t size = std::filesystem::file_size(counter);
            ::usleep(200);  // time for a second holder to come in between, if one can
            put_bytes(counter, size, "x");
            ++done;
          } catch (const UserError&) {
            ::usleep(100);
          }
        }
        ready();
      }));
    }
    for (const auto& child : children) ASSERT_TRUE(child->wait_until_ready());
  }
  EXPECT_EQ(std::filesystem::file_size(counter), static_cast<std::uintmax_t>(num_children * steps));
}

TEST(RunLock, NamesAFolderThatCannotBeWritten) {
  const TemporaryFolder folder;
  const std::string closed = folder / "closed";
  std::filesystem::create_directory(closed);
  ASSERT_EQ(::chmod(closed.c_str(), 0555), 0);
  ASSERT_EQ(::chmod(folder.path().c_str(), 0755), 0);
  const Child other_user([&](auto ready) {
    constexpr uid_t nobody = 65534;
    if (::getuid() == 0 && ::seteuid(nobody) != 0) return;  // root may write anywhere
    try {
      const RunLock lock(closed + "/run.h5");
    } catch (const EnvironmentError& error) {
      const std::string text = error.what();
      if (text.starts_with(closed + ": ") && text.find("Permission denied") != text.npos) ready();
    }
  });
  EXPECT_TRUE(other_user.wait_until_ready());
}

TEST(RunLock, AMissingFolderIsTheUsersFault) {
  const TemporaryFolder folder;
  EXPECT_THAT(refusal(folder / "no/run.h5"), AllOf(HasSubstr(folder / "no"), HasSubstr("no such folder")));
}

}  // namespace
}  // namespace noiseloom
