// The folder lock against a second build in this program and against flock(1).
#include "mpi/folder_lock.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <csignal>
#include <fstream>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/error.hpp"
#include "core/temporary_folder.hpp"
#include "mpi/comm.hpp"
#include "tests/mpi/busy.hpp"

namespace carillon::mpi {
namespace {

const MPI_Comm world = MPI_COMM_WORLD;

/// One folder for all ranks, made by rank 0.
class FolderLockTest : public testing::Test {
 protected:
  FolderLockTest() {
    if (rank(world) == 0) made_.emplace();
    folder = broadcast(made_ ? made_->path().string() : "", 0, world);
  }
  // Everybody is done with the folder before it goes.
  ~FolderLockTest() override { MPI_Barrier(world); }

  std::string message_of_locking(const std::filesystem::path& path) {
    try {
      const FolderLock lock(path, world);
      MPI_Barrier(world);
    } catch (const core::FileError& e) {
      return e.message();
    }
    return "locked";
  }

  std::filesystem::path folder;

 private:
  std::optional<core::TemporaryFolder> made_;
};

pid_t start(std::vector<std::string> words) {
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  pid_t child = 0;
  EXPECT_EQ(posix_spawnp(&child, arguments[0], nullptr, nullptr, arguments.data(), environ), 0);
  return child;
}

int exit_code(pid_t child) {
  int status = 0;
  waitpid(child, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

/// What another program finds.
bool another_could_lock(const std::filesystem::path& folder) {
  return exit_code(start({"flock", "-n", "-x", (folder / ".lock").string(), "true"})) == 0;
}

TEST_F(FolderLockTest, ASecondBuildIsRefusedOnEveryRankAndNamesTheFirst) {
  {
    const FolderLock first(folder, world);
    std::array<char, 256> host{};
    gethostname(host.data(), host.size() - 1);
    const std::string pid = broadcast(std::to_string(getpid()), 0, world);
    const std::string message = message_of_locking(folder);
    EXPECT_TRUE(message.starts_with(folder.string() +
                                    ": another build is writing to this folder (" +
                                    (size(world) > 1 ? "processes " : "process ")))
        << message;
    EXPECT_NE(message.find(" " + pid), std::string::npos) << message;
    EXPECT_TRUE(message.ends_with(std::string(" on ") + host.data() + ")")) << message;
    MPI_Barrier(world);
  }
  MPI_Barrier(world);
  EXPECT_EQ(message_of_locking(folder), "locked");
}

TEST_F(FolderLockTest, IsHeldWhileAnyRankLives) {
  auto lock = std::make_unique<FolderLock>(folder, world);
  for (int leaving = 0; leaving < size(world); ++leaving) {
    if (rank(world) == 0) {
      EXPECT_FALSE(another_could_lock(folder)) << leaving << " ranks have left";
    }
    MPI_Barrier(world);
    if (rank(world) == leaving) lock.reset();
    MPI_Barrier(world);
  }
  if (rank(world) == 0) {
    EXPECT_TRUE(another_could_lock(folder));
  }
}

TEST_F(FolderLockTest, ChildProgramsDoNotInheritIt) {
  pid_t child = 0;
  {
    const FolderLock lock(folder, world);
    child = start({"sleep", "60"});
    MPI_Barrier(world);
  }
  MPI_Barrier(world);
  // A spawned program closes what it does not inherit a moment after it counts as started.
  for (int i = 0; rank(world) == 0 && i < 100 && !another_could_lock(folder); ++i) sleep_for(0.01);
  EXPECT_EQ(message_of_locking(folder), "locked");
  kill(child, SIGKILL);
  waitpid(child, nullptr, 0);
}

TEST_F(FolderLockTest, DiesWithTheProcessThatHeldIt) {
  pid_t holder = 0;
  if (rank(world) == 0) {
    holder = start({"flock", "-x", "-F", (folder / ".lock").string(), "sleep", "60"});
    // Until it has the lock; a second is what a loaded machine may need.
    for (int i = 0; i < 500 && another_could_lock(folder); ++i) sleep_for(0.02);
  }
  MPI_Barrier(world);
  EXPECT_TRUE(message_of_locking(folder).starts_with(folder.string() +
                                                     ": another build is writing to this folder"));
  if (rank(world) == 0) {
    kill(holder, SIGKILL);
    waitpid(holder, nullptr, 0);
  }
  MPI_Barrier(world);
  EXPECT_EQ(message_of_locking(folder), "locked");
}

TEST_F(FolderLockTest, WaitsForAHolderThatLeaves) {
  pid_t holder = 0;
  if (rank(world) == 0) {
    holder = start({"flock", "-x", "-F", (folder / ".lock").string(), "sleep", "0.5"});
    for (int i = 0; i < 500 && another_could_lock(folder); ++i) sleep_for(0.01);
  }
  MPI_Barrier(world);
  EXPECT_NO_THROW(FolderLock(folder, world, 30));
  MPI_Barrier(world);
  if (rank(world) == 0) waitpid(holder, nullptr, 0);
}

TEST_F(FolderLockTest, MakesAMissingFolderAndSaysWhenItCannot) {
  EXPECT_EQ(message_of_locking(folder / "a" / "b"), "locked");
  if (rank(world) == 0) std::ofstream(folder / "file") << "x";
  const std::string message = message_of_locking(folder / "file");
  EXPECT_EQ(message.substr(0, message.find(": ")), (folder / "file").string());
  EXPECT_NE(message, "locked");
}

}  // namespace
}  // namespace carillon::mpi
