#include "report/service/detail/timed_stream.hpp"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>

#include <algorithm>
#include <cerrno>

namespace carillon::report::service {

namespace {

using Clock = std::chrono::steady_clock;

void address_of(int (*ask)(int, sockaddr*, socklen_t*), int socket, std::string& ip, int& port) {
  sockaddr_storage address{};
  socklen_t size = sizeof(address);
  ip.clear();
  port = 0;
  if (ask(socket, reinterpret_cast<sockaddr*>(&address), &size) != 0) return;
  char text[INET6_ADDRSTRLEN] = {};
  if (address.ss_family == AF_INET) {
    const auto* four = reinterpret_cast<const sockaddr_in*>(&address);
    inet_ntop(AF_INET, &four->sin_addr, text, sizeof(text));
    port = ntohs(four->sin_port);
  } else if (address.ss_family == AF_INET6) {
    const auto* six = reinterpret_cast<const sockaddr_in6*>(&address);
    inet_ntop(AF_INET6, &six->sin6_addr, text, sizeof(text));
    port = ntohs(six->sin6_port);
  }
  ip = text;
}

}  // namespace

TimedStream::TimedStream(socket_t socket, double seconds)
    : socket_(socket),
      limit_(std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(seconds))),
      end_(Clock::now() + limit_) {}

bool TimedStream::wait(short events) const {
  for (;;) {
    const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(end_ - Clock::now());
    if (left.count() <= 0) return false;
    pollfd asked{socket_, events, 0};
    const int ready = poll(&asked, 1, static_cast<int>(std::min<long long>(left.count(), 60000)));
    if (ready > 0) return (asked.revents & (events | POLLHUP)) != 0;
    if (ready < 0 && errno != EINTR) return false;
  }
}

bool TimedStream::is_readable() const {
  return begin_ < filled_ || wait(POLLIN);
}

bool TimedStream::is_writable() const {
  return wait(POLLOUT);
}

ssize_t TimedStream::read(char* ptr, std::size_t size) {
  if (begin_ == filled_) {
    if (!wait(POLLIN)) return -1;
    if (size >= buffer_.size()) return recv(socket_, ptr, size, 0);
    const ssize_t came = recv(socket_, buffer_.data(), buffer_.size(), 0);
    if (came <= 0) return came;
    begin_ = 0;
    filled_ = static_cast<std::size_t>(came);
  }
  const std::size_t count = std::min(size, filled_ - begin_);
  std::copy_n(buffer_.begin() + static_cast<std::ptrdiff_t>(begin_), count, ptr);
  begin_ += count;
  return static_cast<ssize_t>(count);
}

ssize_t TimedStream::write(const char* ptr, std::size_t size) {
  // What was computed for it may have taken long: the time to take it counts from its begin.
  if (!replies_) begin_reply();
  replies_ = true;
  if (!wait(POLLOUT)) return -1;
  return send(socket_, ptr, size, MSG_NOSIGNAL);
}

void TimedStream::get_remote_ip_and_port(std::string& ip, int& port) const {
  address_of(getpeername, socket_, ip, port);
}

void TimedStream::get_local_ip_and_port(std::string& ip, int& port) const {
  address_of(getsockname, socket_, ip, port);
}

}  // namespace carillon::report::service
