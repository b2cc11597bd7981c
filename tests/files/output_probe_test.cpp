// What would end a run at its first save ends it before it begins.
#include "noiseloom/files/output_probe.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>

#include "noiseloom/files/run_lock.h"
#include "support/sample_run_file.h"

namespace noiseloom {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::UnorderedElementsAre;

constexpr std::uint64_t small = 100'000;

// "fine", or "user: ..." or "environment: ...".
std::string probing(const std::string& path, std::uint64_t bytes = small) {
  try {
    const std::vector<std::string> warnings = probe_output(path, bytes);
    return warnings.empty() ? "fine" : "warning: " + warnings.front();
  } catch (const UserError& error) {
    return std::string("user: ") + error.what();
  } catch (const EnvironmentError& error) {
    return std::string("environment: ") + error.what();
  }
}

TEST(ProbeOutput, LeavesEverythingAsItWas) {
  const TemporaryFolder folder;
  const std::string path = folder / "run.h5";
  EXPECT_EQ(probing(path), "fine");
  EXPECT_THAT(folder.names(), ElementsAre());
  write_sample_file(posix_file_ops(), path, sample_content(), 0);
  write_sample_file(posix_file_ops(), path, sample_content(), 1);
  const std::string before = read_bytes(path);
  EXPECT_EQ(probing(path), "fine");
  EXPECT_EQ(read_bytes(path), before);
  EXPECT_THAT(folder.names(), UnorderedElementsAre("run.h5", "run.h5.prev"));
}

TEST(ProbeOutput, NamesTooLongForTheirTemporaries) {
  const TemporaryFolder folder;
  const std::string longest = folder / std::string(255 - 21, 'n');  // ".tmp-" and 16 digits
  EXPECT_EQ(probing(longest), "fine");
  const RunLock lock(longest);  // needs less
  write_sample_file(posix_file_ops(), longest, sample_content());
  EXPECT_THAT(probing(longest + "n"), AllOf(HasSubstr("user: "), HasSubstr("235 characters"), HasSubstr("21 more")));
  EXPECT_THAT(probing(longest + std::string(40, 'n')), AllOf(HasSubstr("user: "), HasSubstr("too long")));
  EXPECT_THROW(RunLock(longest + std::string(40, 'n')), UserError);
}

TEST(ProbeOutput, APreviousGenerationThatIsNone) {
  const TemporaryFolder folder;
  const std::string path = folder / "run.h5";
  write_bytes(path + ".prev", "my own notes");
  EXPECT_THAT(probing(path), AllOf(HasSubstr("user: " + path + ".prev"), HasSubstr("not a run file")));
  EXPECT_EQ(read_bytes(path + ".prev"), "my own notes");
  std::filesystem::remove(path + ".prev");
  std::filesystem::create_directory(path + ".prev");
  EXPECT_THAT(probing(path), AllOf(HasSubstr("user: " + path + ".prev"), HasSubstr("folder")));
  std::filesystem::remove(path + ".prev");
  std::filesystem::create_symlink("/dev/null", path + ".prev");
  EXPECT_THAT(probing(path), HasSubstr("user: " + path + ".prev"));
  std::filesystem::remove(path + ".prev");
  write_bytes(path + ".prev", "");  // what a power cut leaves
  EXPECT_EQ(probing(path), "fine");
}

TEST(ProbeOutput, AFolderInItsPlace) {
  const TemporaryFolder folder;
  std::filesystem::create_directory(folder / "run.h5");
  EXPECT_THAT(probing(folder / "run.h5"), AllOf(HasSubstr("user: "), HasSubstr("is a folder")));
}

TEST(ProbeOutput, ADiskThatIsTooSmall) {
  const TemporaryFolder folder;
  const std::string path = folder / "run.h5";
  const std::filesystem::space_info space = std::filesystem::space(folder.path());
  EXPECT_THAT(probing(path, space.available + (1U << 30)),
              AllOf(HasSubstr("environment: " + path), HasSubstr("no space"), HasSubstr("are free")));
  EXPECT_THAT(probing(path, space.available / 2),
              AllOf(HasSubstr("warning: " + path), HasSubstr("later saves may fail")));
  EXPECT_EQ(probing(path, space.available / 8), "fine");
  EXPECT_THAT(folder.names(), ElementsAre());
}

// In a child, as limits and users cannot be had back.
template <class Body>
std::string text_of_child(Body body) {
  int ends[2] = {};
  EXPECT_EQ(::pipe(ends), 0);
  const pid_t child = ::fork();
  if (child == 0) {
    const std::string text = body();
    [[maybe_unused]] const ssize_t done = ::write(ends[1], text.data(), text.size());
    ::_exit(0);
  }
  ::close(ends[1]);
  std::string text(4096, '\0');
  const ssize_t size = ::read(ends[0], text.data(), text.size());
  ::close(ends[0]);
  ::waitpid(child, nullptr, 0);
  return text.substr(0, static_cast<std::size_t>(std::max<ssize_t>(size, 0)));
}

TEST(ProbeOutput, ALimitOfFileSizes) {
  const TemporaryFolder folder;
  EXPECT_THAT(text_of_child([&] {
                const rlimit limit{50'000, 50'000};
                ::setrlimit(RLIMIT_FSIZE, &limit);
                return probing(folder / "run.h5");
              }),
              AllOf(HasSubstr("environment: "), HasSubstr("ulimit -f")));
}

TEST(ProbeOutput, AFolderThatCannotBeWritten) {
  const TemporaryFolder folder;
  ASSERT_EQ(::chmod(folder.path().c_str(), 0555), 0);
  EXPECT_THAT(text_of_child([&]() -> std::string {
                if (::getuid() == 0 && ::seteuid(65534) != 0) return "environment: Permission denied";  // no other user
                return probing(folder / "run.h5");
              }),
              AllOf(HasSubstr("environment: "), HasSubstr("Permission denied")));
  ::chmod(folder.path().c_str(), 0755);
}

TEST(ProbeOutput, AnothersFileInAStickyFolder) {
  if (::getuid() != 0) GTEST_SKIP() << "needs two users";
  const TemporaryFolder folder;
  const std::string path = folder / "run.h5";
  write_sample_file(posix_file_ops(), path, sample_content());
  ASSERT_EQ(::chmod(folder.path().c_str(), 01777), 0);
  EXPECT_THAT(text_of_child([&]() -> std::string {
                if (::seteuid(65534) != 0) return "user: another user";
                return probing(path);
              }),
              AllOf(HasSubstr("user: "), HasSubstr("another user")));
}

TEST(RunFileBytes, BoundsWhatIsWritten) {
  const TemporaryFolder folder;
  const RunFileContent content = sample_content();
  write_sample_file(posix_file_ops(), folder / "run.h5", content);
  const std::uint64_t bytes = run_file_bytes(content.extents, content.datasets, content.config.size());
  EXPECT_GE(bytes, std::filesystem::file_size(folder / "run.h5"));
  EXPECT_LE(bytes, std::filesystem::file_size(folder / "run.h5") + 400'000);
  EXPECT_EQ(bytes_needed(bytes), 3 * bytes);
}

}  // namespace
}  // namespace noiseloom
