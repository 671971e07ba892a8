// Results that are kept in files, and made again where those are damaged.
#include "core/cached.hpp"

#include <gtest/gtest.h>
#include <spdlog/sinks/ostream_sink.h>
#include <spdlog/spdlog.h>

#include <sstream>
#include <thread>
#include <vector>

#include "core/error.hpp"
#include "core/files.hpp"
#include "core/temporary_folder.hpp"

namespace carillon::core {
namespace {

class Cached : public testing::Test {
 protected:
  Cached() {
    before_ = spdlog::default_logger();
    spdlog::set_default_logger(std::make_shared<spdlog::logger>(
        "test", std::make_shared<spdlog::sinks::ostream_sink_mt>(told_)));
  }
  ~Cached() override { spdlog::set_default_logger(before_); }

  std::string text(const std::filesystem::path& folder, const std::string& name = "key.txt") {
    return cached<std::string>(
        folder, name,
        [](const auto& path) {
          std::string kept = read_file(path);
          if (!kept.ends_with('.')) throw FileError("cut short");
          return kept;
        },
        [](const auto& path, const std::string& made) { write_text_durably(path, made); },
        [this] {
          ++made_;
          return std::string("a result.");
        });
  }
  /// How often something was told.
  std::size_t warnings() const {
    const std::string all = told_.str();
    std::size_t count = 0;
    for (auto at = all.find("[warning]"); at != std::string::npos; ++count) {
      at = all.find("[warning]", at + 1);
    }
    return count;
  }

  TemporaryFolder folder_;
  std::ostringstream told_;
  std::shared_ptr<spdlog::logger> before_;
  int made_ = 0;
};

TEST_F(Cached, IsMadeOnce) {
  for (int k = 0; k < 3; ++k) EXPECT_EQ(text(folder_ / "new" / "folders"), "a result.");
  EXPECT_EQ(made_, 1);
  text(folder_ / "new" / "folders", "another-key.txt");
  EXPECT_EQ(made_, 2);
  EXPECT_EQ(warnings(), 0u);
}

TEST_F(Cached, IsNotKeptWithoutAFolder) {
  EXPECT_EQ(text(""), "a result.");
  EXPECT_EQ(text(""), "a result.");
  EXPECT_EQ(made_, 2);
}

TEST_F(Cached, IsMadeAgainAndReplacedWhereItsFileIsDamaged) {
  text(folder_.path());
  for (const char* damaged : {"a res", ""}) {
    write_text_durably(folder_ / "key.txt", damaged);
    EXPECT_EQ(text(folder_.path()), "a result.");
  }
  EXPECT_EQ(made_, 3);
  EXPECT_EQ(warnings(), 2u);
  EXPECT_NE(told_.str().find("key.txt cannot be used and is made again: cut short"),
            std::string::npos);
  text(folder_.path());
  EXPECT_EQ(made_, 3);
}

TEST_F(Cached, IsGoodWhereItCannotBeKeptWhichIsToldOnce) {
  write_text_durably(folder_ / "no-folder", "");
  for (const char* name : {"a", "b", "a"}) {
    EXPECT_EQ(text(folder_ / "no-folder", name), "a result.");
  }
  EXPECT_EQ(made_, 3);
  EXPECT_EQ(warnings(), 1u);
  EXPECT_NE(told_.str().find("no-folder"), std::string::npos);
}

TEST_F(Cached, IsWholeWhereSeveralMakeItAtOnce) {
  const auto write = [](const std::filesystem::path& path) {
    write_text_durably(path, std::string(1 << 20, 'x'));
  };
  const auto read = [](const std::filesystem::path& path) { return read_file(path).size(); };
  const auto file = folder_ / "large";
  to_cache(file, write);
  std::thread writer([&] {
    for (int k = 0; k < 20; ++k) to_cache(file, write);
  });
  for (int k = 0; k < 50; ++k) EXPECT_EQ(from_cache<std::size_t>(file, read), std::size_t{1} << 20);
  writer.join();
  EXPECT_EQ(warnings(), 0u);
}

}  // namespace
}  // namespace carillon::core
