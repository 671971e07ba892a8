#include "core/log.hpp"

#include <fmt/chrono.h>
#include <fmt/format.h>
#include <spdlog/sinks/base_sink.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <ctime>
#include <memory>
#include <mutex>
#include <system_error>
#include <utility>

#include "core/error.hpp"
#include "core/progress.hpp"

namespace carillon::core {

namespace {

/// The line that a terminal shows now; empty: the cursor is at the beginning of a fresh one.
struct StatusLine {
  std::mutex mutex;
  std::string text;
};

StatusLine& status_line() {
  static StatusLine line;
  return line;
}

std::string name_of(spdlog::level::level_enum level) {
  if (level < spdlog::level::warn) return "";
  return level == spdlog::level::warn ? "warning: " : "error: ";
}

std::string text_of(const spdlog::details::log_msg& message) {
  return {message.payload.data(), message.payload.size()};
}

/// Standard error: for people on a terminal, with dates elsewhere.
class StandardError final : public spdlog::sinks::base_sink<std::mutex> {
 public:
  StandardError() : terminal_(isatty(STDERR_FILENO) == 1), plain_(plain_text_asked()) {}

 protected:
  void sink_it_(const spdlog::details::log_msg& message) override {
    std::string name = name_of(message.level);
    if (!terminal_) {
      fmt::print(stderr, "{} {}{}\n", date_and_time(), name, text_of(message));
      return;
    }
    if (!plain_ && !name.empty()) name = "\x1b[1;33m" + name + "\x1b[0m";
    const std::scoped_lock lock(status_line().mutex);
    std::string& shown = status_line().text;
    if (!shown.empty()) {
      fmt::print(stderr, "\r{}", plain_ ? std::string(shown.size(), ' ') + "\r" : "\x1b[K");
    }
    shown.clear();
    fmt::print(stderr, "{}{}\n", name, text_of(message));
  }
  void flush_() override { std::fflush(stderr); }

 private:
  const bool terminal_, plain_;
};

/// A file that several ranks add their lines to.
class LogFile final : public spdlog::sinks::base_sink<std::mutex> {
 public:
  explicit LogFile(const std::string& path) : file_(std::fopen(path.c_str(), "ae")) {
    if (file_ == nullptr) {
      throw FileError(fmt::format("{}: the log cannot be written: {}", path,
                                  std::generic_category().message(errno)),
                      "name a file in a folder that is there and may be written to");
    }
  }
  ~LogFile() override { std::fclose(file_); }

  void add(std::string_view text) {
    const std::scoped_lock lock(mutex_);
    write(text);
  }

 protected:
  void sink_it_(const spdlog::details::log_msg& message) override {
    write(name_of(message.level) + text_of(message));
  }
  void flush_() override {}

 private:
  /// Line by line; a log that cannot be written any more ends nothing.
  void write(std::string_view text) {
    while (!text.empty() && text.back() == '\n') text.remove_suffix(1);
    const std::string now = date_and_time();
    std::string lines;
    while (!text.empty()) {
      const std::size_t end = text.find('\n');
      lines += fmt::format("{} {}\n", now, text.substr(0, end));
      text = end == std::string_view::npos ? std::string_view() : text.substr(end + 1);
    }
    std::fwrite(lines.data(), 1, lines.size(), file_);
    std::fflush(file_);
  }

  std::FILE* file_;
};

struct Log {
  bool progress = true;
  std::shared_ptr<LogFile> file{};
};

Log& log() {
  static Log log;
  return log;
}

}  // namespace

void start_log(Detail detail, const std::string& file) {
  auto error = std::make_shared<StandardError>();
  error->set_level(detail == Detail::tasks      ? spdlog::level::debug
                   : detail == Detail::progress ? spdlog::level::info
                                                : spdlog::level::warn);
  auto logger = std::make_shared<spdlog::logger>("carillon", std::move(error));
  std::shared_ptr<LogFile> kept;
  if (!file.empty()) {
    kept = std::make_shared<LogFile>(file);
    logger->sinks().push_back(kept);
  }
  logger->set_level(spdlog::level::debug);
  logger->flush_on(spdlog::level::debug);
  spdlog::set_default_logger(std::move(logger));
  log() = {detail != Detail::warnings, std::move(kept)};
}

bool shows_progress() {
  return log().progress;
}

void log_to_file(std::string_view text) {
  if (log().file) log().file->add(text);
}

void draw_status_line(std::string text, bool ended) {
  const std::scoped_lock lock(status_line().mutex);
  std::string& shown = status_line().text;
  const std::size_t length = text.size();
  // Back to the first column, and clear what the longer line before left over.
  if (plain_text_asked()) {
    text.resize(std::max(length, shown.size()), ' ');
  } else {
    text += "\x1b[K";
  }
  fmt::print(stderr, "\r{}{}", text, ended ? "\n" : "");
  std::fflush(stderr);
  shown = ended ? "" : text.substr(0, length);
}

void leave_status_line() {
  const std::scoped_lock lock(status_line().mutex);
  if (!status_line().text.empty()) std::fputc('\n', stderr);
  status_line().text.clear();
}

std::string date_and_time() {
  const std::time_t now = std::time(nullptr);
  std::tm local{};
  localtime_r(&now, &local);
  return fmt::format("{:%Y-%m-%d %H:%M:%S}", local);
}

}  // namespace carillon::core
