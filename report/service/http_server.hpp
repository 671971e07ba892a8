#pragma once

#include <cstddef>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>

namespace carillon::report::service {

struct HttpRequest {
  std::string path;                           ///< as it came, without its query
  std::map<std::string, std::string> query;   ///< of names that stand twice the first
  std::map<std::string, std::string> header;  ///< by names in lower case, likewise
  std::string body;
  std::map<std::string, std::string> files;  ///< of a form, by the names of its fields
};

/// Events for a page that listens (WHATWG HTML, server-sent events): the next one's text, or
/// nothing where there is none yet; asked for once a second.
using NextEvent = std::function<std::optional<std::string>()>;

struct HttpReply {
  int status = 200;
  std::string type = "application/json";
  std::string body;
  NextEvent events{};  ///< in place of the body, until the client goes away
};

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
  /// Makes the reply to a request. What it throws is told as JSON: of an InputError or ConfigError
  /// the message and hint with status 400, of a FileError with 404, of others 500.
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

/// {"error": {"message", "hint"}}
HttpReply error_reply(int status, const std::string& message, const std::string& hint = "");

}  // namespace carillon::report::service
