#include "dataset/plan/plan.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <map>
#include <set>

#include "core/error.hpp"
#include "core/temporary_folder.hpp"
#include "dataset/plan/solver_plan.hpp"
#include "dataset/run/costs.hpp"
#include "render/frame.hpp"
#include "scene/scene.hpp"

namespace carillon::dataset {
namespace {

configuration::BuildConfig config_of(const std::string& text) {
  return configuration::read_build_config(text, "test.yaml", {});
}

configuration::BuildConfig bars(int count, int strikes, const std::string& more = "") {
  return config_of(
      "objects:\n  - shape: bar\n    materials: [steel, glass]\n    sizes: [1, 2]\n"
      "    count: " +
      std::to_string(count) + "\nstrikes: {per_object: " + std::to_string(strikes) + "}\n" + more);
}

TEST(Plan, CountsShapesVariantsAndStrikes) {
  const plan::BuildPlan plan = plan::make_plan(bars(3, 5));
  EXPECT_EQ(plan.shapes.size(), 3u);
  EXPECT_EQ(plan.samples.size(), 3u * 2 * 2 * 5);
  EXPECT_EQ(plan.tasks.size(), 6u);
  std::set<std::string> keys;
  for (const plan::Sample& sample : plan.samples) keys.insert(sample.key);
  EXPECT_EQ(keys.size(), plan.samples.size());
}

TEST(Plan, MaterialsOfEachGroupAreDrawnForEachShape) {
  const std::string text =
      "materials: [steel, iron, brass, glass, crown_glass, spruce]\n"
      "objects: [{shape: bowl, count: 60}]\nvariants: {materials_per_group: 1}\n";
  const auto config = config_of(text);
  const plan::BuildPlan plan = plan::make_plan(config);
  std::map<std::string, int> drawn;
  for (const plan::Shape& shape : plan.shapes) {
    ASSERT_EQ(shape.variants.size(), 3u);
    for (const plan::Variant& variant : shape.variants) ++drawn[variant.material];
    // Wood has a grain: bowls of it are no bodies of revolution.
    EXPECT_EQ(shape.solver.solver, scene::ObjectSolver::tetrahedra);
  }
  EXPECT_EQ(drawn["spruce"], 60);
  EXPECT_EQ(drawn["steel"] + drawn["iron"] + drawn["brass"], 60);
  for (const auto& [name, count] : drawn) EXPECT_GE(count, 8) << name;
  EXPECT_EQ(config.scene.variants, 3u);
  const auto more = plan::make_plan(config_of(text + "seed: 0\n"));
  EXPECT_EQ(more.shapes[7].variants[1].material, plan.shapes[7].variants[1].material);
  EXPECT_THROW(config_of("objects: [{shape: bar, materials: [steel]}]\n"
                         "variants: {materials_per_group: 1, material_choice: last}"),
               core::ConfigError);
}

TEST(Plan, ShapesDrawConstantsOfTheirMaterials) {
  const std::string text =
      "objects: [{shape: bar, count: 40, materials: [steel, sterling_wood], sizes: [1, 2]}]\n";
  const auto config = config_of(
      text + "material_spread: {youngs_modulus: [0.8, 1.25], density: 1.1, damping: [1, 4]}\n");
  const plan::BuildPlan plan = plan::make_plan(config);
  std::set<double> moduli;
  for (const plan::Shape& shape : plan.shapes) {
    for (const plan::Variant& variant : shape.variants) {
      const auto drawn = plan::variant_materials(config, shape, variant, {""});
      const auto named = synth::material::parse_material(variant.material);
      const double modulus = drawn[0].elastic.youngs_modulus / named.elastic.youngs_modulus;
      const double damping = drawn[0].damping.parameters[0] / named.damping.parameters[0];
      EXPECT_GE(modulus, 0.8);
      EXPECT_LE(modulus, 1.25);
      EXPECT_NEAR(drawn[0].elastic.density, 1.1 * named.elastic.density, 1e-9);
      EXPECT_EQ(drawn[0].elastic.poisson_ratio, named.elastic.poisson_ratio);
      EXPECT_GE(damping, 1);
      EXPECT_LE(damping, 4);
      EXPECT_NEAR(drawn[0].damping.parameters[1] / named.damping.parameters[1], damping, 1e-12);
      moduli.insert(modulus);
    }
  }
  EXPECT_EQ(moduli.size(), 80u) << "one for each shape and material, the same in both sizes";
  EXPECT_THROW(config_of(text + "material_spread: {damping: [0, 1]}"), core::ConfigError);
}

TEST(Plan, TasksHoldAtMost256SamplesOfOneShape) {
  const plan::BuildPlan plan = plan::make_plan(bars(2, 150));
  std::size_t samples = 0;
  for (const plan::BuildTask& task : plan.tasks) {
    if (task.kind != plan::TaskKind::samples) continue;
    EXPECT_LE(task.count, 256u);
    for (std::size_t i = task.first; i < task.first + task.count; ++i) {
      EXPECT_EQ(plan.samples[i].shape, task.shape);
    }
    samples += task.count;
  }
  EXPECT_EQ(samples, plan.samples.size());
  const auto board = run::board_tasks(plan, bars(2, 150));
  for (std::size_t t = 0; t < board.size(); ++t) {
    EXPECT_EQ(board[t].after.size(), plan.tasks[t].kind == plan::TaskKind::samples ? 1u : 0u);
  }
}

TEST(Plan, GrowingChangesNothingThatExists) {
  const plan::BuildPlan small = plan::make_plan(bars(2, 3));
  const plan::BuildPlan large = plan::make_plan(bars(5, 9));
  std::map<std::string, std::uint64_t> ids;
  for (const plan::Sample& sample : large.samples) ids[sample.key] = sample.id;
  for (const plan::Sample& sample : small.samples) EXPECT_EQ(ids.at(sample.key), sample.id);
  for (std::size_t i = 0; i < small.shapes.size(); ++i) {
    EXPECT_EQ(small.shapes[i].id, large.shapes[i].id);
    EXPECT_EQ(small.shapes[i].split_shape, large.shapes[i].split_shape);
    EXPECT_EQ(small.shapes[i].request.shape.parameters, large.shapes[i].request.shape.parameters);
  }
}

TEST(Plan, SeedsDrawOtherShapesAndZeroIsASeed) {
  const auto parameters = [](const std::string& seed) {
    return plan::make_plan(bars(1, 1, "seed: " + seed + "\n")).shapes[0].request.shape.parameters;
  };
  EXPECT_EQ(parameters("0"), parameters("0"));
  EXPECT_NE(parameters("0"), parameters("1"));
}

TEST(Plan, SplitsHaveTheirShares) {
  const configuration::BuildConfig config = bars(2000, 1, "split: {validation: 0.2, test: 0.3}\n");
  std::map<std::string, int> fractions;
  for (const plan::Shape& shape : plan::make_plan(config).shapes) ++fractions[shape.split_shape];
  EXPECT_NEAR(fractions["test"] / 2000.0, 0.3, 0.04);
  EXPECT_NEAR(fractions["validation"] / 2000.0, 0.2, 0.04);
  EXPECT_NEAR(fractions["train"] / 2000.0, 0.5, 0.04);
}

TEST(Plan, EqualFilesFallIntoOnePart) {
  const core::TemporaryFolder folder;
  for (int i = 0; i < 20; ++i) {
    std::ofstream(folder / ("copy" + std::to_string(i) + ".off")) << "OFF\n0 0 0\n";
  }
  const configuration::BuildConfig config =
      config_of("objects:\n  - mesh: " + (folder / "*.off").string() +
                "\n    materials: [steel]\nsplit: {test: 0.5}\n");
  std::set<std::string> parts;
  for (const plan::Shape& shape : plan::make_plan(config).shapes) parts.insert(shape.split_shape);
  EXPECT_EQ(parts.size(), 1u);
}

TEST(Plan, NothingMatchedAndDoubleNamesAreErrors) {
  EXPECT_THROW(
      plan::make_plan(config_of("objects:\n  - mesh: none-*.off\n    materials: [steel]\n")),
      core::InputError);
  EXPECT_THROW(plan::make_plan(config_of("objects:\n  - shape: bar\n    materials: [steel]\n"
                                         "  - shape: bar\n    materials: [glass]\n")),
               core::InputError);
}

TEST(Plan, FingerprintsTellPlansApart) {
  const auto print = [](const configuration::BuildConfig& config) {
    return plan::fingerprint(config, plan::make_plan(config));
  };
  EXPECT_EQ(print(bars(2, 2)), print(bars(2, 2)));
  EXPECT_NE(print(bars(2, 2)), print(bars(2, 3)));
  configuration::BuildConfig struck = bars(2, 2);
  struck.scene.strikes.given = {{"*", {0, 0, 0}, {}, 0.01, 0.001}};
  const std::string before = print(struck);
  struck.scene.strikes.given[0].impulse = 0.02;
  EXPECT_NE(print(struck), before);
}

TEST(Plan, EffectsAreOffUnlessAskedFor) {
  if (render::offscreen() == "none") GTEST_SKIP() << "built without pictures";
  const auto running = [](const std::string& more) {
    std::set<std::string> names;
    for (const scene::PlannedEffect& effect : scene::plan_effects(bars(1, 1, more).scene)) {
      EXPECT_FALSE(effect.reason.empty()) << effect.name;
      if (effect.enabled) names.insert(effect.name);
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
  EXPECT_EQ(running("room: {dimensions: [5, 4, 3], absorption: 0.2}\n"),
            (Names{"damping", "contact"}));
}

scene::PlannedEffect effect_of(const configuration::BuildConfig& config, const std::string& name) {
  for (const scene::PlannedEffect& effect : scene::plan_effects(config.scene)) {
    if (effect.name == name) return effect;
  }
  throw std::runtime_error("no such effect");
}

TEST(Plan, ViewsHaveTheirCost) {
  if (render::offscreen() == "none") GTEST_SKIP() << "built without pictures";
  const configuration::BuildConfig config =
      bars(1, 4, "mel: {bands: 64}\nvoxels: {}\ncamera: {}\n");
  EXPECT_GT(effect_of(config, "mel").seconds_per_sound, 0.0);
  EXPECT_GT(effect_of(config, "voxels").seconds_per_shape, 0.0);
  EXPECT_GT(effect_of(config, "frames").seconds_per_shape, 0.0);
  EXPECT_GT(config.scene.seconds_per_shape(), 0.0);
  EXPECT_EQ(bars(1, 4).scene.seconds_per_shape(), 0.0);
  // Twice the bands are less than twice the cost: the transform is the same.
  const auto mel = [](const std::string& bands) {
    return effect_of(bars(1, 4, "mel: {bands: " + bands + "}\n"), "mel").seconds_per_sound;
  };
  EXPECT_GT(mel("128"), 1.2 * mel("64"));
  EXPECT_LT(mel("128"), 2 * mel("64"));
  const configuration::BuildConfig off =
      bars(1, 4, "mel: {}\nvoxels: {}\neffects: {mel: off, voxels: off}\n");
  EXPECT_EQ(effect_of(off, "mel").seconds_per_sound, 0.0);
  EXPECT_EQ(effect_of(off, "voxels").seconds_per_shape, 0.0);
}

// A fit serves all sounds and listeners of its object.
TEST(Plan, AFitCostsTheSameForAnyListeners) {
  const auto fit = [](int strikes, const std::string& more) {
    const std::string ear = "  - position: [0, 0, 1]\n";
    return effect_of(bars(1, strikes, "listeners:\n" + ear + more), "radiation").seconds_per_sound;
  };
  const double one = fit(10, "");
  EXPECT_GT(one, 0);
  EXPECT_DOUBLE_EQ(fit(10, "  - position: [0, 1, 1]\n  - position: [1, 0, 1]\n"), one);
  EXPECT_DOUBLE_EQ(fit(20, ""), one / 2);
}

TEST(Plan, DampingNamesTheLineOfItsMaterials) {
  EXPECT_NE(effect_of(bars(1, 1), "damping").reason.find("objects[0].materials: (test.yaml:3), "),
            std::string::npos)
      << effect_of(bars(1, 1), "damping").reason;
  const configuration::BuildConfig shared =
      config_of("seed: 1\nmaterials: [steel]\nobjects:\n  - shape: bar\n");
  EXPECT_EQ(effect_of(shared, "damping").reason,
            "materials: (test.yaml:2), every material has damping");
}

TEST(Plan, ObjectsAreDrawnInEveryMaterialThatTheySoundIn) {
  if (render::offscreen() == "none") GTEST_SKIP() << "built without pictures";
  using Names = std::vector<std::string>;
  const std::string objects =
      "objects: [{shape: bar, materials: [steel, wood], sizes: [1, 2]}, {shape: disc, materials: "
      "[glass]}]\ncamera: {width: 40, height: 20, views: 3}\n";
  const configuration::BuildConfig config = config_of(objects);
  const plan::BuildPlan all = plan::make_plan(config);
  EXPECT_EQ(plan::pictured_materials(all.shapes[0]), (Names{"steel", "wood"}));
  EXPECT_EQ(plan::pictured_materials(all.shapes[1]), Names{"glass"});
  EXPECT_EQ(plan::pictures(all), 3U);
  EXPECT_EQ(plan::picture_name(all.shapes[0], "wood", 0), "pictures/bar-000.wood.png");
  EXPECT_EQ(plan::picture_name(all.shapes[0], "wood", 1), "pictures/bar-000.wood.2.png");
  const plan::BuildPlan last =
      plan::make_plan(config_of(objects + "variants: {material_choice: last}\n"));
  EXPECT_EQ(plan::pictured_materials(last.shapes[0]), Names{"wood"});
  // Of one and a half materials in the mean, three views each.
  const configuration::BuildConfig one =
      config_of("objects: [{shape: bar, materials: [steel]}]\ncamera: {width: 40, height: 20}\n");
  EXPECT_NEAR(effect_of(config, "frames").seconds_per_shape,
              4.5 * effect_of(one, "frames").seconds_per_shape, 1e-12);
}

// A program that never registered a view, and one that has it off, read the same build.
TEST(Plan, ViewsThatAreOffAreNeverRegistered) {
  if (render::offscreen() == "none") GTEST_SKIP() << "built without pictures";
  const std::map<std::string, std::string> keys = {
      {"mel", "mel: {bands: 20}\n"}, {"voxels", "voxels: {}\n"}, {"frames", "camera: {}\n"}};
  for (const auto& [name, key] : keys) {
    std::vector<scene::Effect> others;
    for (const scene::Effect& effect : scene::effects()) {
      if (effect.name != name) others.push_back(effect);
    }
    const std::string bar = "objects:\n  - shape: bar\n    materials: [steel]\n";
    const configuration::BuildConfig never =
        configuration::read_build_config(bar, "test.yaml", {}, others);
    const std::string off = fmt::format("{}effects: {{{}: off}}\n", key, name);
    for (const std::string& more : {std::string(), off}) {
      const configuration::BuildConfig config = config_of(bar + more);
      EXPECT_FALSE(config.mel || config.voxels) << more;
      EXPECT_TRUE(config.cameras.empty()) << more;
      EXPECT_EQ(plan::fingerprint(config, plan::make_plan(config)),
                plan::fingerprint(never, plan::make_plan(never)));
      EXPECT_EQ(config.scene.seconds_per_shape(), never.scene.seconds_per_shape());
      EXPECT_EQ(config.scene.seconds_per_sound(60), never.scene.seconds_per_sound(60));
    }
    const configuration::BuildConfig on = config_of(bar + key);
    EXPECT_TRUE(on.mel || on.voxels || !on.cameras.empty()) << key;
  }
}

TEST(Plan, SolverIsShownWithItsReasons) {
  const auto solver = [](const std::string& more) {
    std::map<std::string, plan::SolverChoice> by_name;
    const configuration::BuildConfig config = bars(1, 1, more);
    for (const plan::SolverChoice& entry : plan::plan_solver(config, plan::make_plan(config))) {
      if (entry.value == 0) continue;  // a solver that nothing asks for
      EXPECT_FALSE(entry.reason.empty()) << entry.name;
      EXPECT_FALSE(entry.text.empty()) << entry.name;
      by_name[entry.name] = entry;
    }
    return by_name;
  };
  auto usual = solver("");
  EXPECT_EQ(usual["order"].value, 3);
  EXPECT_EQ(usual["pitch_target"].value, 5);
  EXPECT_EQ(usual["max_unknowns"].value, 120000);
  EXPECT_EQ(usual["edge_layers"].value, 1);
  EXPECT_EQ(solver("solver: {pitch_cents: off}\n")["pitch_target"].value, nullptr);
  // Who fixes the elements wants these.
  EXPECT_EQ(solver("modes: {order: 3}\n")["pitch_target"].value, nullptr);
  EXPECT_EQ(usual["element_size"].value, nullptr);
  EXPECT_EQ(usual["linear_solver"].value, "automatic");
  EXPECT_EQ(usual["mirror_planes"].value, "automatic");
  EXPECT_EQ(solver("solver: {mirror_planes: off}\n")["mirror_planes"].value, "off");
  EXPECT_EQ(usual["memory_limit"].text, "16.0 GiB");
  auto chosen = solver(
      "solver: {pitch_cents: 7, eigen_solver: krylov_schur, linear_solver: iterative, "
      "memory_limit: 4 GiB}\nmodes: {order: 2, element_size: 8 mm, max_modes: 7}\n");
  EXPECT_EQ(chosen["order"].value, 2);
  EXPECT_NE(chosen["order"].reason, solver("modes: {order: 2}\n")["order"].reason);
  EXPECT_EQ(chosen["element_size"].value, 0.008);
  EXPECT_EQ(chosen["pitch_target"].value, 7);
  EXPECT_EQ(chosen["eigen_solver"].value, "krylov_schur");
  EXPECT_EQ(chosen["linear_solver"].value, "iterative");
  EXPECT_EQ(chosen["memory_limit"].value, 4ll << 30);
  EXPECT_EQ(chosen["max_modes"].value, 7);
  EXPECT_EQ(chosen["band"].value, nlohmann::json({20, 20000}));
}

TEST(Plan, SolverIsChosenByTheShape) {
  const auto solvers = [](const std::string& objects, const std::string& more = "") {
    const configuration::BuildConfig config =
        config_of("materials: [steel]\nobjects:\n" + objects + more);
    std::vector<std::string> names;
    for (const plan::Shape& shape : plan::make_plan(config).shapes) {
      EXPECT_FALSE(shape.solver.reason.empty());
      names.emplace_back(scene::name_of(shape.solver.solver));
    }
    return names;
  };
  using Names = std::vector<std::string>;
  const std::string both = "  - {shape: bowl}\n  - {shape: bar}\n";
  EXPECT_EQ(solvers(both), (Names{"axisymmetric", "tetrahedra"}));
  for (const char* elements :
       {"modes: {order: 2}\n", "modes: {element_size: 8 mm}\n", "modes: {edge_layers: 0}\n",
        "solver: {kind: tetrahedra}\n", "solver: {eigen_solver: krylov_schur}\n"})
    EXPECT_EQ(solvers(both, elements), (Names{"tetrahedra", "tetrahedra"})) << elements;
  // Bounds of tetrahedra do not ask for them.
  EXPECT_EQ(solvers(both, "solver: {max_unknowns: 50000}\n"),
            (Names{"axisymmetric", "tetrahedra"}));
  EXPECT_EQ(solvers("  - {shape: bowl, solver: tetrahedra}\n  - {shape: cup}\n"),
            (Names{"tetrahedra", "axisymmetric"}));
  EXPECT_EQ(solvers("  - {shape: bowl, materials: [spruce]}\n"), (Names{"tetrahedra"}));
  EXPECT_THROW(solvers("  - {shape: bar, solver: axisymmetric}\n"), core::InputError);
  EXPECT_THROW(solvers(both, "solver: {kind: axisymmetric}\n"), core::InputError);
}

TEST(Plan, TellsOfTetrahedraOnlyWhereThereAreSome) {
  const configuration::BuildConfig config =
      config_of("materials: [steel]\nobjects:\n  - {shape: bowl}\n");
  for (const plan::SolverChoice& entry : plan::plan_solver(config, plan::make_plan(config)))
    EXPECT_NE(entry.name, "order");
}

}  // namespace
}  // namespace carillon::dataset
