#pragma once

#include <optional>
#include <string>

namespace carillon::core {

/// One line of progress with the time left: redrawn in place on a terminal, otherwise a line of the
/// log every `plain_interval_s` seconds and at the end, which the log's file gets in any case
/// (core/log.hpp).
class Progress {
 public:
  /// @param total   work in any unit (estimated seconds, samples); 0 means unknown
  /// @param silent  says nothing: ranks that do not speak, and work that is done already
  /// @param unit    of the work, where a rate in it tells something: "samples"
  Progress(std::string label, double total, bool silent = false, std::string unit = "",
           double plain_interval_s = 10);
  ~Progress();
  /// So much was done before, by others: it tells nothing of how fast the rest goes.
  void begin_at(double done) { done_ = before_ = done; }
  /// @param done  work done so far, same unit as total
  /// @param note  what is going on now, e.g. "modes of cup-003"
  void update(double done, const std::string& note);
  /// Ends the line.
  void finish(const std::string& note);

  /// Of the total, 0 to 1; nothing where that is unknown.
  std::optional<double> fraction() const;
  double elapsed_s() const;
  /// Nothing before some of the work is done.
  std::optional<double> remaining_s() const;

 private:
  std::string line(const std::string& note, bool last) const;
  void draw(const std::string& note, bool last);

  std::string label_, unit_;
  double total_;
  bool silent_;
  bool drawn_;  ///< on a terminal
  bool finished_ = false;
  double interval_;  ///< of lines in the log
  double start_;
  double last_drawn_, last_logged_;
  double done_ = 0, before_ = 0;
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
