// What runs short is named, and nothing else is taken for a shortage.
#include "run/jobs/memory_words.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <thread>

namespace noiseloom {
namespace {

using testing::AllOf;
using testing::HasSubstr;

// What comes out where `failure` is thrown inside: "environment: ..." or "as it was".
template <class Failure>
std::string thrown_for(const Failure& failure) {
  try {
    naming_shortage("weaving", [&] { throw failure; });
  } catch (const EnvironmentError& error) {
    return std::string("environment: ") + error.what();
  } catch (const Failure&) {
    return "as it was";
  }
  return "nothing";
}

std::system_error failure_of(std::errc code) { return std::system_error(std::make_error_code(code)); }

TEST(NamingShortage, SaysWhatMemoryRanOutFor) {
  const auto words = AllOf(HasSubstr("environment: out of memory while weaving"), HasSubstr("noiseloom plan"));
  EXPECT_THAT(thrown_for(std::bad_alloc()), words);
  EXPECT_THAT(thrown_for(failure_of(std::errc::not_enough_memory)), words);
}

TEST(NamingShortage, SaysThatThereIsNoThreadLeft) {
  EXPECT_THAT(thrown_for(failure_of(std::errc::resource_unavailable_try_again)),
              AllOf(HasSubstr("environment: while weaving: "), HasSubstr("--threads")));
}

TEST(NamingShortage, TakesNoFailureOfAnotherKindForAShortage) {
  EXPECT_EQ(thrown_for(failure_of(std::errc::permission_denied)), "as it was");
  EXPECT_EQ(thrown_for(failure_of(std::errc::no_space_on_device)), "as it was");
  EXPECT_EQ(thrown_for(std::filesystem::filesystem_error("a.h5", std::make_error_code(std::errc::io_error))),
            "as it was");
}

}  // namespace
}  // namespace noiseloom
