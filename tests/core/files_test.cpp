#include "core/files.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <rapidcheck.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <optional>
#include <stdexcept>

#include "core/error.hpp"
#include "core/temporary_folder.hpp"

namespace carillon::core {
namespace {

namespace fs = std::filesystem;

std::vector<std::string> names_in(const fs::path& folder) {
  std::vector<std::string> names;
  for (const auto& one : fs::directory_iterator(folder)) names.push_back(one.path().filename());
  std::sort(names.begin(), names.end());
  return names;
}

/// Sets an environment variable for one test and puts it back.
class Environment {
 public:
  Environment(const char* name, const std::optional<std::string>& value) : name_(name) {
    if (const char* before = std::getenv(name)) before_ = before;
    set(value);
  }
  ~Environment() { set(before_); }

 private:
  void set(const std::optional<std::string>& value) {
    if (value) {
      ::setenv(name_, value->c_str(), 1);
    } else {
      ::unsetenv(name_);
    }
  }
  const char* name_;
  std::optional<std::string> before_;
};

TEST(WriteDurably, TheFileAppearsWholeInFoldersThatAreMade) {
  const TemporaryFolder folder;
  const fs::path path = folder / "a/b/c.txt";
  fs::path seen;
  write_durably(path, [&](const fs::path& temporary) {
    seen = temporary;
    EXPECT_EQ(temporary.parent_path(), path.parent_path());
    EXPECT_EQ(temporary.extension(), ".txt");
    EXPECT_NE(temporary.string().find(std::to_string(::getpid())), std::string::npos);
    std::ofstream(temporary) << "whole";
    EXPECT_FALSE(fs::exists(path));
  });
  EXPECT_NE(seen, path);
  EXPECT_EQ(read_file(path), "whole");
  EXPECT_EQ(names_in(path.parent_path()), std::vector<std::string>{"c.txt"});
}

TEST(WriteDurably, AFailureLeavesTheOldFileAndNothingElse) {
  const TemporaryFolder folder;
  write_text_durably(folder / "kept", "old");
  EXPECT_THROW(write_durably(folder / "kept",
                             [](const fs::path& temporary) {
                               std::ofstream(temporary) << "half";
                               throw std::runtime_error("broke off");
                             }),
               std::runtime_error);
  EXPECT_EQ(read_file(folder / "kept"), "old");
  EXPECT_EQ(names_in(folder.path()), std::vector<std::string>{"kept"});
}

TEST(WriteDurably, AWriterThatWritesNothingIsAnError) {
  const TemporaryFolder folder;
  EXPECT_THROW(write_durably(folder / "x", [](const fs::path&) {}), FileError);
  EXPECT_TRUE(names_in(folder.path()).empty());
}

TEST(WriteDurably, NamesThePathAndTheReason) {
  const TemporaryFolder folder;
  write_text_durably(folder / "file", "");
  try {
    write_text_durably(folder / "file/below", "x");
    FAIL() << "a file was taken for a folder";
  } catch (const FileError& error) {
    const std::string message = error.message();
    EXPECT_NE(message.find((folder / "file").string()), std::string::npos) << message;
    EXPECT_NE(message.find("Not a directory"), std::string::npos) << message;
  }
  fs::create_directory(folder / "folder");
  EXPECT_THROW(write_text_durably(folder / "folder", "x"), FileError);
  EXPECT_EQ(names_in(folder.path()), (std::vector<std::string>{"file", "folder"}));
}

TEST(WriteDurably, TakesNamesAsLongAsTheSystemAllows) {
  const TemporaryFolder folder;
  const std::string name = std::string(245, 'n') + ".json";
  write_text_durably(folder / name, "long");
  EXPECT_EQ(read_file(folder / name), "long");
}

TEST(WriteDurably, TakesARelativeNameWithoutAFolder) {
  const TemporaryFolder folder;
  const fs::path before = fs::current_path();
  fs::current_path(folder.path());
  write_text_durably("plain.txt", "here");
  const std::string text = read_file("plain.txt");
  fs::current_path(before);
  EXPECT_EQ(text, "here");
}

// What writers leave that are killed: the names are those of write_durably.
TEST(RemoveLeftovers, TakesTemporariesOfTheDeadAndNothingElse) {
  const TemporaryFolder folder;
  const auto make = [&](const std::string& name) {
    std::filesystem::create_directories((folder.path() / name).parent_path());
    std::ofstream(folder.path() / name) << "half";
    std::filesystem::last_write_time(
        folder.path() / name,
        std::filesystem::file_time_type::clock::now() - std::chrono::hours(1));
  };
  char host[65] = "";
  gethostname(host, sizeof host - 1);
  const pid_t gone = fork();
  if (gone == 0) _exit(0);
  waitpid(gone, nullptr, 0);
  const std::string dead = fmt::format("a/.x.{}.{}.7.tmp.h5", host, gone);
  const std::string alive = fmt::format(".index.{}.{}.0.tmp.h5", host, getpid());
  const std::string other = ".x.y.another-host.1.1.tmp";
  const std::vector<std::string> kept = {".lock", "x.tmp.h5", ".x.tmp", "a/x.h5", ".hidden.1.2.h5"};
  for (const std::string& name : kept) make(name);
  for (const std::string& name : {dead, alive, other}) make(name);
  EXPECT_EQ(remove_leftovers(folder.path(), false), 1);
  EXPECT_FALSE(std::filesystem::exists(folder.path() / dead));
  EXPECT_EQ(remove_leftovers(folder.path(), true), 2);
  for (const std::string& name : kept) EXPECT_TRUE(std::filesystem::exists(folder.path() / name));
  EXPECT_EQ(remove_leftovers(folder.path() / "missing", true), 0);
  // And those that write_durably makes are among them.
  write_durably(folder.path() / "b.h5", [&](const std::filesystem::path& temporary) {
    make(temporary.filename());
    EXPECT_EQ(remove_leftovers(folder.path(), true), 1);
    make(temporary.filename());
  });
}

TEST(ReadFile, GivesBackEveryByte) {
  const TemporaryFolder folder;
  EXPECT_TRUE(rc::check([&](const std::string& text) {
    write_text_durably(folder / "bytes", text);
    RC_ASSERT(read_file(folder / "bytes") == text);
  }));
  const std::string large(300'001, '\xfe');
  write_text_durably(folder / "large", large);
  EXPECT_EQ(read_file(folder / "large"), large);
}

TEST(ReadFile, NamesTheReason) {
  const TemporaryFolder folder;
  const auto reason = [](const fs::path& path) -> std::string {
    try {
      read_file(path);
      return "none";
    } catch (const FileError& error) {
      return error.message();
    }
  };
  EXPECT_EQ(reason(folder / "no.yaml"),
            (folder / "no.yaml").string() + ": cannot be read: No such file or directory");
  EXPECT_EQ(reason(folder.path()), folder.path().string() + ": cannot be read: Is a directory");
}

TEST(GlobFiles, FindsFilesInByteOrder) {
  const TemporaryFolder folder;
  for (const char* name : {"b.obj", "B.obj", "a10.obj", "a2.obj", "c.off", ".hidden.obj"}) {
    write_text_durably(folder / name, "");
  }
  fs::create_directory(folder / "folder.obj");
  const auto found = [&](const std::string& pattern) {
    std::vector<std::string> names;
    for (const fs::path& path : glob_files((folder / pattern).string())) {
      names.push_back(path.filename());
    }
    return names;
  };
  EXPECT_EQ(found("*.obj"), (std::vector<std::string>{"B.obj", "a10.obj", "a2.obj", "b.obj"}));
  EXPECT_EQ(found("?.o[bf]*"), (std::vector<std::string>{"B.obj", "b.obj", "c.off"}));
  EXPECT_EQ(found("c.off"), std::vector<std::string>{"c.off"});
  EXPECT_TRUE(found("*.stl").empty());
  EXPECT_TRUE(glob_files((folder / "absent/*.obj").string()).empty());
}

TEST(GlobFiles, KnowsTheHomeFolder) {
  const TemporaryFolder folder;
  const Environment home("HOME", folder.path().string());
  write_text_durably(folder / "mesh.obj", "");
  EXPECT_EQ(glob_files("~/*.obj"), std::vector<fs::path>{folder / "mesh.obj"});
}

TEST(DefaultCacheFolder, FollowsTheEnvironment) {
  const Environment home("HOME", "/home/somebody");
  {
    const Environment own("CARILLON_CACHE", "/fast/cache");
    const Environment base("XDG_CACHE_HOME", "/xdg");
    EXPECT_EQ(default_cache_folder(), "/fast/cache");
  }
  const Environment own("CARILLON_CACHE", "");
  {
    const Environment base("XDG_CACHE_HOME", "/xdg");
    EXPECT_EQ(default_cache_folder(), "/xdg/carillon");
  }
  {
    const Environment base("XDG_CACHE_HOME", "relative");
    EXPECT_EQ(default_cache_folder(), "/home/somebody/.cache/carillon");
  }
  const Environment base("XDG_CACHE_HOME", std::nullopt);
  EXPECT_EQ(default_cache_folder(), "/home/somebody/.cache/carillon");
  const Environment homeless("HOME", std::nullopt);
  EXPECT_TRUE(default_cache_folder().is_absolute());
}

}  // namespace
}  // namespace carillon::core
