#include "cli/build/plan.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <map>
#include <set>

#include "cli/build/costs.hpp"
#include "cli/build/solver_plan.hpp"
#include "cli/sound/scene.hpp"
#include "core/error.hpp"

namespace carillon::cli {
namespace {

BuildConfig config_of(const std::string& text) {
  return read_build_config(text, "test.yaml", {});
}

BuildConfig bars(int count, int strikes, const std::string& more = "") {
  return config_of(
      "objects:\n  - shape: bar\n    materials: [steel, glass]\n    sizes: [1, 2]\n"
      "    count: " +
      std::to_string(count) + "\nstrikes: {per_object: " + std::to_string(strikes) + "}\n" + more);
}

TEST(Plan, CountsShapesVariantsAndStrikes) {
  const BuildPlan plan = make_plan(bars(3, 5));
  EXPECT_EQ(plan.shapes.size(), 3u);
  EXPECT_EQ(plan.samples.size(), 3u * 2 * 2 * 5);
  EXPECT_EQ(plan.tasks.size(), 6u);
  std::set<std::string> keys;
  for (const Sample& sample : plan.samples) keys.insert(sample.key);
  EXPECT_EQ(keys.size(), plan.samples.size());
}

TEST(Plan, TasksHoldAtMost256SamplesOfOneShape) {
  const BuildPlan plan = make_plan(bars(2, 150));
  std::size_t samples = 0;
  for (const BuildTask& task : plan.tasks) {
    if (task.kind != TaskKind::samples) continue;
    EXPECT_LE(task.count, 256u);
    for (std::size_t i = task.first; i < task.first + task.count; ++i) {
      EXPECT_EQ(plan.samples[i].shape, task.shape);
    }
    samples += task.count;
  }
  EXPECT_EQ(samples, plan.samples.size());
  const auto board = board_tasks(plan, bars(2, 150));
  for (std::size_t t = 0; t < board.size(); ++t) {
    EXPECT_EQ(board[t].after.size(), plan.tasks[t].kind == TaskKind::samples ? 1u : 0u);
  }
}

TEST(Plan, GrowingChangesNothingThatExists) {
  const BuildPlan small = make_plan(bars(2, 3));
  const BuildPlan large = make_plan(bars(5, 9));
  std::map<std::string, std::uint64_t> ids;
  for (const Sample& sample : large.samples) ids[sample.key] = sample.id;
  for (const Sample& sample : small.samples) EXPECT_EQ(ids.at(sample.key), sample.id);
  for (std::size_t i = 0; i < small.shapes.size(); ++i) {
    EXPECT_EQ(small.shapes[i].id, large.shapes[i].id);
    EXPECT_EQ(small.shapes[i].split_shape, large.shapes[i].split_shape);
    EXPECT_EQ(small.shapes[i].request.shape.parameters, large.shapes[i].request.shape.parameters);
  }
}

TEST(Plan, SeedsDrawOtherShapesAndZeroIsASeed) {
  const auto parameters = [](const std::string& seed) {
    return make_plan(bars(1, 1, "seed: " + seed + "\n")).shapes[0].request.shape.parameters;
  };
  EXPECT_EQ(parameters("0"), parameters("0"));
  EXPECT_NE(parameters("0"), parameters("1"));
}

TEST(Plan, SplitsHaveTheirShares) {
  const BuildConfig config = bars(2000, 1, "split: {validation: 0.2, test: 0.3}\n");
  std::map<std::string, int> shares;
  for (const Shape& shape : make_plan(config).shapes) ++shares[shape.split_shape];
  EXPECT_NEAR(shares["test"] / 2000.0, 0.3, 0.04);
  EXPECT_NEAR(shares["validation"] / 2000.0, 0.2, 0.04);
  EXPECT_NEAR(shares["train"] / 2000.0, 0.5, 0.04);
}

TEST(Plan, EqualFilesFallIntoOnePart) {
  const std::filesystem::path folder = std::filesystem::path(testing::TempDir()) / "plan-meshes";
  std::filesystem::create_directories(folder);
  for (int i = 0; i < 20; ++i) {
    std::ofstream(folder / ("copy" + std::to_string(i) + ".off")) << "OFF\n0 0 0\n";
  }
  const BuildConfig config = config_of("objects:\n  - mesh: " + (folder / "*.off").string() +
                                       "\n    materials: [steel]\nsplit: {test: 0.5}\n");
  std::set<std::string> parts;
  for (const Shape& shape : make_plan(config).shapes) parts.insert(shape.split_shape);
  EXPECT_EQ(parts.size(), 1u);
  std::filesystem::remove_all(folder);
}

TEST(Plan, NothingMatchedAndDoubleNamesAreErrors) {
  EXPECT_THROW(make_plan(config_of("objects:\n  - mesh: none-*.off\n    materials: [steel]\n")),
               core::InputError);
  EXPECT_THROW(make_plan(config_of("objects:\n  - shape: bar\n    materials: [steel]\n"
                                   "  - shape: bar\n    materials: [glass]\n")),
               core::InputError);
}

TEST(Plan, FingerprintsTellPlansApart) {
  const auto print = [](const BuildConfig& config) {
    return fingerprint(config, make_plan(config));
  };
  EXPECT_EQ(print(bars(2, 2)), print(bars(2, 2)));
  EXPECT_NE(print(bars(2, 2)), print(bars(2, 3)));
  BuildConfig struck = bars(2, 2);
  struck.scene.strikes.given = {{"*", {0, 0, 0}, {}, 0.01, 0.001}};
  const std::string before = print(struck);
  struck.scene.strikes.given[0].impulse = 0.02;
  EXPECT_NE(print(struck), before);
}

TEST(Plan, EffectsAreOffUnlessAskedFor) {
  const auto running = [](const std::string& more) {
    std::set<std::string> names;
    for (const nlohmann::json& effect : describe_effects(bars(1, 1, more).scene, 60)) {
      EXPECT_FALSE(effect.at("reason").get<std::string>().empty()) << effect;
      if (effect.at("enabled").get<bool>()) names.insert(effect.at("name"));
    }
    return names;
  };
  using Names = std::set<std::string>;
  EXPECT_EQ(running(""), (Names{"damping", "contact"}));
  EXPECT_EQ(running("mel: {}\nvoxels: {}\ncamera: {}\n"),
            (Names{"damping", "contact", "mel", "voxels", "frames"}));
  EXPECT_EQ(running("listeners:\n  - position: [0, 0, 1]\n"),
            (Names{"damping", "contact", "radiation", "click"}));
  EXPECT_EQ(running("striker: {kind: metal, speed: 1 m/s}\n"), (Names{"damping", "striker"}));
  // Nobody hears the room.
  EXPECT_EQ(running("room: {size: [5, 4, 3], absorption: 0.2}\n"), (Names{"damping", "contact"}));
}

TEST(Plan, SolverIsShownWithItsReasons) {
  const auto solver = [](const std::string& more) {
    std::map<std::string, nlohmann::json> by_name;
    for (const auto& entry : plan_solver(bars(1, 1, more))) {
      EXPECT_FALSE(entry.at("reason").get<std::string>().empty()) << entry;
      EXPECT_FALSE(entry.at("text").get<std::string>().empty()) << entry;
      by_name[entry.at("name")] = entry;
    }
    return by_name;
  };
  auto usual = solver("");
  EXPECT_EQ(usual["order"]["value"], 3);
  EXPECT_EQ(usual["pitch_target"]["value"], nullptr);
  EXPECT_EQ(usual["element_size"]["value"], nullptr);
  EXPECT_EQ(usual["linear_solver"]["value"], "automatic");
  EXPECT_EQ(usual["memory_limit"]["text"], "16.0 GiB");
  auto chosen = solver(
      "solver: {pitch_cents: 5, eigen_solver: krylov_schur, linear_solver: iterative, "
      "memory_limit: 4 GiB}\nmodes: {order: 2, element_size: 8 mm, max_modes: 7}\n");
  EXPECT_EQ(chosen["order"]["value"], 2);
  EXPECT_NE(chosen["order"]["reason"], usual["order"]["reason"]);
  EXPECT_EQ(chosen["element_size"]["value"], 0.008);
  EXPECT_EQ(chosen["pitch_target"]["value"], 5);
  EXPECT_EQ(chosen["eigen_solver"]["value"], "krylov_schur");
  EXPECT_EQ(chosen["linear_solver"]["value"], "iterative");
  EXPECT_EQ(chosen["memory_limit"]["value"], 4ll << 30);
  EXPECT_EQ(chosen["max_modes"]["value"], 7);
  EXPECT_EQ(chosen["band"]["value"], nlohmann::json({20, 20000}));
}

}  // namespace
}  // namespace carillon::cli
