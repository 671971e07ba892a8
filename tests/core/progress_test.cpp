#include "core/progress.hpp"

#include <gtest/gtest.h>
#include <pty.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <optional>
#include <regex>
#include <string>
#include <thread>

#include "core/log.hpp"

namespace carillon::core {
namespace {

/// What `object` writes to standard error while that is a terminal.
template <class Body>
std::string on_a_terminal(const Body& body) {
  int master = -1, slave = -1;
  if (openpty(&master, &slave, nullptr, nullptr, nullptr) != 0) return "no terminal";
  const int before = dup(STDERR_FILENO);
  dup2(slave, STDERR_FILENO);
  body();
  dup2(before, STDERR_FILENO);
  close(before);
  close(slave);
  std::string text;
  char block[4096];
  // Reading ends with an error once the other side is closed and empty.
  for (ssize_t n; (n = read(master, block, sizeof block)) > 0;) text.append(block, std::size_t(n));
  close(master);
  return text;
}

/// What `body` writes to standard error while that is a file.
template <class Body>
std::string in_a_file(const Body& body, Detail detail = Detail::progress) {
  testing::internal::CaptureStderr();
  start_log(detail);
  body();
  return testing::internal::GetCapturedStderr();
}

std::ptrdiff_t count(const std::string& text, char sign) {
  return std::count(text.begin(), text.end(), sign);
}

TEST(Progress, PrintsPlainLinesAtIntervalsAndAtTheEnd) {
  const std::string text = in_a_file([] {
    Progress progress("build", 10, false, "tasks", 0);
    progress.update(2.5, "modes of cup-003");
    progress.finish("10 samples");
    progress.finish("again");
    progress.update(3, "too late");
  });
  EXPECT_EQ(count(text, '\n'), 2) << text;
  // With the date in front, off a terminal.
  EXPECT_TRUE(std::regex_search(
      text, std::regex(R"(^\d{4}-\d\d-\d\d \d\d:\d\d:\d\d build   25 %  modes of cup-003  )"
                       R"(\S+ tasks/s  .* left\n)")))
      << text;
  EXPECT_TRUE(std::regex_search(text, std::regex(R"(10 samples  .* in \S+ s\n)"))) << text;
  EXPECT_EQ(count(text, '\r') + count(text, '\x1b'), 0) << text;
}

TEST(Progress, KeepsToItsInterval) {
  const std::string text = in_a_file([] {
    Progress progress("build", 10, false, "", 1000);
    for (int i = 0; i < 100; ++i) progress.update(i, "busy");
  });
  EXPECT_EQ(text, "");
}

TEST(Progress, SaysNothingWhereItIsSilentOrNotAskedFor) {
  for (const bool silent : {true, false}) {
    const auto work = [silent] {
      Progress progress("build", 10, silent, "", 0);
      progress.update(1, "busy");
      progress.finish("done");
    };
    EXPECT_EQ(in_a_file(work, silent ? Detail::tasks : Detail::warnings), "");
    if (!silent) EXPECT_EQ(on_a_terminal(work), "");
  }
  start_log(Detail::progress);
}

TEST(Progress, WhatWasDoneBeforeTellsNothingOfTheRate) {
  Progress progress("build", 100, true);
  EXPECT_EQ(progress.remaining_s(), std::nullopt);
  progress.begin_at(90);
  EXPECT_EQ(progress.remaining_s(), std::nullopt);
  EXPECT_DOUBLE_EQ(progress.fraction().value(), 0.9);
  std::this_thread::sleep_for(std::chrono::milliseconds(20));
  progress.update(95, "");
  const double elapsed = progress.elapsed_s();
  EXPECT_NEAR(progress.remaining_s().value(), elapsed, 0.5 * elapsed);  // not 5 %
  EXPECT_EQ(Progress("read", 0, true).fraction(), std::nullopt);
}

TEST(Progress, AnUnknownTotalHasNoPercentAndNoTimeLeft) {
  const std::string text = in_a_file([] {
    Progress progress("read", 0, false, "", 0);
    progress.update(7, "files");
  });
  EXPECT_NE(text.find("read  files"), std::string::npos) << text;
  EXPECT_EQ(text.find('%'), std::string::npos) << text;
  EXPECT_EQ(text.find("left"), std::string::npos) << text;
}

TEST(Progress, RedrawsOneLineOnATerminalAtMostFiveTimesASecond) {
  const std::string text = on_a_terminal([] {
    Progress progress("build", 1000);
    for (int i = 0; i < 1000; ++i) progress.update(i, "busy");
    progress.finish("done");
  });
  // The first and the last; a slow machine may fit a few between. Terminals write \r\n for \n.
  EXPECT_EQ(count(text, '\n'), 1) << text;
  EXPECT_GE(count(text, '\x1b'), 2) << text;
  EXPECT_LE(count(text, '\x1b'), 6) << text;
  EXPECT_EQ(text.front(), '\r');
}

TEST(Progress, ALineNeverWrapsOnATerminal) {
  const std::string note(500, 'x');
  const std::string text = on_a_terminal([&] {
    Progress progress("build", 10);
    progress.update(5, note);
    progress.finish("");
  });
  EXPECT_EQ(text.find(std::string(80, 'x')), std::string::npos);
}

TEST(Progress, LeavesAFreshLineWhenAnExceptionPasses) {
  const std::string text = on_a_terminal([] {
    Progress progress("build", 10);
    progress.update(5, "busy");
  });
  EXPECT_EQ(text.back(), '\n');
}

TEST(HumanDuration, ReadsLikeAPersonWouldSay) {
  EXPECT_EQ(human_duration(0), "0 s");
  EXPECT_EQ(human_duration(0.43), "0.4 s");
  EXPECT_EQ(human_duration(3), "3 s");
  EXPECT_EQ(human_duration(9.96), "10 s");
  EXPECT_EQ(human_duration(59.4), "59 s");
  EXPECT_EQ(human_duration(59.6), "1 min 00 s");
  EXPECT_EQ(human_duration(125), "2 min 05 s");
  EXPECT_EQ(human_duration(3599.7), "1 h 00 min");
  EXPECT_EQ(human_duration(72 * 60), "1 h 12 min");
  EXPECT_EQ(human_duration(100 * 3600), "4 d 04 h");
  EXPECT_EQ(human_duration(std::nan("")), "unknown time");
  EXPECT_EQ(human_duration(std::numeric_limits<double>::infinity()), "unknown time");
}

TEST(HumanBytes, ReadsLikeAPersonWouldSay) {
  EXPECT_EQ(human_bytes(0), "0 B");
  EXPECT_EQ(human_bytes(512), "512 B");
  EXPECT_EQ(human_bytes(999.6), "1.0 kB");
  EXPECT_EQ(human_bytes(1.2e6), "1.2 MB");
  EXPECT_EQ(human_bytes(999'960), "1.0 MB");
  EXPECT_EQ(human_bytes(3e18), "3000.0 PB");
  EXPECT_EQ(human_binary_bytes(1023), "1023 B");
  EXPECT_EQ(human_binary_bytes(1024), "1.0 KiB");
  EXPECT_EQ(human_binary_bytes(1e6), "976.6 KiB");
  EXPECT_EQ(human_binary_bytes(16.0 * (1 << 30)), "16.0 GiB");
}

}  // namespace
}  // namespace carillon::core
