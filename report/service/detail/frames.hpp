#pragma once

#include <optional>
#include <string>

#include "report/service/http_message.hpp"

namespace carillon::report::service {

/// Requests and replies on a stream between two processes: a line of JSON, then the bytes that it
/// announces.
///
///   {"path", "query": {}, "parts": [[name, bytes]...]}   the body is the part without a name
///   {"status", "type", "bytes"}
class Frames {
 public:
  /// Descriptors stay open.
  Frames(int input, int output) : input_(input), output_(output) {}

  void send(const HttpRequest& request);
  void send(const HttpReply& reply);
  /// What comes next; nothing at the end of the stream.
  /// @throws InputError  a line that is no frame's
  std::optional<HttpRequest> next_request();
  /// @param seconds  it must have come within; 0: without a limit
  /// @throws FileError  it has not, or the stream has ended
  HttpReply reply(double seconds);
  /// Nothing reads what is sent any more, or the sender has gone.
  bool broken() const { return broken_; }

 private:
  bool fill();
  std::optional<std::string> line();
  bool bytes(std::size_t count, std::string& into);
  void write(const std::string& bytes);

  int input_, output_;
  std::string buffer_;  ///< read, and not taken yet
  double deadline_ = 0;
  bool late_ = false, broken_ = false;
};

}  // namespace carillon::report::service
