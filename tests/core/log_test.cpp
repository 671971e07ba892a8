#include "core/log.hpp"

#include <gtest/gtest.h>
#include <spdlog/spdlog.h>

#include <regex>
#include <string>

#include "core/error.hpp"
#include "core/files.hpp"
#include "core/progress.hpp"
#include "core/temporary_folder.hpp"

namespace carillon::core {
namespace {

/// What is said at every level, as standard error has it while that is a file.
std::string said(Detail detail, const std::string& file = "") {
  testing::internal::CaptureStderr();
  start_log(detail, file);
  spdlog::warn("a doubt");
  spdlog::info("halfway");
  spdlog::debug("one task");
  const std::string text = testing::internal::GetCapturedStderr();
  start_log(Detail::progress);
  return text;
}

/// Without the dates, which are held to their form.
std::string undated(const std::string& text) {
  const std::regex date(R"((^|\n)\d{4}-\d\d-\d\d \d\d:\d\d:\d\d )");
  return std::regex_replace(text, date, "$1");
}

TEST(Log, SaysAsMuchAsIsAskedFor) {
  EXPECT_EQ(undated(said(Detail::warnings)), "warning: a doubt\n");
  EXPECT_EQ(undated(said(Detail::progress)), "warning: a doubt\nhalfway\n");
  EXPECT_EQ(undated(said(Detail::tasks)), "warning: a doubt\nhalfway\none task\n");
}

TEST(Log, AFileGetsEverythingAndKeepsWhatIsThere) {
  const TemporaryFolder folder;
  const auto file = folder / "run.log";
  write_text_durably(file, "yesterday\n");
  EXPECT_EQ(undated(said(Detail::warnings, file.string())), "warning: a doubt\n");
  EXPECT_EQ(undated(read_file(file)), "yesterday\nwarning: a doubt\nhalfway\none task\n");
  start_log(Detail::warnings, file.string());
  log_to_file("two\nlines\n");
  {
    Progress progress("build", 10, false, "", 0);
    progress.update(5, "half");
  }
  start_log(Detail::progress);
  log_to_file("nobody hears this");
  const std::string text = undated(read_file(file));
  EXPECT_NE(text.find("\none task\ntwo\nlines\nbuild   50 %  half"), std::string::npos) << text;
  EXPECT_EQ(text.find("nobody"), std::string::npos);
}

TEST(Log, AFileThatCannotBeWrittenIsToldAtOnce) {
  const TemporaryFolder folder;
  const auto nowhere = folder / "nowhere" / "run.log";
  try {
    start_log(Detail::progress, nowhere.string());
    FAIL();
  } catch (const FileError& error) {
    EXPECT_NE(error.message().find(nowhere.string() + ": the log cannot be written: No such file"),
              std::string::npos)
        << error.message();
  }
}

}  // namespace
}  // namespace carillon::core
