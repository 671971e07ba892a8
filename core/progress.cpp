#include "core/progress.hpp"

#include <fmt/format.h>
#include <spdlog/spdlog.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <utility>

#include "core/log.hpp"
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

Progress::Progress(std::string label, double total, bool silent, std::string unit,
                   double plain_interval_s)
    : label_(std::move(label)),
      unit_(std::move(unit)),
      total_(total),
      silent_(silent),
      drawn_(isatty(STDERR_FILENO) == 1 && shows_progress()),
      interval_(plain_interval_s),
      start_(monotonic_seconds()),
      last_drawn_(start_ - redraw_interval_s),
      last_logged_(start_) {}

Progress::~Progress() {
  // An exception passes by: leave the terminal on a fresh line.
  if (!finished_ && !silent_ && drawn_) leave_status_line();
}

void Progress::update(double done, const std::string& note) {
  done_ = std::max(done_, done);
  if (!silent_ && !finished_) draw(note, false);
}

void Progress::finish(const std::string& note) {
  if (silent_ || finished_) return;
  finished_ = true;
  draw(note, true);
}

std::optional<double> Progress::fraction() const {
  // Not 1 before the end: estimates run over.
  if (!(total_ > 0)) return std::nullopt;
  return std::clamp(done_ / total_, 0.0, finished_ ? 1.0 : 0.99);
}

double Progress::elapsed_s() const {
  return monotonic_seconds() - start_;
}

std::optional<double> Progress::remaining_s() const {
  if (!(total_ > 0 && done_ > before_)) return std::nullopt;
  return std::max(0.0, total_ - done_) * elapsed_s() / (done_ - before_);
}

std::string Progress::line(const std::string& note, bool last) const {
  std::string line = label_;
  if (const auto part = fraction()) line += fmt::format("  {:3.0f} %", std::floor(100 * *part));
  if (!note.empty()) line += "  " + note;
  const double elapsed = elapsed_s();
  if (!unit_.empty() && elapsed > 0 && done_ > before_)
    line += fmt::format("  {:.3g} {}/s", (done_ - before_) / elapsed, unit_);
  if (last) return line + "  in " + human_duration(elapsed);
  if (const auto left = remaining_s()) line += "  " + human_duration(std::ceil(*left)) + " left";
  return line;
}

void Progress::draw(const std::string& note, bool last) {
  const double now = monotonic_seconds();
  if (drawn_ && (last || now - last_drawn_ >= redraw_interval_s)) {
    last_drawn_ = now;
    const auto width = static_cast<std::size_t>(std::max(20, terminal_columns() - 1));
    draw_status_line(cut(line(note, last), width), last);
  }
  if (last || now - last_logged_ >= interval_) {
    last_logged_ = now;
    if (drawn_) {
      log_to_file(line(note, last));
    } else {
      spdlog::info("{}", line(note, last));
    }
  }
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
