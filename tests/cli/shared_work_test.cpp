#include "cli/sweep/shared_work.hpp"

#include "cli/build/costs.hpp"

#include <gtest/gtest.h>

namespace carillon::cli {
namespace {

LoadedBuild build_of(const std::vector<std::string>& overrides) {
  BuildOptions options;
  options.config = "s.yaml";
  options.overrides = overrides;
  LoadedBuild build = read_build(
      "objects:\n  - shape: bar\n    count: 2\nmaterials: [steel]\nstrikes: {per_object: 1}\n",
      options);
  build.plan = make_plan(build.config);
  return build;
}

std::vector<std::int64_t> behind(const std::vector<LoadedBuild>& builds, std::size_t task) {
  std::vector<BuildRun> runs;
  std::vector<mpi::Task> tasks;
  std::vector<std::size_t> first = {0};
  for (const LoadedBuild& build : builds) {
    runs.push_back({build, {}, ""});
    for (const mpi::Task& one : board_tasks(build.plan, build.config)) tasks.push_back(one);
    first.push_back(tasks.size());
  }
  order_shared_work(runs, tasks, first);
  return tasks[task].behind;
}

// Tasks of each build: modes of bar-000 and bar-001, then their samples.

TEST(SharedWork, WhatOnlyTheSoundChangesSharesMeshAndModes) {
  const std::vector<LoadedBuild> builds = {build_of({}), build_of({"audio.seconds=0.5"}),
                                           build_of({"effects.damping=off"})};
  const SharingCounts counts = count_shared_work(builds);
  EXPECT_EQ(counts.bodies, 6u);
  EXPECT_EQ(counts.meshes, 2u);
  EXPECT_EQ(counts.solves, 2u);
  EXPECT_GT(counts.seconds_saved, 0);
  EXPECT_TRUE(behind(builds, 0).empty());
  EXPECT_EQ(behind(builds, 4), (std::vector<std::int64_t>{0}));
  EXPECT_EQ(behind(builds, 9), (std::vector<std::int64_t>{1}));
  EXPECT_TRUE(behind(builds, 6).empty()) << "samples wait for their own modes alone";
}

TEST(SharedWork, AnotherBandOrSolverSharesTheMeshAlone) {
  for (const char* other :
       {"modes.max_modes=9", "modes.max_frequency=5 kHz", "solver.eigen_solver=krylov_schur",
        "solver.pitch_cents=5", "objects[0].sizes=[2]", "materials=[glass]"}) {
    const SharingCounts counts = count_shared_work({build_of({}), build_of({other})});
    EXPECT_EQ(counts.meshes, 2u) << other;
    EXPECT_EQ(counts.solves, 4u) << other;
  }
  EXPECT_EQ(behind({build_of({}), build_of({"modes.max_modes=9"}),
                    build_of({"modes.max_modes=9", "audio.seconds=2"})},
                   8),
            (std::vector<std::int64_t>{0, 4}))
      << "the mesh from the first, the modes from the second";
}

TEST(SharedWork, AnotherOrderOrSeedSharesNothing) {
  for (const char* other : {"modes.order=2", "modes.element_size=9 mm", "seed=5"}) {
    const SharingCounts counts = count_shared_work({build_of({}), build_of({other})});
    EXPECT_EQ(counts.meshes, 4u) << other;
    EXPECT_EQ(counts.solves, 4u) << other;
  }
}

TEST(SharedWork, WiderGroupsGoFirst) {
  const std::vector<BuildRun> runs = {{build_of({}), {}, ""},
                                      {build_of({"audio.seconds=2"}), {}, ""}};
  std::vector<mpi::Task> tasks(8);
  tasks[4].width = 2;
  order_shared_work(runs, tasks, {0, 4, 8});
  EXPECT_TRUE(tasks[4].behind.empty());
  EXPECT_EQ(tasks[0].behind, (std::vector<std::int64_t>{4}));
}

}  // namespace
}  // namespace carillon::cli
