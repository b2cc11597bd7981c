#include "noiseloom/core/apart.h"

#include <gtest/gtest.h>

#include <csignal>
#include <stdexcept>
#include <vector>

#include "support/sanitizers.h"

namespace noiseloom {
namespace {

TEST(Apart, WhatIsReturnedComesBackAndNothingElse) {
  int seen = 0;
  std::string bytes(3'000'000, 'x');
  bytes[1'000'000] = '\0';
  const ApartResult result = run_apart([&] {
    seen = 1;
    return bytes;
  });
  EXPECT_TRUE(result.is_whole);
  EXPECT_EQ(result.bytes, bytes);
  EXPECT_EQ(seen, 0);
  EXPECT_TRUE(run_apart([] { return std::string(); }).is_whole);
}

TEST(Apart, ACrashIsToldAndLeavesThisProcessAlone) {
  const ApartResult crashed = run_apart([]() -> std::string {
    ::raise(SIGKILL);
    return "not reached";
  });
  EXPECT_FALSE(crashed.is_whole);
  EXPECT_EQ(crashed.signal, SIGKILL);
  const ApartResult threw = run_apart([]() -> std::string { throw std::runtime_error("no"); });
  EXPECT_FALSE(threw.is_whole);
  EXPECT_EQ(threw.signal, 0);
}

TEST(Apart, MemoryIsBounded) {
  if (testing_support::under_sanitizers) GTEST_SKIP() << "where memory is refused, sanitizers end the program";
  const auto take = [] { return std::string(std::vector<char>(400'000'000, 'y').data(), 1); };
  EXPECT_FALSE(run_apart(take, 100'000'000).is_whole);
  EXPECT_TRUE(run_apart(take, 900'000'000).is_whole);
}

}  // namespace
}  // namespace noiseloom
