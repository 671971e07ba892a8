#include "dataset/sweep/detail/shared_work.hpp"

#include <gtest/gtest.h>

namespace carillon::dataset {
namespace {

run::LoadedBuild build_of(const std::vector<std::string>& overrides) {
  run::BuildOptions options;
  options.config = "s.yaml";
  options.overrides = overrides;
  run::LoadedBuild build = run::read_build(
      "objects:\n  - shape: bar\n    count: 2\nmaterials: [steel]\nstrikes: {per_object: 1}\n",
      options);
  build.plan = plan::make_plan(build.config);
  return build;
}

std::vector<run::BuildRun> runs_of(const std::vector<run::LoadedBuild>& builds) {
  std::vector<run::BuildRun> runs;
  for (const run::LoadedBuild& build : builds) runs.push_back({build, {}, ""});
  return runs;
}

std::vector<std::int64_t> behind(const std::vector<run::LoadedBuild>& builds, std::size_t task) {
  const std::vector<run::BuildRun> runs = runs_of(builds);
  run::CommonTasks common = run::common_tasks(runs);
  sweep::order_shared_work(runs, common);
  return common.tasks[task].behind;
}

// Tasks of each build: modes of bar-000 and bar-001, then their samples.

TEST(SharedWork, WhatOnlyTheSoundChangesSharesMeshAndModes) {
  const std::vector<run::LoadedBuild> builds = {build_of({}), build_of({"audio.seconds=0.5"}),
                                                build_of({"effects.damping=off"})};
  const sweep::SharingCounts counts = sweep::count_shared_work(builds);
  EXPECT_EQ(counts.objects, 6u);
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
        "solver.pitch_cents=7", "objects[0].sizes=[2]", "materials=[glass]"}) {
    const sweep::SharingCounts counts = sweep::count_shared_work({build_of({}), build_of({other})});
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
    const sweep::SharingCounts counts = sweep::count_shared_work({build_of({}), build_of({other})});
    EXPECT_EQ(counts.meshes, 4u) << other;
    EXPECT_EQ(counts.solves, 4u) << other;
  }
}

TEST(SharedWork, WiderGroupsGoFirst) {
  const std::vector<run::LoadedBuild> builds = {build_of({}), build_of({"audio.seconds=2"})};
  run::CommonTasks common = run::common_tasks(runs_of(builds));
  common.tasks[4].width = 2;
  sweep::order_shared_work(runs_of(builds), common);
  EXPECT_TRUE(common.tasks[4].behind.empty());
  EXPECT_EQ(common.tasks[0].behind, (std::vector<std::int64_t>{4}));
}

TEST(SharedWork, WhatIsDoneLeadsNobody) {
  // Its cache may be gone: the first of the others makes anew what they share.
  const std::vector<run::LoadedBuild> builds = {build_of({}), build_of({"audio.seconds=2"}),
                                                build_of({"audio.seconds=3"})};
  run::CommonTasks common = run::common_tasks(runs_of(builds));
  common.done[0] = true;
  sweep::order_shared_work(runs_of(builds), common);
  EXPECT_TRUE(common.tasks[4].behind.empty());
  EXPECT_EQ(common.tasks[8].behind, (std::vector<std::int64_t>{4}));
  EXPECT_EQ(common.tasks[4].kind, "modes");
  EXPECT_EQ(common.tasks[8].kind, "modes from cache");
}

TEST(SharedWork, TasksFailTogetherWhereTheyDoTheSameUnderTheSameLimits) {
  const std::vector<run::LoadedBuild> builds = {
      build_of({}), build_of({"modes.max_modes=9"}), build_of({"audio.seconds=2"}),
      build_of({"limits.mesh_time=9 s"}), build_of({"limits.mesh_time=9 s", "audio.seconds=2"})};
  run::CommonTasks common = run::common_tasks(runs_of(builds));
  run::SameWork same = sweep::order_shared_work(runs_of(builds), common);
  // Modes of the first object: tasks 0, 4, 8, 12, 16.
  using Numbers = std::vector<std::int64_t>;
  EXPECT_EQ((same[{0, "mesh"}]), (Numbers{4, 8}));
  EXPECT_EQ((same[{0, "solve"}]), (Numbers{8}));
  EXPECT_EQ((same[{12, "mesh"}]), (Numbers{16})) << "another limit is another try";
  EXPECT_EQ((same[{12, "solve"}]), (Numbers{16}));
  EXPECT_EQ(common.tasks[16].behind, (Numbers{0, 12}));
}

}  // namespace
}  // namespace carillon::dataset
