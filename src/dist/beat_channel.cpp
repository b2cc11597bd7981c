#include "dist/beat_channel.h"

#include <arpa/inet.h>
#include <fcntl.h>
#include <ifaddrs.h>
#include <net/if.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <sstream>
#include <system_error>
#include <type_traits>
#include <utility>

#include "noiseloom/core/error.h"

namespace noiseloom {
namespace {

static_assert(std::is_trivially_copyable_v<Beat>);

std::string this_host() {
  std::array<char, 256> host{};
  ::gethostname(host.data(), host.size() - 1);
  return host.data();
}

// The IPv4 addresses of this machine that others may reach, then the one that itself alone can.
std::vector<std::string> own_addresses() {
  std::vector<std::string> addresses;
  ifaddrs* all = nullptr;
  if (::getifaddrs(&all) != 0) return {"127.0.0.1"};
  for (const ifaddrs* one = all; one != nullptr; one = one->ifa_next) {
    if (one->ifa_addr == nullptr || one->ifa_addr->sa_family != AF_INET) continue;
    if ((one->ifa_flags & IFF_UP) == 0 || (one->ifa_flags & IFF_LOOPBACK) != 0) continue;
    sockaddr_in address{};
    std::memcpy(&address, one->ifa_addr, sizeof address);
    std::array<char, INET_ADDRSTRLEN> text{};
    if (::inet_ntop(AF_INET, &address.sin_addr, text.data(), text.size()) != nullptr) {
      addresses.emplace_back(text.data());
    }
  }
  ::freeifaddrs(all);
  addresses.emplace_back("127.0.0.1");
  return addresses;
}

bool wait_for(const Socket& socket, short events, int patience_ms) {
  pollfd entry{socket.fd(), events, 0};
  return ::poll(&entry, 1, patience_ms) == 1;
}

Socket connect_to(const std::string& address, int port, int patience_ms) {
  Socket socket(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  sockaddr_in to{};
  to.sin_family = AF_INET;
  to.sin_port = htons(static_cast<std::uint16_t>(port));
  if (!socket.is_open() || ::inet_pton(AF_INET, address.c_str(), &to.sin_addr) != 1) return {};
  if (::connect(socket.fd(), reinterpret_cast<const sockaddr*>(&to), sizeof to) != 0) {
    if (errno != EINPROGRESS || !wait_for(socket, POLLOUT, patience_ms)) return {};
    int error = 0;
    socklen_t size = sizeof error;
    if (::getsockopt(socket.fd(), SOL_SOCKET, SO_ERROR, &error, &size) != 0 || error != 0) return {};
  }
  return socket;
}

}  // namespace

Socket::~Socket() {
  if (fd_ >= 0) ::close(fd_);
}
Socket::Socket(Socket&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {}
Socket& Socket::operator=(Socket&& other) noexcept {
  std::swap(fd_, other.fd_);
  return *this;
}

BeatListener::BeatListener() : socket_(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0)) {
  sockaddr_in any{};
  any.sin_family = AF_INET;
  any.sin_addr.s_addr = htonl(INADDR_ANY);
  socklen_t size = sizeof any;
  constexpr int most_waiting = 1024;
  if (!socket_.is_open() || ::bind(socket_.fd(), reinterpret_cast<const sockaddr*>(&any), size) != 0 ||
      ::listen(socket_.fd(), most_waiting) != 0 ||
      ::getsockname(socket_.fd(), reinterpret_cast<sockaddr*>(&any), &size) != 0) {
    throw EnvironmentError("cannot listen for other ranks: " + std::system_category().message(errno));
  }
  port_ = ntohs(any.sin_port);
}

std::string BeatListener::address() const {
  std::string text = std::to_string(port_) + " " + this_host();
  for (const std::string& address : own_addresses()) text += " " + address;
  return text;
}

Socket BeatListener::accept_one() const {
  return Socket(::accept4(socket_.fd(), nullptr, nullptr, SOCK_CLOEXEC | SOCK_NONBLOCK));
}

Socket connect_beats(const std::string& address, const Beat& own, int patience_ms, Beat& answer) {
  std::istringstream words(address);
  int port = 0;
  std::string host;
  words >> port >> host;
  std::vector<std::string> addresses;
  for (std::string one; words >> one;) addresses.push_back(one);
  if (host == this_host()) std::swap(addresses.front(), addresses.back());
  for (const std::string& one : addresses) {
    Socket socket = connect_to(one, port, patience_ms);
    if (!socket.is_open() || !send_beat(socket, own)) continue;
    BeatReader reader;
    bool is_gone = false;
    while (!is_gone && wait_for(socket, POLLIN, patience_ms)) {
      const std::optional<Beat> heard = reader.read(socket, is_gone);
      if (!heard) continue;
      if (heard->token != own.token) break;
      answer = *heard;
      return socket;
    }
  }
  return {};
}

bool send_beat(const Socket& socket, const Beat& beat) {
  const ssize_t sent = ::send(socket.fd(), &beat, sizeof beat, MSG_DONTWAIT | MSG_NOSIGNAL);
  if (sent < 0) return errno == EAGAIN || errno == EWOULDBLOCK || errno == EINTR;
  // A record of a few hundred bytes goes as a whole or the connection is stuffed, and of no further use.
  return sent == static_cast<ssize_t>(sizeof beat);
}

std::optional<Beat> BeatReader::read(const Socket& socket, bool& is_gone) {
  std::optional<Beat> newest;
  for (;;) {
    const ssize_t got = ::recv(socket.fd(), bytes_.data() + size_, bytes_.size() - size_, MSG_DONTWAIT);
    if (got == 0) is_gone = true;
    if (got < 0 && errno != EAGAIN && errno != EWOULDBLOCK && errno != EINTR) is_gone = true;
    if (got <= 0) return newest;
    size_ += static_cast<std::size_t>(got);
    if (size_ < bytes_.size()) continue;
    newest.emplace();
    std::memcpy(&*newest, bytes_.data(), sizeof(Beat));
    size_ = 0;
  }
}

}  // namespace noiseloom
