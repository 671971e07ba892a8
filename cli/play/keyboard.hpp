#pragma once

#include <termios.h>

#include <atomic>
#include <string>
#include <thread>

#include "cli/play/event_reader.hpp"

namespace carillon::cli::play {

/// Keys of the terminal on standard input strike objects or, of a single one, places on it. The
/// terminal gives each key at once and shows none meanwhile; it is as it was when this ends.
class Keyboard {
 public:
  /// @param objects  how many there are
  /// @param hand     [1/s] that the space key lays on all and takes off again
  Keyboard(std::size_t objects, double hand, Apply apply);
  ~Keyboard();
  Keyboard(const Keyboard&) = delete;
  Keyboard& operator=(const Keyboard&) = delete;

  /// Keys that strike, in their order.
  static constexpr std::string_view keys = "1234567890qwertyuiopasdfghjklzxcvbnm";
  static std::string help(std::size_t objects);

 private:
  void listen();
  void press(char key);

  std::size_t objects_;
  double hand_;
  bool held_ = false;
  Apply apply_;
  termios before_{};
  std::atomic<bool> leave_ = false;
  std::thread thread_;
};

}  // namespace carillon::cli::play
