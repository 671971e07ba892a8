#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

namespace carillon::core {

/// One line of progress with rate and time left, on standard error: redrawn in place on a
/// terminal, otherwise a plain line every `plain_interval_s` seconds and at the end.
class Progress {
 public:
  /// @param total  work in any unit (estimated seconds, samples); 0 means unknown
  Progress(std::string label, double total, bool quiet = false, double plain_interval_s = 10);
  ~Progress();
  /// @param done  work done so far, same unit as total
  /// @param note  what is going on now, e.g. "modes of cup-003"
  void update(double done, const std::string& note);
  /// Ends the line.
  void finish(const std::string& note);

 private:
  void draw(const std::string& note, bool last);
  std::string label_;
  double total_;
  bool quiet_;
  bool terminal_;
  std::size_t drawn_width_ = 0;  ///< of the line that a terminal shows
  bool finished_ = false;
  double interval_;
  double start_;
  double last_drawn_;
  double done_ = 0;
};

/// Whether the environment asks for text without escape codes: NO_COLOR (no-color.org).
bool plain_text_asked();

/// "0.4 s", "3 s", "2 min 05 s", "1 h 12 min".
std::string human_duration(double seconds);
/// "512 B", "1.2 MB".
std::string human_bytes(double bytes);
/// "512 B", "1.2 MiB": for limits, which are given in these units.
std::string human_binary_bytes(double bytes);

}  // namespace carillon::core
