#include "report/service/http_server.hpp"

#include <fmt/format.h>
#include <poll.h>
#include <spdlog/spdlog.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cctype>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <set>
#include <thread>
#include <utility>

#include "core/error.hpp"
#include "core/files.hpp"
#include "report/service/detail/timed_stream.hpp"

namespace carillon::report::service {

namespace {

/// Longer paths are of no page, and regular expressions are not asked about them.
constexpr std::size_t longest_path = 512;
constexpr double keep_alive_seconds = 5;
constexpr int requests_of_a_connection = 1000;
constexpr std::size_t max_files = 16;

/// The connection whose request this thread answers.
thread_local TimedStream* current_stream = nullptr;

std::string lower(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

/// `a=1&b=x=2`, of which the library would take the last sign for the one between name and value.
std::map<std::string, std::string> query_of(const std::string& target) {
  std::map<std::string, std::string> query;
  std::size_t begin = target.find('?');
  while (begin != std::string::npos) {
    const std::size_t end = target.find('&', ++begin);
    const std::string pair = target.substr(begin, end - begin);
    const std::size_t sign = std::min(pair.find('='), pair.size());
    const auto plain = [](const std::string& text) {
      return httplib::detail::decode_url(text, /*convert_plus_to_space=*/true);
    };
    if (!pair.empty()) {
      query.emplace(plain(pair.substr(0, sign)),
                    sign < pair.size() ? plain(pair.substr(sign + 1)) : "");
    }
    begin = end;
  }
  return query;
}

void fill_in(HttpRequest& own, const httplib::Request& request) {
  own.path = request.path;
  own.query = query_of(request.target);
  for (const auto& [name, value] : request.headers) own.header.emplace(lower(name), value);
}

/// As many threads as connections; no more are accepted, so that descriptors are left for others.
class Connections final : public httplib::TaskQueue {
 public:
  explicit Connections(std::size_t count) : pool_(count), free_(count) {}
  void enqueue(std::function<void()> task) override {
    {
      std::unique_lock lock(mutex_);
      left_.wait(lock, [this] { return free_ > 0; });
      --free_;
    }
    pool_.enqueue([this, task = std::move(task)] {
      task();
      {
        const std::lock_guard lock(mutex_);
        ++free_;
      }
      left_.notify_one();
    });
  }
  void shutdown() override { pool_.shutdown(); }

 private:
  httplib::ThreadPool pool_;
  std::mutex mutex_;
  std::condition_variable left_;
  std::size_t free_;
};

/// The library's server, on connections with limits.
class TimedServer final : public httplib::Server {
 public:
  explicit TimedServer(double seconds) : seconds_(seconds) {}

  /// The request that this thread answers has come as a whole.
  void has_come(socket_t socket) {
    const std::lock_guard lock(mutex_);
    awaited_.erase(socket);
  }
  /// Clients that have not sent their request yet are not waited for.
  void stop_waiting() {
    const std::lock_guard lock(mutex_);
    stopped_ = true;
    for (const socket_t socket : awaited_) ::shutdown(socket, SHUT_RD);
  }

 private:
  /// The next request is waited for.
  void await(socket_t socket) {
    const std::lock_guard lock(mutex_);
    awaited_.insert(socket);
    if (stopped_) ::shutdown(socket, SHUT_RD);
  }

  bool process_and_close_socket(socket_t socket) override {
    bool closed = false;
    for (int left = requests_of_a_connection; left > 0 && !closed; --left) {
      await(socket);
      // The first request has the whole limit, others first have to begin.
      if (left < requests_of_a_connection &&
          (svr_sock_ == INVALID_SOCKET || !TimedStream(socket, keep_alive_seconds).is_readable())) {
        break;
      }
      TimedStream stream(socket, seconds_);
      current_stream = &stream;
      const bool answered = process_request(stream, left == 1, closed, nullptr);
      current_stream = nullptr;
      if (!answered) break;
    }
    has_come(socket);
    let_read(socket);
    ::close(socket);
    return true;
  }

  /// A client that was refused before all of its request had come still sends, and would lose the
  /// reply to a connection that is closed at once.
  static void let_read(socket_t socket) {
    constexpr int patience_ms = 500;
    const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(2);
    ::shutdown(socket, SHUT_WR);
    std::array<char, 65536> rest;
    while (std::chrono::steady_clock::now() < end) {
      pollfd waiting{socket, POLLIN, 0};
      if (::poll(&waiting, 1, patience_ms) <= 0) return;
      if (::recv(socket, rest.data(), rest.size(), 0) <= 0) return;
    }
  }

  double seconds_;
  std::mutex mutex_;
  std::set<socket_t> awaited_;
  bool stopped_ = false;
};

}  // namespace

struct HttpServer::State {
  explicit State(const HttpLimits& given) : limits(given), server(given.seconds) {}

  void answer(const httplib::Request& request, httplib::Response& response,
              const HttpServer::Answer& make, HttpRequest own) {
    if (current_stream != nullptr) server.has_come(current_stream->socket());
    fill_in(own, request);
    put(guarded(own.path, [&] { return make(own); }), response);
  }

  void put(HttpReply reply, httplib::Response& response) {
    response.status = reply.status;
    response.set_header("X-Content-Type-Options", "nosniff");
    if (!reply.events) {
      response.set_content(reply.body, reply.type);
      return;
    }
    if (++listeners > limits.listeners) {
      --listeners;
      put(error_reply(503, "too many pages listen already"), response);
      return;
    }
    response.set_header("Cache-Control", "no-store");
    const auto next = std::make_shared<NextEvent>(std::move(reply.events));
    response.set_chunked_content_provider(
        "text/event-stream",
        [this, next](std::size_t, httplib::DataSink& sink) {
          if (stopping) {
            sink.done();
            return true;
          }
          // A comment line where nothing is new tells whether anybody is there.
          const std::optional<std::string> event = (*next)();
          const std::string text = event ? fmt::format("data: {}\n\n", *event) : ":\n\n";
          if (current_stream != nullptr) current_stream->begin_reply();
          if (!sink.write(text.data(), text.size())) return false;
          std::unique_lock lock(mutex);
          stop_asked.wait_for(lock, std::chrono::seconds(1), [this] { return stopping.load(); });
          return true;
        },
        [this](bool) { --listeners; });
  }

  HttpLimits limits;
  TimedServer server;
  std::function<std::optional<HttpReply>(const HttpRequest&)> check;
  std::atomic<bool> stopping = false;
  std::atomic<std::size_t> listeners = 0;
  std::mutex mutex;
  std::condition_variable stop_asked;
};

HttpServer::HttpServer(const HttpLimits& limits) : state_(std::make_unique<State>(limits)) {
  TimedServer& server = state_->server;
  server.set_payload_max_length(limits.body);
  server.new_task_queue = [limits] { return new Connections(limits.connections); };
  server.set_tcp_nodelay(true);
  server.set_pre_routing_handler(
      [this](const httplib::Request& request, httplib::Response& response) {
        std::optional<HttpReply> refusal;
        if (request.path.size() > longest_path) refusal = error_reply(414, "the path is too long");
        // The library would copy a page once for each.
        if (request.ranges.size() > 1) {
          refusal = error_reply(416, "one range of a reply can be asked for, not several");
        }
        if (request.get_header_value<std::uint64_t>("Content-Length") > state_->limits.body) {
          refusal = error_reply(413, "the body is too large", "carillon serve --max-body");
          response.set_header("Connection", "close");
        }
        if (!refusal && state_->check) {
          HttpRequest own;
          fill_in(own, request);
          refusal = state_->check(own);
        }
        if (!refusal) return httplib::Server::HandlerResponse::Unhandled;
        state_->put(std::move(*refusal), response);
        return httplib::Server::HandlerResponse::Handled;
      });
  // What the library itself refuses.
  server.set_error_handler(httplib::Server::HandlerWithResponse(
      [this](const httplib::Request& request, httplib::Response& response) {
        if (!response.body.empty()) return httplib::Server::HandlerResponse::Unhandled;
        const char* why = response.status == 404   ? "there is no such page"
                          : response.status == 413 ? "the body is too large"
                                                   : "the request cannot be read";
        state_->put(error_reply(response.status,
                                fmt::format("{} {}: {}", request.method, request.path, why)),
                    response);
        return httplib::Server::HandlerResponse::Handled;
      }));
}

HttpServer::~HttpServer() = default;

void HttpServer::get(const std::string& pattern, Answer answer) {
  state_->server.Get(pattern, [this, answer = std::move(answer)](const httplib::Request& request,
                                                                 httplib::Response& response) {
    state_->answer(request, response, answer, {});
  });
}

void HttpServer::post(const std::string& pattern, Answer answer) {
  state_->server.Post(pattern, httplib::Server::HandlerWithContentReader(
                                   [this, answer = std::move(answer)](
                                       const httplib::Request& request, httplib::Response& response,
                                       const httplib::ContentReader& read) {
                                     HttpRequest own;
                                     std::string* part = &own.body;
                                     std::size_t bytes = 0;
                                     const auto take = [&](const char* data, std::size_t size) {
                                       bytes += size;
                                       if (bytes > state_->limits.body) return false;
                                       part->append(data, size);
                                       return true;
                                     };
                                     // What the files of a form are called on the client's machine
                                     // means nothing here.
                                     const bool whole =
                                         request.is_multipart_form_data()
                                             ? read(
                                                   [&](const httplib::MultipartFormData& field) {
                                                     part = &own.files[field.name];
                                                     return own.files.size() <= max_files;
                                                   },
                                                   take)
                                             : read(take);
                                     if (!whole) {
                                       // The library has set the status of what it could not read.
                                       if (response.status < 400)
                                         response.status = bytes > state_->limits.body ? 413 : 400;
                                       return;
                                     }
                                     state_->answer(request, response, answer, std::move(own));
                                   }));
}

void HttpServer::remove(const std::string& pattern, Answer answer) {
  state_->server.Delete(pattern, httplib::Server::Handler([this, answer = std::move(answer)](
                                                              const httplib::Request& request,
                                                              httplib::Response& response) {
                          state_->answer(request, response, answer, {});
                        }));
}

void HttpServer::guard(std::function<std::optional<HttpReply>(const HttpRequest&)> check) {
  state_->check = std::move(check);
}

int HttpServer::bind(const std::string& host, int port) {
  const int bound = port == 0 ? state_->server.bind_to_any_port(host)
                              : (state_->server.bind_to_port(host, port) ? port : -1);
  if (bound < 0) {
    throw core::InputError(fmt::format("{}:{} cannot be listened at", host, port),
                           "another program may have the port: --port 0 takes any that is free");
  }
  return bound;
}

void HttpServer::listen() {
  state_->server.listen_after_bind();
}

void HttpServer::stop() {
  {
    const std::lock_guard lock(state_->mutex);
    state_->stopping = true;
  }
  state_->stop_asked.notify_all();
  state_->server.stop_waiting();
  state_->server.stop();
}

}  // namespace carillon::report::service
