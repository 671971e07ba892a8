// Who is to blame for a run's end, and who merely ran beside it.
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <set>

#include "mpi/blame.hpp"

namespace carillon::mpi {
namespace {

using End = Testimony::End;
using Evidence = Blame::Evidence;

Testimony told(const std::string& task, End end, const std::string& words = "",
               const Host& host = {"a", "boot-1", 4}) {
  Testimony one;
  one.process = "process of " + task;
  one.ranks = 3;
  one.task = task;
  one.stage = "solve";
  one.host = host;
  one.end = end;
  one.words = words;
  return one;
}

const std::vector<Host> calm = {{"a", "boot-1", 4}};
const std::vector<Host> starved = {{"a", "boot-1", 5}};

TEST(Blame, ACrashSpeaksForItself) {
  const auto blamed = blamed_tasks(
      {told("one", End::stopped), told("two", End::crashed, "SIGSEGV"), told("three", End::silent)},
      calm);
  ASSERT_EQ(blamed.size(), 1U);
  EXPECT_EQ(blamed[0].task, "two");
  EXPECT_EQ(blamed[0].evidence, Evidence::crash);
  EXPECT_EQ(blamed[0].words, "SIGSEGV");
  EXPECT_EQ(blamed[0].stage, "solve");
}

TEST(Blame, AnOverdueTaskSaysWhy) {
  const auto blamed =
      blamed_tasks({told("one", End::overdue, "too long"), told("two", End::stopped)}, calm);
  ASSERT_EQ(blamed.size(), 1U);
  EXPECT_EQ(blamed[0].evidence, Evidence::overdue);
  EXPECT_EQ(blamed[0].words, "too long");
}

TEST(Blame, AllKilledTogetherBlamesNobody) {
  EXPECT_TRUE(blamed_tasks({told("one", End::silent), told("two", End::silent)}, calm).empty());
  // A machine that started anew, or another one, cannot be asked; and still they fell together.
  EXPECT_TRUE(blamed_tasks({told("one", End::silent), told("two", End::silent)},
                           {{"a", "boot-2", 0}, {"b", "boot-1", 9}})
                  .empty());
}

TEST(Blame, WithoutMemoryTheLargestIsBlamed) {
  auto small = told("small", End::silent), large = told("large", End::silent);
  auto stopped = told("largest", End::stopped);
  small.resident = 100;
  large.resident = 200;
  stopped.resident = 300;
  const auto blamed = blamed_tasks({small, stopped, large}, starved);
  ASSERT_EQ(blamed.size(), 1U);
  EXPECT_EQ(blamed[0].task, "large");
  EXPECT_EQ(blamed[0].evidence, Evidence::memory);
}

TEST(Blame, OneSilentEndAmongStoppedOnesIsNoted) {
  const auto blamed = blamed_tasks({told("one", End::stopped), told("two", End::silent)}, calm);
  ASSERT_EQ(blamed.size(), 1U);
  EXPECT_EQ(blamed[0].task, "two");
  EXPECT_EQ(blamed[0].evidence, Evidence::silence);
  // The ranks of one group run one task.
  EXPECT_EQ(blamed_tasks({told("two", End::silent), told("two", End::silent)}, calm).size(), 1U);
}

TEST(Blame, HostsAreToldApart) {
  EXPECT_EQ(oom_kills_between({"a", "boot", 3}, {"a", "boot", 5}), 2);
  EXPECT_EQ(oom_kills_between({"a", "boot", 3}, {"b", "boot", 5}), -1);
  EXPECT_EQ(oom_kills_between({"a", "boot", 3}, {"a", "other", 5}), -1);
  EXPECT_EQ(oom_kills_between({"a", "", 3}, {"a", "", 5}), -1);
  EXPECT_EQ(oom_kills_between({"a", "boot", -1}, {"a", "boot", 5}), -1);
  EXPECT_EQ(oom_kills_between({"a", "boot", 5}, {"a", "boot", -1}), -1);
  // A neighbour's loss on the same machine is not the group's; another group cannot tell.
  EXPECT_EQ(oom_kills_between({"a", "boot", 3, "job 1", 0}, {"a", "boot", 5, "job 1", 0}), 0);
  EXPECT_EQ(oom_kills_between({"a", "boot", 3, "job 1", 0}, {"a", "boot", 5, "job 1", 1}), 1);
  EXPECT_EQ(oom_kills_between({"a", "boot", 3, "job 1", 0}, {"a", "boot", 5, "job 2", 0}), 2);
  EXPECT_EQ(oom_kills_between({"a", "boot", 3}, {"a", "boot", 5, "job 1", 0}), 2);
  EXPECT_EQ(oom_kills_between({"a", "boot", 3, "job 1", 0}, {"b", "boot", 5, "job 1", 1}), -1);
  const Host here = this_host();
  EXPECT_EQ(host_from_json(to_json(here)), here);
  EXPECT_FALSE(here.name.empty());
  EXPECT_EQ(oom_kills_between(here, this_host()),
            here.oom_kills < 0 && here.group.empty() ? -1 : 0);
  const ProcessMemory before = process_memory();
  EXPECT_GT(before.resident, 1 << 20);
  const std::vector<char> more(64 << 20, 1);
  asm volatile("" : : "r"(more.data()) : "memory");  // or the optimiser leaves it out
  EXPECT_NEAR(static_cast<double>(process_memory().resident - before.resident), 64 << 20, 4 << 20);
  EXPECT_NEAR(static_cast<double>(process_memory().data - before.data), 64 << 20, 4 << 20);
}

/// Whatever they say: each task is blamed once, nobody who was asked to stop is, and whoever
/// crashed always is.
RC_GTEST_PROP(Blame, IsJust, ()) {
  const auto ends = *rc::gen::container<std::vector<int>>(rc::gen::inRange(0, 4));
  std::vector<Testimony> all;
  std::set<std::string> guilty, stopped;
  for (std::size_t i = 0; i < ends.size(); ++i) {
    const std::string task = std::to_string(i);
    const auto end = static_cast<End>(ends[i]);
    all.push_back(told(task, end, "words"));
    all.back().resident = *rc::gen::inRange(0, 1000);
    if (end == End::crashed || end == End::overdue) guilty.insert(task);
    if (end == End::stopped) stopped.insert(task);
  }
  std::set<std::string> blamed;
  for (const Blame& one : blamed_tasks(all, *rc::gen::element(calm, starved))) {
    RC_ASSERT(blamed.insert(one.task).second);
    RC_ASSERT(!stopped.contains(one.task));
  }
  RC_ASSERT(std::includes(blamed.begin(), blamed.end(), guilty.begin(), guilty.end()));
  RC_ASSERT(blamed.size() <= guilty.size() + 1);
}

}  // namespace
}  // namespace carillon::mpi
