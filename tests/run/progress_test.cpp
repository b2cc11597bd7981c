#include "noiseloom/run/progress.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <limits>

#include "noiseloom/core/error.h"

namespace noiseloom {
namespace {

// What a progress of this kind prints while `body` uses it.
template <class Body>
std::string printed(ProgressKind kind, const Body& body) {
  std::array<int, 2> pipe{};
  EXPECT_EQ(::pipe(pipe.data()), 0);
  Progress progress(kind, pipe[1]);
  body(progress);
  ::close(pipe[1]);
  std::string text;
  std::array<char, 256> piece{};
  for (ssize_t size = 0; (size = ::read(pipe[0], piece.data(), piece.size())) > 0;) {
    text.append(piece.data(), static_cast<std::size_t>(size));
  }
  ::close(pipe[0]);
  return text;
}

ProgressFigures half_way() { return {0.5, "of the bar", "half way", {{"half", std::int64_t{1}}}, 90}; }

TEST(Progress, EachKindSaysWhatItPromises) {
  const auto all = [](Progress& progress) {
    progress.update(1, 0, half_way);
    progress.say("said");
    progress.warn("warned");
    progress.conclude("concluded");
  };
  EXPECT_EQ(printed(ProgressKind::plain, all),
            "half way, 1 min 30 s left (by the pace so far)\nsaid\nWARNING: warned\nconcluded\n");
  EXPECT_EQ(
      printed(ProgressKind::json, all),
      "{\"event\": \"progress\", \"half\": 1, \"seconds_left\": 90}\n{\"event\": \"message\", \"message\": \"said\"}\n"
      "{\"event\": \"warning\", \"message\": \"WARNING: warned\"}\n"
      "{\"event\": \"stopped\", \"message\": \"concluded\"}\n");
  EXPECT_EQ(printed(ProgressKind::none, all), "WARNING: warned\nconcluded\n");
  EXPECT_EQ(printed(ProgressKind::quiet, all), "WARNING: warned\n");
  EXPECT_EQ(printed(ProgressKind::silent, all), "");
}

TEST(Progress, JsonHasNoNumberThatIsNone) {
  const auto without_numbers = [](Progress& progress) {
    progress.update(1, 0, [] {
      const double none = std::numeric_limits<double>::quiet_NaN();
      const double endless = std::numeric_limits<double>::infinity();
      return ProgressFigures{0.5, "", "", {{"rate", endless}, {"R", none}}, endless};
    });
  };
  EXPECT_EQ(printed(ProgressKind::json, without_numbers),
            "{\"event\": \"progress\", \"rate\": null, \"R\": null, \"seconds_left\": null}\n");
}

TEST(Progress, ALineClosesTheBarFirst) {
  const std::string text = printed(ProgressKind::bar, [](Progress& progress) {
    progress.update(1, 0, half_way);
    progress.warn("warned");
  });
  EXPECT_EQ(text, "\r\x1b[K[############............]  50 %  of the bar  1 min 30 s left\nWARNING: warned\n");
}

TEST(Progress, JsonShowsEveryRowAndOthersWait) {
  const auto three_rows = [](Progress& progress) {
    for (std::size_t row = 1; row <= 3; ++row) progress.update(row, 0.01 * static_cast<double>(row), half_way);
  };
  const auto lines = [](const std::string& text) { return std::count(text.begin(), text.end(), '\n'); };
  EXPECT_EQ(lines(printed(ProgressKind::json, three_rows)), 3);
  EXPECT_EQ(lines(printed(ProgressKind::plain, three_rows)), 1);
}

TEST(Progress, UnknownWordsAreRefused) {
  EXPECT_EQ(progress_kind("json"), ProgressKind::json);
  EXPECT_THROW(progress_kind("loud"), UserError);
  EXPECT_THROW(progress_kind("silent"), UserError);
}

TEST(Pace, TimeLeftFollowsWhatThisPartDid) {
  Pace pace;
  EXPECT_LT(pace.left_s(0.5, 0), 0);  // resumed half way: nothing is known yet
  EXPECT_DOUBLE_EQ(pace.left_s(0.75, 10), 10);
}

}  // namespace
}  // namespace noiseloom
