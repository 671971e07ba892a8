#include "cli/play/keyboard.hpp"

#include <fmt/format.h>
#include <poll.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include "cli/play/interrupt.hpp"
#include "core/error.hpp"

namespace carillon::cli::play {

using scene::live::Request;

Keyboard::Keyboard(std::size_t objects, double hand, Apply apply)
    : objects_(objects), hand_(hand), apply_(std::move(apply)) {
  if (::tcgetattr(STDIN_FILENO, &before_) != 0) {
    throw core::InputError("standard input is no terminal");
  }
  termios raw = before_;
  raw.c_lflag &= ~static_cast<tcflag_t>(ICANON | ECHO);
  // Suspended, the terminal would stay as it is now.
  raw.c_cc[VSUSP] = _POSIX_VDISABLE;
  raw.c_cc[VMIN] = 1;
  raw.c_cc[VTIME] = 0;
  ::tcsetattr(STDIN_FILENO, TCSANOW, &raw);
  thread_ = thread_without_signals([this] { listen(); });
}

Keyboard::~Keyboard() {
  leave_ = true;
  thread_.join();
  ::tcsetattr(STDIN_FILENO, TCSAFLUSH, &before_);
}

std::string Keyboard::help(std::size_t objects) {
  return fmt::format(
      "keys: 1 to m strike {}, capitals harder; space lays a hand on and takes it "
      "off; Escape or Ctrl-C ends",
      objects == 1 ? "places on the object" : "objects in their order");
}

void Keyboard::press(char key) {
  Request request;
  if (key == 27 || key == 4) return apply_(request);
  if (key == ' ') {
    held_ = !held_;
    request.kind = Request::Kind::damp;
    request.object = "*";
    request.amount = held_ ? hand_ : 0;
    return apply_(request);
  }
  const bool hard = key >= 'A' && key <= 'Z';
  const std::size_t place = keys.find(hard ? static_cast<char>(key - 'A' + 'a') : key);
  if (place == std::string_view::npos) return;
  request.kind = Request::Kind::strike;
  request.object = objects_ == 1 ? "0" : std::to_string(place);
  if (objects_ == 1) request.place = static_cast<int>(place);
  if (objects_ > 1 && place >= objects_) return;
  if (hard) request.strength = 3;
  apply_(request);
}

void Keyboard::listen() {
  while (!leave_) {
    pollfd ready{STDIN_FILENO, POLLIN, 0};
    if (::poll(&ready, 1, 50) <= 0) continue;
    char key = 0;
    const ssize_t got = ::read(STDIN_FILENO, &key, 1);
    if (got == 0) return apply_({});
    if (got < 0) continue;
    try {
      press(key);
    } catch (const core::Error& error) {
      spdlog::warn("key {}: {}", key, error.message());
    }
  }
}

}  // namespace carillon::cli::play
