// What the index of a bank says, after others have written to it and after kills.
#include "noiseloom/files/bank_index.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <sstream>

#include "support/sample_run_file.h"

namespace noiseloom {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

class BankIndexTest : public testing::Test {
 protected:
  // Of members a, b, c, ... that have run files already.
  BankIndex index(std::size_t num_members = 3) {
    std::vector<BankIndex::Member> members;
    for (std::size_t i = 0; i < num_members; ++i) {
      members.push_back({std::string(1, static_cast<char>('a' + i)), "config", {std::to_string(i)}});
      std::ofstream(member_path(folder_.path(), members.back().name)) << "made";
    }
    return {folder_.path(), {"texture.seed"}, members};
  }
  static IndexRow done(std::size_t member) {
    return {.state = "done",
            .relative_error = 0.5,
            .seconds = 1,
            .checksum = "sum",
            .config = "config",
            .values = {std::to_string(member)}};
  }
  std::string text(const std::string& name = "index.csv") const {
    std::ostringstream read;
    read << std::ifstream(folder_ / name).rdbuf();
    return read.str();
  }
  std::vector<std::string> lines() const {
    std::istringstream all(text());
    std::vector<std::string> found;
    for (std::string line; std::getline(all, line);) found.push_back(line.substr(0, line.find(",0.5")));
    return found;
  }

  TemporaryFolder folder_;
};

constexpr const char* columns = "name,state,relative_error,seconds,checksum,config,texture.seed";

TEST_F(BankIndexTest, HoldsWhatIsDoneAtOnceAndAllInOrderAtTheEnd) {
  BankIndex one = index();
  BankIndex other = index();
  EXPECT_TRUE(one.add(2, done(2)));
  EXPECT_TRUE(other.add(0, done(0)));
  EXPECT_FALSE(one.add(0, done(0)));  // another was quicker
  EXPECT_THAT(lines(), ElementsAre(columns, "c,done", "a,done"));
  EXPECT_EQ(one.num_done(), 2);
  EXPECT_FALSE(one.is_done(1));
  one.write();
  EXPECT_THAT(lines(), ElementsAre(columns, "a,done", "b,begun,,0,,config,1", "c,done"));
  const std::vector<DoneMember> listed = done_members(folder_.path());
  ASSERT_EQ(listed.size(), 2);
  EXPECT_EQ(listed[1].name + listed[1].checksum + listed[1].settings, "csum");
  EXPECT_THAT(text("index.json"), HasSubstr("\"name\": \"b\", \"file\": \"b.h5\", \"state\": \"begun\""));
}

TEST_F(BankIndexTest, AMemberHasOneRowThoughItWasOpenBefore) {
  BankIndex one = index();
  BankIndex other = index();
  one.write();
  EXPECT_THAT(lines(), ElementsAre(columns, "a,begun,,0,,config,0", "b,begun,,0,,config,1", "c,begun,,0,,config,2"));
  EXPECT_TRUE(one.add(1, done(1)));
  EXPECT_TRUE(other.add(0, done(0)));
  EXPECT_THAT(lines(), ElementsAre(columns, "b,done", "a,done"));
  one.refresh();
  EXPECT_EQ(one.num_done(), 2);
}

TEST_F(BankIndexTest, WhatAKilledWriterLeftOfARowIsCutOff) {
  BankIndex one = index();
  EXPECT_TRUE(one.add(0, done(0)));
  std::ofstream(index_path(folder_.path()), std::ios::app) << "b,done,0.5,1,su";
  one.refresh();
  EXPECT_FALSE(one.is_done(1));
  EXPECT_FALSE(index().is_done(1));
  EXPECT_TRUE(one.add(2, done(2)));
  EXPECT_THAT(lines(), ElementsAre(columns, "a,done", "c,done"));
}

TEST_F(BankIndexTest, AnIndexThatAnotherCommandWroteAnewIsReadAnew) {
  BankIndex one = index();
  EXPECT_TRUE(one.add(0, done(0)));
  std::filesystem::remove(index_path(folder_.path()));
  one.refresh();
  EXPECT_EQ(one.num_done(), 0);
  BankIndex other = index();
  EXPECT_TRUE(other.add(1, done(1)));
  EXPECT_TRUE(other.add(2, done(2)));
  one.refresh();
  EXPECT_FALSE(one.is_done(0));
  EXPECT_EQ(one.num_done(), 2);
}

TEST_F(BankIndexTest, ADoneMemberWhoseRunFileWentIsOpen) {
  BankIndex one = index();
  EXPECT_TRUE(one.add(0, done(0)));
  std::filesystem::remove(member_path(folder_.path(), "a"));
  one.write();
  EXPECT_FALSE(one.is_done(0));
  EXPECT_EQ(lines().at(1), "a,open,,0,,config,0");
}

// A bank that was cut to its first members, or another one in the same folder.
TEST_F(BankIndexTest, OfOtherBanksOnlyWhatIsDoneIsKept) {
  BankIndex all = index(4);
  EXPECT_TRUE(all.add(0, done(0)));
  EXPECT_TRUE(all.add(3, done(3)));
  all.write();
  BankIndex first = index(1);
  first.write();
  EXPECT_THAT(lines(), ElementsAre(columns, "a,done", "d,done"));
  EXPECT_THAT(text("index.json"), Not(HasSubstr("begun")));
  EXPECT_EQ(index(4).num_done(), 2);
}

}  // namespace
}  // namespace noiseloom
