// The connections of the watchdog, over both kinds of addresses.
#include "dist/beat_channel.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <thread>

namespace noiseloom {
namespace {

// What a rank hears that is told this address of rank 0, which answers once.
int rank_that_answers(const std::string& address, const BeatListener& listener, int patience_ms) {
  std::thread root([&] {
    for (int tries = 0; tries < 1000; ++tries) {
      const Socket one = listener.accept_one();
      Beat beat;
      beat.token = 7;
      beat.rank = 5;
      if (one.is_open()) {
        send_beat(one, beat);
        std::this_thread::sleep_for(std::chrono::milliseconds(50));
        return;
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
  });
  Beat own;
  own.token = 7;
  Beat answer;
  const Socket to_root = connect_beats(address, own, patience_ms, answer);
  root.join();
  return to_root.is_open() ? answer.rank : -1;
}

TEST(BeatChannel, IsReachedByBothKindsOfAddresses) {
  const BeatListener listener;
  const std::string port = listener.address().substr(0, listener.address().find(' '));
  for (const std::string loopback : {"127.0.0.1", "::1"}) {
    const std::string known = listener.address();
    EXPECT_THAT(known, testing::HasSubstr(" " + loopback));
    const int answer = rank_that_answers(port + " elsewhere none:such 127.0.0 " + loopback, listener, 500);
    if (answer < 0 && loopback == "::1") GTEST_SKIP() << "this machine has no address of IPv6";
    EXPECT_EQ(answer, 5) << loopback;
  }
}

TEST(BeatChannel, AStrangersAnswerIsNone) {
  const BeatListener listener;
  Beat own;
  own.token = 8;
  Beat answer;
  EXPECT_FALSE(connect_beats(listener.address(), own, 20, answer).is_open());
}

}  // namespace
}  // namespace noiseloom
