#include "dataset/run/costs.hpp"

#include <gtest/gtest.h>

#include "dataset/plan/expected_mesh.hpp"
#include "dataset/plan/task_times.hpp"

namespace carillon::dataset {
namespace {

std::vector<mpi::Task> tasks_of(const std::string& text) {
  const configuration::BuildConfig config =
      configuration::read_build_config("name: x\nmaterials: [steel]\n" + text, "x.yaml", {});
  return run::board_tasks(plan::make_plan(config), config);
}

TEST(GroupWidth, FollowsUnknownsAlone) {
  configuration::RanksConfig ranks;
  ranks.unknowns_per_rank = 1000;
  ranks.widest_group = 12;
  EXPECT_EQ(configuration::group_width(ranks, 10), 1);
  EXPECT_EQ(configuration::group_width(ranks, 1000), 1);
  EXPECT_EQ(configuration::group_width(ranks, 1001), 2);
  EXPECT_EQ(configuration::group_width(ranks, 3999), 4);
  EXPECT_EQ(configuration::group_width(ranks, 8001), 12);
  EXPECT_EQ(configuration::group_width(ranks, 1e9), 12);
}

TEST(ExpectedObject, KnowsSizesBeforeMeshing) {
  // A box of 200 x 100 x 10 mm, and unknowns that `carillon modes tile:... --order 2
  // --element-size 20mm` has: 12 x 6 cells of a diagonal of 20 mm in one layer.
  plan::Shape shape;
  shape.request.shape = {"tile", {{"length", 0.2}, {"width", 0.1}, {"thickness", 0.01}}, {}};
  shape.request.options.order = 2;
  shape.request.options.element_size = 0.02;
  const plan::ExpectedObject body = plan::expected_object(shape);
  EXPECT_NEAR(body.extent.volume, 2e-4, 1e-12);
  EXPECT_NEAR(body.extent.longest_side, 0.2, 1e-12);
  const double cells = std::ceil(0.2 / 0.01225) * std::ceil(0.1 / 0.01225);
  EXPECT_NEAR(body.mesh.unknowns() / (3 * cells * 4 * 3), 1, 0.3);
}

TEST(ExpectedObject, FilesThatCannotBeReadAreOfMiddlingSize) {
  plan::Shape shape;
  shape.path = shape.request.file.path = "/nowhere/cup.stl";
  EXPECT_GT(plan::expected_object(shape).mesh.unknowns(), 100);
}

TEST(Costs, WidthsAndKinds) {
  const std::string text =
      "objects:\n  - {shape: tile, name: large, parameters: {length: 25 cm, width: 25 cm}}\n"
      "  - {shape: bar, name: small}\nmodes: {order: 2, element_size: 10 mm}\n"
      "solver: {pitch_cents: off}\n";
  const auto alone = tasks_of(text);
  const auto wide = tasks_of(text + "ranks: {unknowns_per_rank: 20000, widest_group: 4}\n");
  ASSERT_EQ(alone.size(), 4u);
  EXPECT_EQ(alone[0].width, 1);
  EXPECT_EQ(alone[0].kind, "modes");
  EXPECT_EQ(wide[0].width, 4);
  EXPECT_EQ(wide[0].kind, "modes of groups");
  EXPECT_EQ(wide[1].width, 1);
  EXPECT_EQ(wide[2].kind, "samples");
  EXPECT_EQ(wide[2].width, 1);
  EXPECT_EQ(wide[0].cost, alone[0].cost);
  EXPECT_GT(wide[0].cost, wide[1].cost);
  EXPECT_GT(wide[0].memory, wide[1].memory);
}

TEST(Costs, AMemoryLimitBoundsTheEstimate) {
  const std::string text =
      "objects: [{shape: block}]\nmodes: {element_size: 2 mm, max_elements: 1000000}\n"
      "ranks: {widest_group: 1}\n";
  EXPECT_LT(tasks_of(text + "solver: {memory_limit: 1 GiB}\n")[0].memory, 1.5e9);
  EXPECT_GT(tasks_of(text + "solver: {memory_limit: 4 GiB}\n")[0].memory, 2e9);
}

TEST(Ranks, MemoryOfANodeIsNoPartOfTheDataset) {
  const std::string text = "name: x\nmaterials: [steel]\nobjects: [{shape: bar}]\n";
  const auto config =
      configuration::read_build_config(text, "x.yaml", {"ranks.memory_per_node=3 GiB"});
  EXPECT_EQ(config.ranks.memory_per_node, 3ll << 30);
  EXPECT_EQ(config.resolved, configuration::read_build_config(text, "x.yaml", {}).resolved);
  EXPECT_NE(config.resolved.find("unknowns_per_rank"), std::string::npos);
  EXPECT_EQ(config.resolved.find("memory_per_node"), std::string::npos);
}

TEST(BusyShare, CountsComputingAgainstHavingNoTask) {
  const auto row = [](double start, double seconds, double cpu, double queued) {
    return plan::TaskRow{
        .run = 1, .times = {.start = start, .seconds = seconds, .cpu = cpu, .queued = queued}};
  };
  // Two ranks until the last task begins at 10 s: one without a break, one idle for 2 s, of which
  // it was kept from a processor for 1 s.
  const std::vector<plan::TaskRow> rows{row(0, 10, 10, 0), row(0, 4, 3, 1), row(6, 8, 8, 0),
                                        row(10, 5, 5, 0)};
  std::vector<mpi::RankTimes> ranks(2);
  EXPECT_NEAR(plan::busy_fraction(rows, 1, ranks), 17.0 / 19, 1e-12);
  ranks[1].queued = 2;
  EXPECT_NEAR(plan::busy_fraction(rows, 1, ranks), 17.0 / 18, 1e-12);
  EXPECT_EQ(plan::busy_fraction(rows, 2, ranks), 1);
  // Strictly: 17 of 20 s, of which others took 2.
  EXPECT_NEAR(plan::computing_fraction(rows, 1, ranks), 17.0 / 18, 1e-12);
  ranks[1].queued = 0;
  EXPECT_NEAR(plan::computing_fraction(rows, 1, ranks), 17.0 / 20, 1e-12);
  EXPECT_EQ(plan::computing_fraction(rows, 2, ranks), 1);
  // What a task waits for within itself shows there alone.
  const std::vector<plan::TaskRow> waits{row(0, 10, 5, 0), row(10, 1, 1, 0)};
  EXPECT_EQ(plan::busy_fraction(waits, 1, std::vector<mpi::RankTimes>(1)), 1);
  EXPECT_NEAR(plan::computing_fraction(waits, 1, std::vector<mpi::RankTimes>(1)), 0.5, 1e-12);
  // Others took 4 s of a task of which a half lies before the last one's beginning.
  const std::vector<plan::TaskRow> taken{row(0, 20, 16, 4), row(10, 1, 1, 0)};
  std::vector<mpi::RankTimes> two(2);
  two[0].queued = 4;
  EXPECT_NEAR(plan::computing_fraction(taken, 1, two), 8.0 / 18, 1e-12);

  // A group of two computes 12 s in 10, is kept from processors for 2 s, and waits for itself 6 s.
  plan::TaskRow wide = row(0, 10, 12, 2);
  wide.times.width = 2;
  EXPECT_NEAR(plan::busy_fraction({wide, row(10, 1, 1, 0)}, 1, std::vector<mpi::RankTimes>(2)),
              12.0 / 18, 1e-12);
}

TEST(RunText, TellsWhatEachRankWasIdle) {
  const auto text_of = [](std::size_t ranks) {
    plan::RunRecord run{.busy_fraction = 0.75, .computing_fraction = 0.5};
    for (std::size_t r = 0; r < ranks; ++r) {
      run.ranks.push_back({.busy = 20, .idle = 0.4 + double((r * 7) % ranks)});
    }
    return plan::run_text(run);
  };
  EXPECT_EQ(text_of(2),
            "21 s on 2 ranks, busy 75.0 % of the time until the last task began, computing 50.0 %\n"
            "idle: rank 0 0.4 s, rank 1 1.4 s\n");
  // Rank r is idle for (7 r mod 9) s and 0.4: 4 s make rank 7, 8 s rank 5.
  EXPECT_NE(text_of(9).find("idle: least rank 0 0.4 s, median rank 7 4.4 s, most rank 5 8.4 s\n"),
            std::string::npos)
      << text_of(9);
}

}  // namespace
}  // namespace carillon::dataset
