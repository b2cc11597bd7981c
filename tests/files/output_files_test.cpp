// Output appears whole or not at all, and where a link leads.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "noiseloom/files/output_files.h"
#include "support/sample_run_file.h"

namespace noiseloom {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::UnorderedElementsAre;

std::string text_of(const std::string& path) { return read_bytes(path); }

TEST(OutputFiles, AreNotThereBeforeAllAreComplete) {
  const TemporaryFolder folder;
  {
    OutputFiles files(posix_file_ops(), false);
    files.write(folder / "new/a.txt", "a");
    EXPECT_FALSE(fs::exists(folder / "new/a.txt"));
  }
  EXPECT_THAT(folder.names(), UnorderedElementsAre());  // nor anything else, when it comes to nothing
  OutputFiles files(posix_file_ops(), false);
  files.write(folder / "new/a.txt", "a");
  files.write(folder / "b.txt", "b");
  files.commit();
  EXPECT_THAT(folder.names(), UnorderedElementsAre("new", "b.txt"));
  EXPECT_EQ(text_of(folder / "new/a.txt"), "a");
}

TEST(OutputFiles, ALinkStaysAndWhatItLeadsToIsWritten) {
  const TemporaryFolder folder;
  fs::create_directory(folder / "store");
  write_bytes(folder / "store/old", "old");
  fs::create_symlink("store/old", folder / "a.txt");
  fs::create_symlink("store/new", folder / "b.txt");  // nothing there yet
  fs::create_symlink("a.txt", folder / "c.txt");      // a link to a link
  OutputFiles first(posix_file_ops(), true);
  first.write(folder / "a.txt", "a");
  first.write(folder / "b.txt", "b");
  first.commit();
  EXPECT_TRUE(fs::is_symlink(folder / "a.txt") && fs::is_symlink(folder / "b.txt"));
  EXPECT_EQ(text_of(folder / "store/old"), "a");
  EXPECT_EQ(text_of(folder / "store/new"), "b");
  OutputFiles second(posix_file_ops(), true);
  second.write(folder / "c.txt", "c");
  second.commit();
  EXPECT_TRUE(fs::is_symlink(folder / "a.txt") && fs::is_symlink(folder / "c.txt"));
  EXPECT_EQ(text_of(folder / "store/old"), "c");
  EXPECT_THAT(folder.names(), UnorderedElementsAre("store", "a.txt", "b.txt", "c.txt"));
}

TEST(OutputFiles, ALinkIsNotWrittenThroughUnlessAsked) {
  const TemporaryFolder folder;
  write_bytes(folder / "old", "old");
  fs::create_symlink("old", folder / "a.txt");
  OutputFiles files(posix_file_ops(), false);
  EXPECT_THROW(files.write(folder / "a.txt", "a"), UserError);
  EXPECT_EQ(text_of(folder / "old"), "old");
}

TEST(OutputFiles, TwoLinksToOneFileAreRefused) {
  const TemporaryFolder folder;
  fs::create_symlink("one", folder / "a.txt");
  fs::create_symlink("one", folder / "b.txt");
  OutputFiles files(posix_file_ops(), true);
  files.write(folder / "a.txt", "a");
  try {
    files.write(folder / "b.txt", "b");
    ADD_FAILURE() << "the first of two files would have been lost";
  } catch (const UserError& error) {
    EXPECT_THAT(error.what(), HasSubstr("b.txt: leads to " + (folder / "one") + ", as " + (folder / "a.txt")));
  }
}

TEST(OutputFiles, TheEndingOfATemporaryFileIsTheTargetsNotThatOfWhatALinkLeadsTo) {
  const TemporaryFolder folder;
  fs::create_symlink("blob.1", folder / "a.png");
  fs::create_symlink("blob.2", folder / "b.png");
  OutputFiles files(posix_file_ops(), true);
  const std::string a = files.add(folder / "a.png");
  const std::string b = files.add(folder / "b.png");
  EXPECT_TRUE(a.ends_with(".png") && b.ends_with(".png"));
  EXPECT_NE(a, b);
}

}  // namespace
}  // namespace noiseloom
