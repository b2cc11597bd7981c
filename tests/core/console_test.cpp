#include "noiseloom/core/console.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <string>
#include <thread>

namespace noiseloom {
namespace {

TEST(WriteText, SaysWhyItCouldNot) {
  const int full = ::open("/dev/full", O_WRONLY);
  EXPECT_EQ(write_text(full, "text"), ENOSPC);
  EXPECT_EQ(write_text(full, ""), 0);
  ::close(full);
  EXPECT_EQ(write_text(full, "text"), EBADF);
  ::signal(SIGPIPE, SIG_IGN);
  std::array<int, 2> pipe{};
  ASSERT_EQ(::pipe(pipe.data()), 0);
  ::close(pipe[0]);
  EXPECT_EQ(write_text(pipe[1], "text"), EPIPE);
  ::close(pipe[1]);
}

TEST(WriteText, WritesAllEvenIntoAPipeThatDoesNotBlock) {
  std::array<int, 2> pipe{};
  ASSERT_EQ(::pipe2(pipe.data(), O_NONBLOCK), 0);
  const std::string text(1 << 20, 'x');  // more than a pipe holds
  std::size_t received = 0;
  std::thread reader([&] {
    std::array<char, 4096> piece{};
    while (received < text.size()) {
      const ssize_t size = ::read(pipe[0], piece.data(), piece.size());
      if (size > 0) received += static_cast<std::size_t>(size);
    }
  });
  EXPECT_EQ(write_text(pipe[1], text), 0);
  reader.join();
  EXPECT_EQ(received, text.size());
  for (const int end : pipe) ::close(end);
}

}  // namespace
}  // namespace noiseloom
