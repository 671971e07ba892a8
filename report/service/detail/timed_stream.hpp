#pragma once

#include <array>
#include <chrono>

#include "report/service/detail/httplib.hpp"

namespace carillon::report::service {

/// A connection on which one request must have come, and one reply have gone, within a limit: a
/// client that sends a byte a second holds no thread for longer.
class TimedStream final : public httplib::Stream {
 public:
  TimedStream(socket_t socket, double seconds);

  bool is_readable() const override;
  bool is_writable() const override;
  ssize_t read(char* ptr, std::size_t size) override;
  ssize_t write(const char* ptr, std::size_t size) override;
  void get_remote_ip_and_port(std::string& ip, int& port) const override;
  void get_local_ip_and_port(std::string& ip, int& port) const override;
  socket_t socket() const override { return socket_; }
  using Stream::write;

  /// The reply begins, or an event of it: the time counts anew.
  void begin_reply() { end_ = std::chrono::steady_clock::now() + limit_; }

 private:
  bool wait(short events) const;

  socket_t socket_;
  std::chrono::steady_clock::duration limit_;
  std::chrono::steady_clock::time_point end_;
  bool replies_ = false;
  /// What came and was not asked for yet: lines are read byte by byte.
  std::array<char, 4096> buffer_{};
  std::size_t begin_ = 0, filled_ = 0;
};

}  // namespace carillon::report::service
