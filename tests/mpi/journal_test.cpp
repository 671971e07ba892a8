#include "mpi/journal.hpp"

#include <gtest/gtest.h>
#include <rapidcheck.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <fstream>
#include <sstream>

#include "core/error.hpp"
#include "core/temporary_folder.hpp"

namespace carillon::mpi {
namespace {

using nlohmann::json;

std::string read(const std::filesystem::path& path) {
  std::ostringstream text;
  text << std::ifstream(path, std::ios::binary).rdbuf();
  return text.str();
}

void write(const std::filesystem::path& path, const std::string& text) {
  std::ofstream(path, std::ios::binary) << text;
}

std::string message_of_opening(const std::filesystem::path& path) {
  try {
    const Journal journal(path);
  } catch (const core::FileError& e) {
    return e.message();
  }
  return "opened";
}

TEST(Journal, WhatWasAppendedIsThereNextTime) {
  const core::TemporaryFolder folder;
  const std::filesystem::path path = folder.path() / "new" / "journal.jsonl";
  const json first{{"key", "modes/cup"}, {"text", "two\nlines, \"quotes\" and \u00fc"}};
  const json second{{"key", "samples/cup/0"}, {"seconds", 1.25}};
  {
    Journal journal(path);
    EXPECT_TRUE(journal.entries().empty());
    journal.append(first);
    journal.append(second);
  }
  EXPECT_EQ(read(path), first.dump() + "\n" + second.dump() + "\n");
  const Journal again(path);
  EXPECT_EQ(again.entries(), (std::vector<json>{first, second}));
}

TEST(Journal, IsOnTheFileSystemBeforeAppendReturns) {
  const core::TemporaryFolder folder;
  Journal journal(folder.path() / "journal.jsonl");
  journal.append({{"key", "a"}});
  EXPECT_EQ(read(folder.path() / "journal.jsonl"), "{\"key\":\"a\"}\n");
}

TEST(Journal, AfterACrashAnywhereWholeLinesRemain) {
  const bool holds = rc::check([] {
    const core::TemporaryFolder folder;
    const std::filesystem::path path = folder.path() / "journal.jsonl";
    const auto keys = *rc::gen::container<std::vector<std::string>>(
        rc::gen::container<std::string>(rc::gen::inRange<char>(' ', '~')));
    std::string text;
    std::vector<std::size_t> ends{0};
    for (const std::string& key : keys) {
      text += json{{"key", key}}.dump() + "\n";
      ends.push_back(text.size());
    }
    const auto cut = *rc::gen::inRange<std::size_t>(0, text.size() + 1);
    write(path, text.substr(0, cut));
    std::size_t whole = 0;
    while (whole + 1 < ends.size() && ends[whole + 1] <= cut) ++whole;
    {
      Journal journal(path);
      RC_ASSERT(journal.entries().size() == whole);
      for (std::size_t i = 0; i < whole; ++i) {
        RC_ASSERT(journal.entries()[i].at("key") == keys[i]);
      }
      journal.append({{"key", "next"}});
    }
    RC_ASSERT(read(path) == text.substr(0, ends[whole]) + "{\"key\":\"next\"}\n");
  });
  EXPECT_TRUE(holds);
}

// Some file systems leave zeros where a crash came between a file's growth and its contents.
TEST(Journal, ATailOfZerosIsACutLine) {
  const core::TemporaryFolder folder;
  const std::filesystem::path path = folder.path() / "journal.jsonl";
  write(path, "{\"key\":\"a\"}\n" + std::string(100, '\0'));
  EXPECT_EQ(Journal(path).entries().size(), 1U);
  EXPECT_EQ(read(path), "{\"key\":\"a\"}\n");
}

TEST(Journal, ADamagedLineIsNamedAndTakenOut) {
  const core::TemporaryFolder folder;
  const std::filesystem::path path = folder.path() / "journal.jsonl";
  for (const std::string bad : {"{\"key\": oops}", "17", "", "[1]", "{} {}"}) {
    write(path, "{\"key\":\"a\"}\n" + bad + "\n{\"key\":\"b\"}\n" + bad + "\n");
    {
      testing::internal::CaptureStderr();
      testing::internal::CaptureStdout();
      Journal journal(path);
      const std::string told =
          testing::internal::GetCapturedStderr() + testing::internal::GetCapturedStdout();
      EXPECT_NE(told.find("journal.jsonl:2 was damaged"), std::string::npos) << told;
      EXPECT_NE(told.find("journal.jsonl:4 was damaged"), std::string::npos) << told;
      ASSERT_EQ(journal.entries().size(), 2U);
      EXPECT_EQ(journal.entries()[1].at("key"), "b");
      journal.append({{"key", "c"}});
    }
    EXPECT_EQ(read(path), "{\"key\":\"a\"}\n{\"key\":\"b\"}\n{\"key\":\"c\"}\n");
  }
}

TEST(Journal, ReadingAloneChangesNothing) {
  const core::TemporaryFolder folder;
  const std::filesystem::path path = folder.path() / "journal.jsonl";
  const std::string text = "{\"key\":\"a\"}\n[1]\n{\"key\":\"b\"}\n{\"key\":\"being written";
  write(path, text);
  const JournalLines lines = read_journal(path);
  EXPECT_EQ(lines.entries, (std::vector<json>{{{"key", "a"}}, {{"key", "b"}}}));
  EXPECT_EQ(lines.text, "{\"key\":\"a\"}\n{\"key\":\"b\"}\n");
  EXPECT_EQ(lines.damaged, (std::vector<std::size_t>{2}));
  EXPECT_EQ(read(path), text);
  EXPECT_THROW(read_journal(folder.path() / "none"), core::FileError);
}

TEST(Journal, OnlyObjectsAreEntriesAndBadTextIsMended) {
  const core::TemporaryFolder folder;
  const std::filesystem::path path = folder.path() / "journal.jsonl";
  {
    Journal journal(path);
    EXPECT_THROW(journal.append(json(3)), core::Error);
    journal.append({{"message", "bad \xff byte"}});
  }
  const Journal again(path);
  ASSERT_EQ(again.entries().size(), 1U);
  EXPECT_EQ(again.entries()[0].at("message"), "bad \xef\xbf\xbd byte");
}

TEST(Journal, NamesWhatCannotBeOpened) {
  const core::TemporaryFolder folder;
  EXPECT_EQ(message_of_opening(folder.path()),
            folder.path().string() + ": cannot be opened: Is a directory");
}

// A limit on the size of files stands in for a full disk: the write stops in the middle of a line.
TEST(Journal, AFullDiskLeavesNoHalfLine) {
  const core::TemporaryFolder folder;
  const std::filesystem::path path = folder.path() / "journal.jsonl";
  const pid_t child = fork();
  if (child == 0) {
    std::signal(SIGXFSZ, SIG_IGN);
    const rlimit limit{40, 40};
    setrlimit(RLIMIT_FSIZE, &limit);
    Journal journal(path);
    journal.append({{"key", "fits"}});
    int code = 1;
    try {
      journal.append({{"key", std::string(100, 'x')}});
    } catch (const core::FileError&) {
      code = 42;
    }
    journal.append({{"key", "too"}});
    _exit(code);
  }
  int status = 0;
  waitpid(child, &status, 0);
  EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 42);
  EXPECT_EQ(read(path), "{\"key\":\"fits\"}\n{\"key\":\"too\"}\n");
}

}  // namespace
}  // namespace carillon::mpi
