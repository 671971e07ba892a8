#include "report/service/detail/frames.hpp"

#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <nlohmann/json.hpp>

#include "core/error.hpp"
#include "core/trace.hpp"

namespace carillon::report::service {

using nlohmann::ordered_json;

namespace {

constexpr std::size_t longest_line = 1 << 20;

std::string line_of(const ordered_json& header) {
  return header.dump(-1, ' ', false, ordered_json::error_handler_t::replace) + "\n";
}

}  // namespace

/// Waits for more; false where none comes.
bool Frames::fill() {
  for (;;) {
    int milliseconds = -1;
    if (deadline_ > 0) {
      const double left = deadline_ - core::monotonic_seconds();
      if (left <= 0) {
        late_ = true;
        return false;
      }
      milliseconds = static_cast<int>(std::ceil(1000 * std::min(left, 3600.0)));
    }
    pollfd waiting{input_, POLLIN, 0};
    const int ready = poll(&waiting, 1, milliseconds);
    if (ready < 0 && errno != EINTR) return false;
    if (ready <= 0) continue;
    std::array<char, 65536> block;
    const ssize_t got = read(input_, block.data(), block.size());
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) return false;
    buffer_.append(block.data(), static_cast<std::size_t>(got));
    return true;
  }
}

std::optional<std::string> Frames::line() {
  std::size_t end = buffer_.find('\n');
  while (end == std::string::npos) {
    const std::size_t searched = buffer_.size();
    if (searched > longest_line) throw core::InputError("a line is too long to be a request");
    if (!fill()) return std::nullopt;
    end = buffer_.find('\n', searched);
  }
  std::string text = buffer_.substr(0, end);
  buffer_.erase(0, end + 1);
  return text;
}

bool Frames::bytes(std::size_t count, std::string& into) {
  while (buffer_.size() < count) {
    if (!fill()) return false;
  }
  into = buffer_.substr(0, count);
  buffer_.erase(0, count);
  return true;
}

void Frames::write(const std::string& bytes) {
  for (std::size_t done = 0; done < bytes.size() && !broken_;) {
    const ssize_t put = ::write(output_, bytes.data() + done, bytes.size() - done);
    if (put >= 0) {
      done += static_cast<std::size_t>(put);
    } else if (errno != EINTR) {
      broken_ = true;
    }
  }
}

void Frames::send(const HttpRequest& request) {
  ordered_json parts = ordered_json::array();
  std::string payload;
  const auto add = [&](const std::string& name, const std::string& bytes) {
    parts.push_back({name, bytes.size()});
    payload += bytes;
  };
  if (!request.body.empty()) add("", request.body);
  for (const auto& [name, bytes] : request.files) add(name, bytes);
  write(line_of({{"path", request.path}, {"query", request.query}, {"parts", parts}}));
  write(payload);
}

void Frames::send(const HttpReply& reply) {
  write(line_of({{"status", reply.status}, {"type", reply.type}, {"bytes", reply.body.size()}}));
  write(reply.body);
}

std::optional<HttpRequest> Frames::next_request() {
  const std::optional<std::string> text = line();
  if (!text) return std::nullopt;
  HttpRequest request;
  try {
    const ordered_json header = ordered_json::parse(*text);
    request.path = header.at("path");
    request.query = header.value("query", request.query);
    for (const ordered_json& part : header.value("parts", ordered_json::array())) {
      const std::string name = part.at(0);
      if (!bytes(part.at(1), name.empty() ? request.body : request.files[name])) {
        return std::nullopt;
      }
    }
  } catch (const ordered_json::exception&) {
    throw core::InputError(
        "a line is no request",
        R"(as {"path": "/v1/features", "parts": [["", 1000]]}, and then 1000 bytes)");
  }
  return request;
}

HttpReply Frames::reply(double seconds) {
  deadline_ = seconds > 0 ? core::monotonic_seconds() + seconds : 0;
  late_ = false;
  HttpReply reply;
  try {
    const std::optional<std::string> text = line();
    if (text) {
      const ordered_json header = ordered_json::parse(*text);
      reply.status = header.at("status");
      reply.type = header.at("type");
      if (bytes(header.at("bytes"), reply.body)) return reply;
    }
  } catch (const std::exception& error) {
    broken_ = true;
    throw core::FileError(std::string("its answer cannot be read: ") + error.what());
  }
  broken_ = true;
  throw core::FileError(late_ ? "no answer in time" : "it has ended");
}

}  // namespace carillon::report::service
