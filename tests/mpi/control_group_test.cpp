// What control groups leave, in trees of files as the kernel shows them.
#include "mpi/detail/control_group.hpp"

#include <gtest/gtest.h>

#include <fstream>
#include <limits>

#include "core/temporary_folder.hpp"

namespace carillon::mpi {
namespace {

constexpr std::int64_t unbounded = std::numeric_limits<std::int64_t>::max();

class ControlGroup : public ::testing::Test {
 protected:
  void write(const std::string& path, const std::string& text) const {
    const auto file = folder_.path() / path;
    std::filesystem::create_directories(file.parent_path());
    std::ofstream(file) << text;
  }
  std::int64_t left() const { return memory_left_in_groups(folder_.path()); }

  core::TemporaryFolder folder_;
};

TEST_F(ControlGroup, NoneHasNoBounds) {
  EXPECT_EQ(left(), unbounded);
  write("proc/self/cgroup", "0::/a\n");
  write("sys/fs/cgroup/a/memory.max", "max\n");
  write("sys/fs/cgroup/a/memory.current", "1000\n");
  EXPECT_EQ(left(), unbounded);
}

/// A container that has written files: they are in memory, and go when it is wanted.
TEST_F(ControlGroup, KeptFilesAreFree) {
  write("proc/self/cgroup", "0::/\n");
  write("sys/fs/cgroup/memory.max", "1000\n");
  write("sys/fs/cgroup/memory.current", "1000\n");
  EXPECT_EQ(left(), 0);
  write("sys/fs/cgroup/memory.stat",
        "anon 300\nfile 700\nshmem 50\ninactive_anon 300\ninactive_file 450\nactive_file 200\n");
  EXPECT_EQ(left(), 650);
}

TEST_F(ControlGroup, TheNarrowestAboveCounts) {
  write("proc/self/cgroup", "0::/job/step/task\n");
  write("sys/fs/cgroup/job/memory.max", "1000\n");
  write("sys/fs/cgroup/job/memory.current", "900\n");
  write("sys/fs/cgroup/job/step/memory.max", "500\n");
  write("sys/fs/cgroup/job/step/memory.current", "300\n");
  write("sys/fs/cgroup/job/step/task/memory.max", "max\n");
  write("sys/fs/cgroup/job/step/task/memory.current", "300\n");
  EXPECT_EQ(left(), 100);
}

TEST_F(ControlGroup, VersionOneIsReadToo) {
  write("proc/self/cgroup", "5:cpu,cpuacct:/job\n4:memory:/job\n1:name=systemd:/\n0::/\n");
  write("sys/fs/cgroup/memory/job/memory.limit_in_bytes", "1000\n");
  write("sys/fs/cgroup/memory/job/memory.usage_in_bytes", "800\n");
  write("sys/fs/cgroup/memory/memory.limit_in_bytes", "9223372036854771712\n");
  write("sys/fs/cgroup/memory/memory.usage_in_bytes", "5000\n");
  EXPECT_EQ(left(), 200);
  write("sys/fs/cgroup/memory/job/memory.stat",
        "inactive_file 1\nactive_file 1\ntotal_inactive_file 100\ntotal_active_file 50\n");
  EXPECT_EQ(left(), 350);
}

/// In a container of version 1 the group's name is the host's, its files lie at the top.
TEST_F(ControlGroup, AContainerShowsItsGroupAtTheTop) {
  write("proc/self/cgroup", "4:memory:/docker/0123\n");
  write("sys/fs/cgroup/memory/memory.limit_in_bytes", "1000\n");
  write("sys/fs/cgroup/memory/memory.usage_in_bytes", "400\n");
  EXPECT_EQ(left(), 600);
}

}  // namespace
}  // namespace carillon::mpi
