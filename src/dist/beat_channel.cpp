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

#include <algorithm>
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

// An address of either kind; a text that is none has no length.
struct Address {
  sockaddr_storage storage{};
  socklen_t size = 0;

  const sockaddr* get() const { return reinterpret_cast<const sockaddr*>(&storage); }
  sockaddr* get() { return reinterpret_cast<sockaddr*>(&storage); }
  int family() const { return storage.ss_family; }
};

Address parse_address(const std::string& text, int port) {
  Address address;
  sockaddr_in v4{};
  sockaddr_in6 v6{};
  v4.sin_family = AF_INET;
  v6.sin6_family = AF_INET6;
  v4.sin_port = v6.sin6_port = htons(static_cast<std::uint16_t>(port));
  if (::inet_pton(AF_INET, text.c_str(), &v4.sin_addr) == 1) {
    std::memcpy(&address.storage, &v4, sizeof v4);
    address.size = sizeof v4;
  } else if (::inet_pton(AF_INET6, text.c_str(), &v6.sin6_addr) == 1) {
    std::memcpy(&address.storage, &v6, sizeof v6);
    address.size = sizeof v6;
  }
  return address;
}

// "" for what no other machine could use: other kinds, and addresses that hold on one link alone.
std::string address_text(const sockaddr* address) {
  std::array<char, INET6_ADDRSTRLEN> text{};
  const char* found = nullptr;
  if (address->sa_family == AF_INET) {
    sockaddr_in v4{};
    std::memcpy(&v4, address, sizeof v4);
    found = ::inet_ntop(AF_INET, &v4.sin_addr, text.data(), text.size());
  } else if (address->sa_family == AF_INET6) {
    sockaddr_in6 v6{};
    std::memcpy(&v6, address, sizeof v6);
    if (!IN6_IS_ADDR_LINKLOCAL(&v6.sin6_addr)) found = ::inet_ntop(AF_INET6, &v6.sin6_addr, text.data(), text.size());
  }
  return found != nullptr ? found : "";
}

// The addresses of this machine that others may reach, then those that itself alone can.
std::vector<std::string> own_addresses() {
  std::vector<std::string> addresses;
  ifaddrs* all = nullptr;
  if (::getifaddrs(&all) != 0) return {"::1", "127.0.0.1"};
  for (const ifaddrs* one = all; one != nullptr; one = one->ifa_next) {
    if (one->ifa_addr == nullptr || (one->ifa_flags & IFF_UP) == 0 || (one->ifa_flags & IFF_LOOPBACK) != 0) continue;
    if (std::string text = address_text(one->ifa_addr); !text.empty()) addresses.push_back(std::move(text));
  }
  ::freeifaddrs(all);
  addresses.emplace_back("::1");
  addresses.emplace_back("127.0.0.1");
  return addresses;
}

bool wait_for(const Socket& socket, short events, int patience_ms) {
  pollfd entry{socket.fd(), events, 0};
  return ::poll(&entry, 1, patience_ms) == 1;
}

Socket connect_to(const std::string& address, int port, int patience_ms) {
  const Address to = parse_address(address, port);
  if (to.size == 0) return {};
  Socket socket(::socket(to.family(), SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  if (!socket.is_open()) return {};
  if (::connect(socket.fd(), to.get(), to.size) != 0) {
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

// For both kinds of addresses, where this machine knows both.
BeatListener::BeatListener() {
  int error = 0;
  for (const char* any : {"::", "0.0.0.0"}) {
    constexpr int most_waiting = 1024;
    const int no = 0;
    Address address = parse_address(any, 0);
    socket_ = Socket(::socket(address.family(), SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
    if (socket_.is_open() && address.family() == AF_INET6) {
      ::setsockopt(socket_.fd(), IPPROTO_IPV6, IPV6_V6ONLY, &no, sizeof no);
    }
    if (socket_.is_open() && ::bind(socket_.fd(), address.get(), address.size) == 0 &&
        ::listen(socket_.fd(), most_waiting) == 0 && ::getsockname(socket_.fd(), address.get(), &address.size) == 0) {
      sockaddr_in6 v6{};  // the port stands at the same place in both
      std::memcpy(&v6, &address.storage, sizeof v6);
      port_ = ntohs(v6.sin6_port);
      return;
    }
    error = errno;
  }
  throw EnvironmentError("cannot listen for other ranks: " + std::system_category().message(error));
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
  if (host == this_host()) std::reverse(addresses.begin(), addresses.end());
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
