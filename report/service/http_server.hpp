#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "report/service/http_message.hpp"

namespace carillon::report::service {

struct HttpLimits {
  std::size_t body = 64 << 20;   ///< of a request [bytes]
  double seconds = 30;           ///< a request must have come, or a reply be taken, within
  std::size_t connections = 64;  ///< at once; others wait
  std::size_t listeners = 16;    ///< pages that listen for events at once
};

/// One process that answers HTTP requests, each on a thread of its own, on one address
/// (cpp-httplib). A request that takes longer to come than the limit is dropped, however little is
/// missing.
class HttpServer {
 public:
  /// Makes the reply to a request; what it throws is told as guarded() tells it.
  using Answer = std::function<HttpReply(const HttpRequest& request)>;

  explicit HttpServer(const HttpLimits& limits);
  ~HttpServer();
  HttpServer(const HttpServer&) = delete;
  HttpServer& operator=(const HttpServer&) = delete;

  /// @param pattern  of the whole path, a regular expression (ECMAScript)
  void get(const std::string& pattern, Answer answer);
  void post(const std::string& pattern, Answer answer);
  void remove(const std::string& pattern, Answer answer);  ///< DELETE
  /// Asked before anything of a body is read; what it replies is the reply.
  void guard(std::function<std::optional<HttpReply>(const HttpRequest& request)> check);

  /// @param port  0: any that is free
  /// @return the port
  /// @throws InputError  the address cannot be listened at
  int bind(const std::string& host, int port);
  /// Answers until stop(), then ends what is under way.
  void listen();
  /// From any thread.
  void stop();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace carillon::report::service
