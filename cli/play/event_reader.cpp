#include "cli/play/event_reader.hpp"

#include <poll.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>

#include "cli/play/interrupt.hpp"
#include "core/error.hpp"

namespace carillon::cli::play {

namespace {

/// Events are prepared so long before they are due [s].
constexpr double lookahead = 1;
/// A line that is longer is no line of events.
constexpr std::size_t longest_line = 4096;

}  // namespace

EventReader::EventReader(int stream, std::string name, Apply apply)
    : stream_(stream), name_(std::move(name)), apply_(std::move(apply)) {
  thread_ = thread_without_signals([this] { read(); });
}

EventReader::~EventReader() {
  {
    const std::lock_guard lock(mutex_);
    leave_ = true;
  }
  moved_.notify_all();
  thread_.join();
}

void EventReader::played(double time) {
  {
    const std::lock_guard lock(mutex_);
    played_ = time;
  }
  moved_.notify_all();
}

bool EventReader::wait_for(double time, double longest) {
  std::unique_lock lock(mutex_);
  return moved_.wait_for(lock, std::chrono::duration<double>(longest),
                         [&] { return ended_ || read_ >= time; });
}

void EventReader::take(std::string_view line) {
  ++lines_;
  try {
    if (line.size() > longest_line) throw core::InputError("the line is too long");
    const auto request = scene::live::parse_request(line);
    if (!request) return;
    if (request->time) {
      std::unique_lock lock(mutex_);
      read_ = std::max(read_, *request->time);
      moved_.notify_all();
      moved_.wait(lock, [&] { return leave_ || played_ >= *request->time - lookahead; });
    }
    if (!leave_) apply_(*request);
  } catch (const core::Error& error) {
    ++refused_;
    spdlog::warn("{}:{}: {}{}", name_, lines_, error.message(),
                 error.hint().empty() ? "" : "; " + error.hint());
  }
}

void EventReader::read() {
  std::string text;
  std::array<char, 65536> part{};
  while (!leave_) {
    pollfd ready{stream_, POLLIN, 0};
    if (::poll(&ready, 1, 50) <= 0) continue;
    const ssize_t got = ::read(stream_, part.data(), part.size());
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) break;
    text.append(part.data(), static_cast<std::size_t>(got));
    std::size_t begin = 0;
    for (std::size_t end = text.find('\n'); end != std::string::npos && !leave_;
         end = text.find('\n', begin)) {
      take(std::string_view(text).substr(begin, end - begin));
      begin = end + 1;
    }
    text.erase(0, begin);
    // Of a line without an end its beginning is enough to refuse it.
    if (text.size() > 2 * longest_line) text.resize(longest_line + 1);
  }
  if (!text.empty() && !leave_) take(text);
  {
    const std::lock_guard lock(mutex_);
    ended_ = true;
  }
  moved_.notify_all();
}

}  // namespace carillon::cli::play
