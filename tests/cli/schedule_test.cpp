// Simulated builds: which times count, and what is counted.
#include "cli/build/schedule.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "cli/build/costs.hpp"
#include "cli/build/measured_times.hpp"
#include "core/error.hpp"

namespace carillon::cli {
namespace {

LoadedBuild bars(int strikes) {
  LoadedBuild build;
  build.config = read_build_config(
      "objects:\n  - {shape: bar, materials: [steel], count: 2}\nfiles: {wav: true}\n"
      "strikes: {per_object: " +
          std::to_string(strikes) + "}\n",
      "test.yaml", {});
  build.plan = make_plan(build.config);
  return build;
}

class ScheduleTest : public testing::Test {
 protected:
  ScheduleTest() { std::filesystem::create_directories(folder_); }
  ~ScheduleTest() override { std::filesystem::remove_all(folder_); }
  void write(const std::string& name, const std::string& text) const {
    std::ofstream(folder_ / name) << text;
  }
  std::filesystem::path folder_ =
      std::filesystem::temp_directory_path() /
      ("schedule-" + std::string(testing::UnitTest::GetInstance()->current_test_info()->name()));
};

TEST_F(ScheduleTest, SameTasksTakeWhatTheyTookAndOthersTheRatioOfTheirKind) {
  const LoadedBuild build = bars(300);  // shards of 256 and 44
  const std::vector<double> estimates{10, 20, 4, 1, 4, 1};
  ASSERT_EQ(build.plan.tasks.size(), estimates.size());
  const MeasuredTimes measured{{"modes/bar-000", {10, 30}},
                               {"modes/gone", {10, 10}},
                               {"samples/bar-000-0000", {2, 1}},  // another piece of work
                               {"samples/bar-000-0001", {1, 2}}};
  const TaskSeconds times = expected_seconds(build.plan, estimates, measured);
  EXPECT_EQ(times.measured, 2u);
  EXPECT_DOUBLE_EQ(times.ratio.at("modes"), 2);
  EXPECT_DOUBLE_EQ(times.ratio.at("samples"), 1);
  EXPECT_EQ(times.seconds, (std::vector<double>{30, 40, 4, 2, 4, 1}));
}

TEST_F(ScheduleTest, WithoutMeasuredTimesEstimatesCount) {
  const TaskSeconds times = expected_seconds(bars(1).plan, {5, 6, 1, 2}, {});
  EXPECT_EQ(times.measured, 0u);
  EXPECT_EQ(times.seconds, (std::vector<double>{5, 6, 1, 2}));
}

TEST_F(ScheduleTest, ReadsTheTasksOfATrace) {
  write("trace.json", R"({"tasks": [{"task": "modes/bar-000", "estimate_s": 2, "seconds": 3}]})");
  for (const auto& path : {folder_, folder_ / "trace.json"}) {
    const MeasuredTimes times = read_measured_times(path);
    ASSERT_EQ(times.size(), 1u);
    EXPECT_EQ(times.at("modes/bar-000").estimate, 2);
    EXPECT_EQ(times.at("modes/bar-000").seconds, 3);
  }
}

TEST_F(ScheduleTest, ReadsTheJournalOfAnOlderBuild) {
  const LoadedBuild build = bars(3);
  write("trace.json", R"({"stages": {}})");
  write("configuration.yaml", build.config.resolved);
  write("journal.jsonl", R"({"task": "modes/bar-000", "ok": true, "seconds": 3})"
                         "\n"
                         R"({"task": "modes/bar-001", "ok": false, "seconds": 9})"
                         "\n"
                         R"({"task": "samples/bar-0)");
  const MeasuredTimes times = read_measured_times(folder_);
  ASSERT_EQ(times.size(), 1u);
  EXPECT_EQ(times.at("modes/bar-000").seconds, 3);
  EXPECT_DOUBLE_EQ(times.at("modes/bar-000").estimate,
                   board_tasks(build.plan, build.config).front().cost);
}

TEST_F(ScheduleTest, SaysWhatIsNoTrace) {
  EXPECT_THROW(read_measured_times(folder_ / "nowhere"), core::FileError);
  EXPECT_THROW(read_measured_times(folder_), core::InputError);
  write("trace.json", "{");
  EXPECT_THROW(read_measured_times(folder_), core::InputError);
}

TEST_F(ScheduleTest, CountsFilesAndTellsWhatLimits) {
  MachineCosts costs;
  costs.service = {};
  costs.start = 1;
  costs.index_shard = 0.5;
  const nlohmann::json out =
      simulate_build(bars(300), {.ranks = {1, 1000}, .ranks_per_node = 10}, costs);
  EXPECT_EQ(out.at("files").at("shards"), 4);
  EXPECT_EQ(out.at("files").at("wav"), 600);
  EXPECT_EQ(out.at("files").at("largest_folder"), 300);
  const nlohmann::json& one = out.at("schedules").at(0);
  EXPECT_EQ(one.at("limited_by"), "work");
  EXPECT_DOUBLE_EQ(one.at("wall_s"), 1 + 2 + one.at("makespan_s").get<double>());
  const nlohmann::json& many = out.at("schedules").at(1);
  EXPECT_EQ(many.at("nodes"), 100);
  EXPECT_EQ(many.at("limited_by"), "longest chain");
  EXPECT_DOUBLE_EQ(many.at("makespan_s"), many.at("longest_chain_s"));
}

}  // namespace
}  // namespace carillon::cli
