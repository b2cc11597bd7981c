// The connections over which ranks tell each other that they live: one from every rank to rank 0, by TCP, apart from
// MPI, whose calls block as soon as one rank does not take part. Used by the watchdog's threads.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace noiseloom {

// A descriptor that closes itself.
class Socket {
 public:
  Socket() = default;
  explicit Socket(int fd) : fd_(fd) {}
  ~Socket();
  Socket(Socket&& other) noexcept;
  Socket& operator=(Socket&& other) noexcept;
  int fd() const { return fd_; }
  bool is_open() const { return fd_ >= 0; }

 private:
  int fd_ = -1;
};

// What travels, from a rank to rank 0 and back: always whole records.
struct Beat {
  std::uint64_t token = 0;  // of this run: nobody else's connection is listened to
  std::uint64_t steps = 0;
  std::int32_t rank = 0;
  std::int32_t other = -1;
  std::uint32_t kind = 0;
  std::uint32_t is_last = 0;  // the rank ends properly
  std::int64_t pid = 0;
  std::array<char, 64> words{};
  std::array<char, 64> host{};
};

// Where rank 0 listens.
class BeatListener {
 public:
  // Throws EnvironmentError.
  BeatListener();
  int fd() const { return socket_.fd(); }
  // For connect_beats, on any node: "PORT HOST ADDRESS ADDRESS...".
  std::string address() const;
  Socket accept_one() const;  // not open where nobody waits

 private:
  Socket socket_;
  int port_ = 0;
};

// Connects to rank 0, greets it with `own` and gets its answer; not open where none of its addresses answers with its
// token in `patience_ms`.
Socket connect_beats(const std::string& address, const Beat& own, int patience_ms, Beat& answer);

// False where the other end is gone. What does not fit into the connection now is dropped: there will be another.
bool send_beat(const Socket& socket, const Beat& beat);

// Collects the bytes of one connection into records.
class BeatReader {
 public:
  // The newest whole record that has arrived, if any. `is_gone` is set where the other end is.
  std::optional<Beat> read(const Socket& socket, bool& is_gone);

 private:
  std::array<char, sizeof(Beat)> bytes_{};
  std::size_t size_ = 0;
};

}  // namespace noiseloom
