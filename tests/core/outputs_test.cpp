#include "core/outputs.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include "core/error.hpp"
#include "core/files.hpp"
#include "core/temporary_folder.hpp"
#include "core/what_is.hpp"

namespace carillon::core {
namespace {

namespace fs = std::filesystem;

std::size_t count(const fs::path& folder) {
  return static_cast<std::size_t>(
      std::distance(fs::recursive_directory_iterator(folder), fs::recursive_directory_iterator()));
}

std::string refusal(void (*require)(const fs::path&), const fs::path& path) {
  try {
    require(path);
  } catch (const FileError& error) {
    EXPECT_FALSE(error.hint().empty());
    return error.message();
  }
  return "";
}

class Outputs : public testing::Test {
 protected:
  Outputs() {
    fs::create_directory(folder / "there");
    write_text_durably(folder / "file", "text");
  }
  TemporaryFolder folder;
};

TEST_F(Outputs, WhatCanBeWrittenPassesAndLeavesNothing) {
  for (const char* name : {"new.wav", "there/new.wav", "not/there/yet.wav", "file"}) {
    EXPECT_EQ(refusal(require_writable_file, folder / name), "");
  }
  for (const char* name : {"new", "there", "there/", "not/there/yet"}) {
    EXPECT_EQ(refusal(require_writable_folder, folder / name), "");
  }
  EXPECT_EQ(count(folder.path()), 2u);
  EXPECT_EQ(read_file(folder / "file"), "text");
}

TEST_F(Outputs, WhatStandsInTheWayIsNamed) {
  EXPECT_NE(refusal(require_writable_file, folder / "there").find("it is a folder"),
            std::string::npos);
  EXPECT_NE(refusal(require_writable_file, folder / "file/new.wav").find("file is no folder"),
            std::string::npos);
  EXPECT_NE(refusal(require_writable_folder, folder / "file").find("it is a file"),
            std::string::npos);
  EXPECT_NE(refusal(require_writable_folder, folder / "file/new").find("file is no folder"),
            std::string::npos);
  EXPECT_NE(refusal(require_writable_file, "/dev/null").find("it is no regular file"),
            std::string::npos);
  EXPECT_NE(refusal(require_writable_file, "/proc/new.wav").find("no file can be made in /proc"),
            std::string::npos);
  EXPECT_NE(refusal(require_writable_file, "").find("empty"), std::string::npos);
}

TEST_F(Outputs, AFolderWithoutTheRightToWriteIsFound) {
  if (::geteuid() == 0) GTEST_SKIP() << "root may write everywhere";
  fs::permissions(folder / "there", fs::perms::owner_read | fs::perms::owner_exec);
  EXPECT_NE(refusal(require_writable_file, folder / "there/new").find("Permission denied"),
            std::string::npos);
  fs::permissions(folder / "there", fs::perms::owner_all);
}

TEST_F(Outputs, KindsOfFilesAndFoldersAreTold) {
  const auto put = [&](const char* name, const std::string& bytes) {
    write_text_durably(folder / name, bytes);
    return what_is(folder / name).name;
  };
  EXPECT_EQ(put("a", "RIFF1234WAVE"), "a WAV file");
  EXPECT_EQ(put("b", "\x89PNG\r\n"), "a PNG picture");
  EXPECT_EQ(put("c.yaml", "name: c"), "a configuration");
  EXPECT_EQ(put("d", ""), "a file");
  EXPECT_EQ(what_is(folder / "gone").name, "missing");
  EXPECT_EQ(what_is(folder / "there").name, "a folder");
  put("there/index.h5", "");
  EXPECT_EQ(what_is(folder / "there").name, "a dataset");
  put("other/training.json", "{}");
  EXPECT_EQ(what_is(folder / "other").name, "a folder of trained classifiers");
  EXPECT_TRUE(what_is(folder / "a").sound);
  EXPECT_FALSE(what_is(folder / "b").sound);
}

}  // namespace
}  // namespace carillon::core
