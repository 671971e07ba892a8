// Simulated builds: which times count, and what is counted.
#include "dataset/run/schedule.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "core/error.hpp"
#include "core/temporary_folder.hpp"
#include "dataset/run/costs.hpp"
#include "dataset/run/detail/measured_times.hpp"

namespace carillon::dataset {
namespace {

run::LoadedBuild bars(int strikes) {
  run::LoadedBuild build;
  build.config = configuration::read_build_config(
      "objects:\n  - {shape: bar, materials: [steel], count: 2}\nfiles: {wav: true}\n"
      "solver: {pitch_cents: off}\n"
      "strikes: {per_object: " +
          std::to_string(strikes) + "}\n",
      "test.yaml", {});
  build.plan = plan::make_plan(build.config);
  return build;
}

class ScheduleTest : public testing::Test {
 protected:
  void write(const std::string& name, const std::string& text) const {
    std::ofstream(folder_ / name) << text;
  }
  const core::TemporaryFolder temporary_;
  const std::filesystem::path& folder_ = temporary_.path();
};

TEST_F(ScheduleTest, SameTasksTakeWhatTheyTookAndOthersTheRatioOfTheirKind) {
  const std::vector<mpi::Task> tasks{
      {.key = "a", .cost = 10, .kind = "modes"},
      {.key = "b", .cost = 40, .width = 2, .kind = "modes of groups"},
      {.key = "c", .cost = 4, .kind = "samples"},
      {.key = "d", .cost = 1, .kind = "samples"},
      {.key = "e", .cost = 4, .kind = "samples"},
      {.key = "f", .cost = 1, .kind = "samples"}};
  const run::MeasuredTimes measured{{"a", {10, 30, "modes"}},
                                    {"gone", {10, 10, "modes"}},
                                    {"c", {2, 1, "samples"}},  // another piece of work
                                    {"d", {1, 2, "samples"}}};
  const run::TaskSeconds times = run::expected_seconds(tasks, measured);
  EXPECT_EQ(times.measured, 2u);
  EXPECT_DOUBLE_EQ(times.ratio.at("modes"), 2);
  EXPECT_DOUBLE_EQ(times.ratio.at("samples"), 1);
  EXPECT_EQ(times.seconds, (std::vector<double>{30, 40, 4, 2, 4, 1}));
}

TEST_F(ScheduleTest, WithoutMeasuredTimesEstimatesCount) {
  const run::TaskSeconds times =
      run::expected_seconds({{.key = "a", .cost = 5, .kind = "modes"},
                             {.key = "b", .cost = 2, .kind = "modes from cache"}},
                            {});
  EXPECT_EQ(times.measured, 0u);
  EXPECT_EQ(times.seconds, (std::vector<double>{5, 2}));
  EXPECT_EQ(times.ratio.at("samples"), 1);
  EXPECT_EQ(times.ratio.at("modes from cache"), 1);
}

TEST_F(ScheduleTest, ReadsTheTasksOfATrace) {
  write("trace.json", R"({"tasks": [{"task": "modes/bar-000", "estimate_s": 2, "seconds": 3}]})");
  for (const auto& path : {folder_, folder_ / "trace.json"}) {
    const run::MeasuredTimes times = run::read_measured_times(path);
    ASSERT_EQ(times.size(), 1u);
    EXPECT_EQ(times.at("modes/bar-000").estimate, 2);
    EXPECT_EQ(times.at("modes/bar-000").seconds, 3);
  }
}

TEST_F(ScheduleTest, WhatOthersTookOfTheProcessorsIsTakenOff) {
  write("trace.json", R"({"tasks": [
    {"task": "x=1/modes/a", "kind": "modes from cache", "estimate_s": 2, "seconds": 3, "queued_s": 1},
    {"task": "modes/b", "estimate_s": 2, "seconds": 3, "queued_s": 2, "width": 2}]})");
  const run::MeasuredTimes times = run::read_measured_times(folder_);
  EXPECT_EQ(times.at("x=1/modes/a").seconds, 2);
  EXPECT_EQ(times.at("x=1/modes/a").kind, "modes from cache");
  EXPECT_EQ(times.at("modes/b").seconds, 2);
  EXPECT_EQ(times.at("modes/b").kind, "modes");
  std::filesystem::remove(folder_ / "trace.json");
  // A build that was cut off has its journal alone.
  write("configuration.yaml", bars(3).config.resolved);
  const std::string line = R"({"task": "modes/bar-000", "ok": true, "seconds": 3, )"
                           R"("times": {"seconds": 3.5, "queued_s": 1, "width": 1}})";
  write("journal.jsonl", line + "\n");
  EXPECT_EQ(run::read_measured_times(folder_).at("modes/bar-000").seconds, 2.5);
}

TEST_F(ScheduleTest, ReadsTheJournalOfAnOlderBuild) {
  const run::LoadedBuild build = bars(3);
  write("trace.json", R"({"stages": {}})");
  write("configuration.yaml", build.config.resolved);
  write("journal.jsonl", R"({"task": "modes/bar-000", "ok": true, "seconds": 3})"
                         "\n"
                         R"({"task": "modes/bar-001", "ok": false, "seconds": 9})"
                         "\n"
                         R"({"task": "samples/bar-0)");
  const run::MeasuredTimes times = run::read_measured_times(folder_);
  ASSERT_EQ(times.size(), 1u);
  EXPECT_EQ(times.at("modes/bar-000").seconds, 3);
  EXPECT_DOUBLE_EQ(times.at("modes/bar-000").estimate,
                   run::board_tasks(build.plan, build.config).front().cost);
}

TEST_F(ScheduleTest, SaysWhatIsNoTrace) {
  EXPECT_THROW(run::read_measured_times(folder_ / "nowhere"), core::FileError);
  EXPECT_THROW(run::read_measured_times(folder_), core::InputError);
  write("trace.json", "{");
  EXPECT_THROW(run::read_measured_times(folder_), core::InputError);
}

TEST_F(ScheduleTest, CountsFilesAndTellsWhatLimits) {
  const run::SimulatedBuild out =
      run::simulate_build(bars(300), {.ranks = {1, 1000}, .ranks_per_node = 10});
  EXPECT_EQ(out.files.shards, 4u);
  EXPECT_EQ(out.files.wav, 600u);
  EXPECT_EQ(out.files.largest_folder, 300u);
  EXPECT_EQ(out.schedules.at(0).limited_by, "work");
  const run::SimulatedSchedule& many = out.schedules.at(1);
  EXPECT_EQ(run::to_json(out).at("schedules").at(1).at("nodes"), 100);
  EXPECT_EQ(many.limited_by, "longest chain");
  EXPECT_DOUBLE_EQ(many.went.makespan, many.went.longest_chain);
}

TEST_F(ScheduleTest, NodesHaveTheMemoryThatTheConfigurationSays) {
  run::LoadedBuild build = bars(1);
  const std::vector<mpi::Task> tasks = run::board_tasks(build.plan, build.config);
  ASSERT_EQ(tasks.size(), 4u);
  for (const mpi::Task& task : tasks) ASSERT_LT(task.memory, 1 << 30);
  // Both objects at a time, one after the other, none.
  const auto on_two = [&](double memory) {
    const double idle = memory > 1 ? 2 * run::idle_rank_bytes : 0;
    build.config.ranks.memory_per_node = static_cast<std::int64_t>(memory + idle);
    const run::SimulatedBuild out = run::simulate_build(build, {.ranks = {2}});
    const std::string text = run::simulation_text(out);
    EXPECT_EQ(text.find("are refused") != std::string::npos, out.schedules.at(0).went.refused > 0);
    return out.schedules.at(0);
  };
  const mpi::Schedule free = on_two(0).went;
  EXPECT_EQ(free.refused, 0);
  EXPECT_EQ(free.memory_wait, 0);
  EXPECT_EQ(on_two(1e12).went.makespan, free.makespan);
  double maximum = 0;
  for (const mpi::Task& task : tasks) maximum = std::max(maximum, task.memory);
  const run::SimulatedSchedule tight = on_two(maximum + 1);
  EXPECT_EQ(tight.went.refused, 0);
  EXPECT_EQ(tight.limited_by, "memory of nodes");
  EXPECT_NEAR(tight.went.makespan, 2 * free.shared_work, 0.1);
  EXPECT_GT(tight.went.memory_wait, 0);
  EXPECT_LE(tight.went.node_memory, maximum + 1);
  const run::SimulatedSchedule none = on_two(1);
  EXPECT_EQ(none.went.refused, 4);
  EXPECT_EQ(none.last_task, "");
  EXPECT_EQ(none.limited_by, "nothing");
}

}  // namespace
}  // namespace carillon::dataset
