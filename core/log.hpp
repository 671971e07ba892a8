#pragma once

#include <string>
#include <string_view>

namespace carillon::core {

/// How much a program says of its work on standard error.
enum class Detail {
  warnings,  ///< those alone
  progress,  ///< and how far it is
  tasks      ///< and each task
};

/// From now on warnings, progress and tasks (spdlog's levels warn, info and debug) go to standard
/// error, with dates where that is no terminal, and all of them to a file, if one is named: what is
/// there already stays. Standard output belongs to results.
/// @throws FileError  the file cannot be written
void start_log(Detail detail, const std::string& file = "");

/// Whether progress is shown on standard error.
bool shows_progress();

/// Into the log's file alone, where there is one: what a person sees by other means. Throws
/// nothing.
void log_to_file(std::string_view text);

/// A line on a terminal that is drawn again and again: what is logged meanwhile takes its place,
/// and the next drawing comes below.
/// @param text   without a line break
/// @param ended  it stays, and what follows begins a new line
void draw_status_line(std::string text, bool ended);
/// What is drawn stays, and what follows begins a new line.
void leave_status_line();

/// A time as "2026-03-31 14:05:09", in the local zone.
std::string date_and_time();

}  // namespace carillon::core
