#include "core/progress.hpp"

#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <utility>

#include "core/trace.hpp"

namespace carillon::core {

namespace {

constexpr double redraw_interval_s = 0.2;

int terminal_columns() {
  winsize size{};
  return ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0 ? size.ws_col : 80;
}

/// At most `width` bytes, cut between UTF-8 characters.
std::string cut(std::string line, std::size_t width) {
  if (line.size() <= width) return line;
  while (width > 0 && (static_cast<unsigned char>(line[width]) & 0xc0) == 0x80) --width;
  line.resize(width);
  return line;
}

}  // namespace

Progress::Progress(std::string label, double total, bool quiet, double plain_interval_s)
    : label_(std::move(label)),
      total_(total),
      quiet_(quiet),
      terminal_(isatty(STDERR_FILENO) == 1),
      interval_(terminal_ ? redraw_interval_s : plain_interval_s),
      start_(monotonic_seconds()),
      last_drawn_(start_ - (terminal_ ? interval_ : 0)) {}

Progress::~Progress() {
  // An exception passes by: leave the terminal on a fresh line.
  if (!finished_ && !quiet_ && terminal_ && last_drawn_ > start_) std::fputc('\n', stderr);
}

void Progress::update(double done, const std::string& note) {
  done_ = std::max(done_, done);
  if (quiet_ || finished_) return;
  const double now = monotonic_seconds();
  if (now - last_drawn_ < interval_) return;
  last_drawn_ = now;
  draw(note, false);
}

void Progress::finish(const std::string& note) {
  if (quiet_ || finished_) return;
  finished_ = true;
  draw(note, true);
}

void Progress::draw(const std::string& note, bool last) {
  const double elapsed = monotonic_seconds() - start_;
  std::string line = label_;
  if (total_ > 0) {
    // Not 100 % before the end: estimates run over.
    const double fraction = std::clamp(done_ / total_, 0.0, last ? 1.0 : 0.99);
    line += fmt::format("  {:3.0f} %", std::floor(100 * fraction));
  }
  const double rate = elapsed > 0 ? done_ / elapsed : 0;
  line += fmt::format("  {:.3g}/s", rate);
  if (last) {
    line += "  in " + human_duration(elapsed);
  } else if (total_ > 0 && rate > 0) {
    line += "  " + human_duration(std::ceil(std::max(0.0, total_ - done_) / rate)) + " left";
  }
  if (!note.empty()) line += "  " + note;
  if (terminal_) {
    const auto width = static_cast<std::size_t>(std::max(20, terminal_columns() - 1));
    line = cut(std::move(line), width);
    const std::size_t length = line.size();
    // Back to the first column, and clear what the longer line before left over.
    if (plain_text_asked()) {
      line.resize(std::max(length, drawn_width_), ' ');
    } else {
      line += "\x1b[K";
    }
    drawn_width_ = length;
    fmt::print(stderr, "\r{}{}", line, last ? "\n" : "");
  } else {
    fmt::print(stderr, "{}\n", line);
  }
  std::fflush(stderr);
}

bool plain_text_asked() {
  const char* asked = std::getenv("NO_COLOR");
  return asked != nullptr && *asked != '\0';
}

std::string human_duration(double seconds) {
  if (!std::isfinite(seconds) || seconds < 0) return "unknown time";
  if (seconds < 9.95) return fmt::format("{} s", std::round(10 * seconds) / 10);
  const double whole = std::round(seconds);
  if (whole < 60) return fmt::format("{:.0f} s", whole);
  if (whole < 3600) {
    return fmt::format("{:.0f} min {:02.0f} s", std::floor(whole / 60), std::fmod(whole, 60));
  }
  const double minutes = std::round(seconds / 60);
  if (minutes < 24 * 60) {
    return fmt::format("{:.0f} h {:02.0f} min", std::floor(minutes / 60), std::fmod(minutes, 60));
  }
  const double hours = std::round(seconds / 3600);
  return fmt::format("{:.0f} d {:02.0f} h", std::floor(hours / 24), std::fmod(hours, 24));
}

namespace {

std::string in_steps(double bytes, double factor, const std::array<const char*, 6>& names) {
  std::size_t step = 0;
  // 999.95 would be printed as 1000.0.
  while (std::abs(bytes) >= factor - (step == 0 ? 0.5 : 0.05) && step + 1 < names.size()) {
    bytes /= factor;
    ++step;
  }
  return step == 0 ? fmt::format("{:.0f} {}", bytes, names[step])
                   : fmt::format("{:.1f} {}", bytes, names[step]);
}

}  // namespace

std::string human_bytes(double bytes) {
  return in_steps(bytes, 1000, {"B", "kB", "MB", "GB", "TB", "PB"});
}

std::string human_binary_bytes(double bytes) {
  return in_steps(bytes, 1024, {"B", "KiB", "MiB", "GiB", "TiB", "PiB"});
}

}  // namespace carillon::core
