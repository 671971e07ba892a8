#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <mutex>
#include <string>
#include <string_view>
#include <thread>

#include "scene/live/request.hpp"

namespace carillon::cli::play {

using Apply = std::function<void(const scene::live::Request&)>;

/// Reads lines of events (scene::live::parse_request) in a thread of its own and hands them on a
/// second before they are due. Lines that are malformed or cannot be are told with their number on
/// standard error and counted.
class EventReader {
 public:
  /// @param stream  a descriptor, which stays open
  /// @param name    of the file, for messages
  EventReader(int stream, std::string name, Apply apply);
  ~EventReader();
  EventReader(const EventReader&) = delete;
  EventReader& operator=(const EventReader&) = delete;

  /// Playing has come so far [s].
  void played(double time);
  /// Waits until every event before a time has been handed on (lines are in the order of their
  /// times), or the lines have ended.
  /// @param longest  [s]
  /// @return whether it is so
  bool wait_for(double time, double longest);
  bool ended() const { return ended_; }
  std::uint64_t refused() const { return refused_; }

 private:
  void read();
  void take(std::string_view line);

  int stream_;
  std::string name_;
  Apply apply_;
  std::mutex mutex_;
  std::condition_variable moved_;
  double played_ = 0, read_ = 0;  ///< [s]
  std::uint64_t lines_ = 0;
  std::atomic<std::uint64_t> refused_ = 0;
  std::atomic<bool> ended_ = false, leave_ = false;
  std::thread thread_;
};

}  // namespace carillon::cli::play
