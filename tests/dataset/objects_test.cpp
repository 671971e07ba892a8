// Objects of a configuration: common lengths, sizes that are drawn, which variants sound, and
// ModelNet's folders.
#include "dataset/configuration/objects.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <set>

#include "core/error.hpp"
#include "core/temporary_folder.hpp"
#include "dataset/plan/expected_mesh.hpp"
#include "dataset/plan/plan.hpp"
#include "dataset/sweep/detail/shared_work.hpp"
#include "solvers/families/families.hpp"

namespace carillon::dataset {
namespace {

configuration::BuildConfig config_of(const std::string& objects, const std::string& more = "") {
  return configuration::read_build_config(
      "materials: [steel]\nobjects:\n" + objects + "strikes: {per_object: 1}\n" + more, "test.yaml",
      {});
}

std::string refusal(const std::string& objects, const std::string& more = "") {
  try {
    config_of(objects, more);
  } catch (const core::ConfigError& error) {
    return error.what();
  }
  return "accepted";
}

TEST(Lengths, BringGeneratedBodiesToOneSizeAndKeepTheirProportions) {
  for (const solvers::families::Family& family : solvers::families::families()) {
    if (family.parameters.empty()) continue;  // turned has no parameters to draw
    const std::string entry = "  - {shape: " + family.name + ", count: 5";
    const plan::BuildPlan plain = plan::make_plan(config_of(entry + "}\n"));
    const plan::BuildPlan scaled = plan::make_plan(config_of(entry + ", length: 20 cm}\n"));
    for (std::size_t i = 0; i < plain.shapes.size(); ++i) {
      const auto &before = plain.shapes[i].request.shape, &after = scaled.shapes[i].request.shape;
      EXPECT_NEAR(solvers::families::extent_of(after).longest_side, 0.2, 1e-6) << family.name;
      const double factor = 0.2 / solvers::families::extent_of(before).longest_side;
      for (const auto& [name, value] : before.parameters)
        EXPECT_NEAR(after.parameters.at(name), factor * value, 1e-9) << family.name << " " << name;
      EXPECT_EQ(plain.shapes[i].split_shape, scaled.shapes[i].split_shape);
    }
  }
}

TEST(Tuning, MakesAVariantOfEachPitch) {
  const plan::BuildPlan plan = plan::make_plan(config_of(
      "  - {shape: bar, materials: [steel, glass], tune: [440 Hz, 0.5 kHz], tune_mode: 2}\n"
      "  - {shape: bar, name: low, tune: 220 Hz}\n",
      "variants: {size_choice: last}\n"));
  ASSERT_EQ(plan.samples.size(), 3u);
  EXPECT_EQ(plan.samples[0].key, "bar-000/steel/500Hz-mode-2/strike-0000");
  EXPECT_EQ(plan.samples[2].key, "low-000/steel/220Hz/strike-0000");
  ASSERT_EQ(plan.shapes[0].variants.size(), 4u);
  EXPECT_EQ(plan.shapes[0].variants[2].tune, 440);
  EXPECT_EQ(plan::size_name({"steel", 1.5}), "1.5");
}

TEST(Lengths, AreThoseOfTheBoxAroundABody) {
  const auto side = [](const std::string& family, std::map<std::string, double> parameters) {
    return solvers::families::extent_of({family, std::move(parameters), {}}).longest_side;
  };
  EXPECT_NEAR(side("box", {{"length", .1}, {"width", .3}, {"height", .2}, {"wall", .01}}), .3,
              1e-9);
  EXPECT_NEAR(side("pebble", {{"length", .1}, {"width", .05}, {"height", .2}}), .2, 1e-9);
  EXPECT_NEAR(side("cylinder", {{"radius", .1}, {"length", .05}}), .2, 1e-9);
  EXPECT_NEAR(side("can", {{"radius", .02}, {"length", .1}, {"wall", .002}}), .1, 1e-9);
  EXPECT_NEAR(side("sphere", {{"radius", .03}}), .06, 1e-6);
  EXPECT_NEAR(
      side("bowl", {{"radius", .08}, {"base_radius", .03}, {"height", .05}, {"wall", .004}}), .16,
      1e-6);
}

TEST(Lengths, ScaleTurnedProfilesToo) {
  const plan::BuildPlan plan = plan::make_plan(config_of(
      "  - shape: turned\n    length: 10 cm\n    profile:\n      - {radius: 0, height: 0}\n"
      "      - {radius: 3 cm, height: 0}\n      - {radius: 0, height: 12 cm}\n"));
  const auto& profile = plan.shapes[0].request.shape.profile;
  EXPECT_NEAR(profile[1][0], 0.025, 1e-9);
  EXPECT_NEAR(profile[2][1], 0.1, 1e-9);
}

TEST(DrawnSizes, AreNormalAmongInstancesAndTheSameForAllMaterials) {
  const configuration::BuildConfig config = config_of(
      "  - {shape: bar, count: 4000, materials: [steel, wood], "
      "drawn_size: {mean: 1.5, deviation: 0.2}}\n");
  double sum = 0, squares = 0;
  int within = 0;
  const plan::BuildPlan plan = plan::make_plan(config);
  for (const plan::Shape& shape : plan.shapes) {
    ASSERT_EQ(shape.variants.size(), 2u);
    const double size = shape.variants[0].size;
    EXPECT_EQ(shape.variants[1].size, size);
    EXPECT_LE(std::abs(size - 1.5), 0.6 + 1e-6);
    sum += size;
    squares += size * size;
    within += std::abs(size - 1.5) < 0.2;
  }
  // Four standard errors; 68.3 % of a normal distribution lie within one deviation.
  const double mean = sum / 4000, deviation = std::sqrt(squares / 4000 - mean * mean);
  EXPECT_NEAR(mean, 1.5, 4 * 0.2 / std::sqrt(4000));
  EXPECT_NEAR(deviation, 0.2, 4 * 0.2 / std::sqrt(8000));
  EXPECT_NEAR(within / 4000.0, 0.685, 0.03);
}

TEST(DrawnSizes, LeaveTheBodyAndComeAfterTheGivenOnes) {
  const std::string entry = "  - {shape: bar, count: 3, sizes: [1, 2]";
  const plan::BuildPlan given = plan::make_plan(config_of(entry + "}\n"));
  const plan::BuildPlan drawn =
      plan::make_plan(config_of(entry + ", drawn_size: {mean: 3, deviation: 0.1}}\n"));
  std::set<double> sizes;
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(drawn.shapes[i].request.shape.parameters, given.shapes[i].request.shape.parameters);
    ASSERT_EQ(drawn.shapes[i].variants.size(), 3u);
    EXPECT_EQ(drawn.shapes[i].variants[1].size, 2);
    sizes.insert(drawn.shapes[i].variants[2].size);
  }
  EXPECT_EQ(sizes.size(), 3u);
  // A larger count draws the same for those that were there.
  const plan::BuildPlan more = plan::make_plan(config_of(
      "  - {shape: bar, count: 9, sizes: [1, 2], drawn_size: {mean: 3, deviation: 0.1}}\n"));
  EXPECT_EQ(more.shapes[2].variants[2].size, drawn.shapes[2].variants[2].size);
  // The resolved text reads back as itself.
  const configuration::BuildConfig config =
      config_of("  - {shape: bar, drawn_size: {mean: 2, deviation: 0.2}}\n");
  EXPECT_EQ(configuration::read_build_config(config.resolved, "test.yaml", {}).resolved,
            config.resolved);
}

TEST(DrawnSizes, ImpossibleOnesAreRefused) {
  const auto drawn = [](const std::string& size) {
    return refusal("  - {shape: bar, drawn_size: " + size + "}\n");
  };
  EXPECT_NE(drawn("{mean: 0, deviation: 0}").find("positive"), std::string::npos);
  EXPECT_NE(drawn("{mean: 1, deviation: 0.3}").find("quarter"), std::string::npos);
  EXPECT_NE(drawn("{mean: 1, deviation: 0}").find("thousandth"), std::string::npos);
  EXPECT_NE(drawn("{mean: 1}").find("deviation"), std::string::npos);
  EXPECT_NE(drawn("{mean: 10 cm, deviation: 1 cm}"), "accepted");
}

TEST(Variants, FirstAndLastSoundAndEverySolveIsShared) {
  const std::string entry =
      "  - {shape: block, count: 3, materials: [steel, glass, wood], sizes: [1], "
      "drawn_size: {mean: 2, deviation: 0.1}}\n";
  std::vector<run::LoadedBuild> builds;
  for (const auto& [materials, sizes, samples] :
       {std::tuple{"all", "all", 18u}, std::tuple{"first", "first", 3u},
        std::tuple{"last", "first", 3u}, std::tuple{"all", "last", 9u}}) {
    run::LoadedBuild build;
    build.config = config_of(
        entry,
        fmt::format("variants: {{material_choice: {}, size_choice: {}}}\n", materials, sizes));
    build.plan = plan::make_plan(build.config);
    EXPECT_EQ(build.plan.samples.size(), samples);
    for (const plan::Sample& sample : build.plan.samples) {
      const plan::Variant& variant = build.plan.shapes[sample.shape].variants[sample.variant];
      if (materials == std::string("first")) {
        EXPECT_EQ(variant.material, "steel");
      }
      if (materials == std::string("last")) {
        EXPECT_EQ(variant.material, "wood");
      }
      EXPECT_EQ(variant.size == 1, sizes == std::string("first") || sample.variant % 2 == 0);
    }
    builds.push_back(std::move(build));
  }
  const sweep::SharingCounts counts = sweep::count_shared_work(builds);
  EXPECT_EQ(counts.objects, 12u);
  EXPECT_EQ(counts.solves, 3u);
  // A sample is the same in every choice that has it.
  std::set<std::string> all;
  for (const plan::Sample& sample : builds[0].plan.samples) all.insert(sample.key);
  for (const run::LoadedBuild& build : builds)
    for (const plan::Sample& sample : build.plan.samples) EXPECT_TRUE(all.contains(sample.key));
  EXPECT_NE(refusal(entry, "variants: {size_choice: second}\n").find("variants.size_choice"),
            std::string::npos);
}

/// A box as ModelNet writes it: the counts behind the keyword, no line between.
void write_off(const std::filesystem::path& path, double x, double y, double z) {
  std::filesystem::create_directories(path.parent_path());
  std::ofstream out(path);
  out << "OFF8 12 0\n";
  for (int i = 0; i < 8; ++i) {
    out << (i & 1 ? x : 0) << " " << (i & 2 ? y : 0) << " " << (i & 4 ? z : 0) << "\n";
  }
  out << "3 0 2 1\n3 1 2 3\n3 4 5 6\n3 5 7 6\n3 0 1 4\n3 1 5 4\n"
         "3 2 6 3\n3 3 6 7\n3 0 4 2\n3 2 4 6\n3 1 3 5\n3 3 7 5\n";
}

class ModelNetFolders : public testing::Test {
 protected:
  void SetUp() override {
    for (int i = 1; i <= 60; ++i) {
      const std::string part = i <= 40 ? "train" : "test";
      write_off(folder_.path() / "bed" / part / fmt::format("bed_{:04}.off", i), 1, 2, 3 + i);
      write_off(folder_.path() / "desk" / part / fmt::format("desk_{:04}.off", i), 1, 3, 80 + i);
    }
    write_off(folder_.path() / "desk" / "toys" / "desk_9999.off", 1, 1, 1);  // no part
    std::ofstream(folder_.path() / "README.txt") << "boxes";
  }
  std::string entry(const std::string& more = "") const {
    return "  - {modelnet: " + folder_.path().string() + ", length: 30 cm" + more + "}\n";
  }
  core::TemporaryFolder folder_;
};

TEST_F(ModelNetFolders, GiveFamiliesAndParts) {
  const plan::BuildPlan plan =
      plan::make_plan(config_of(entry(), "split: {validation: 0.25, test: 0.5}\n"));
  ASSERT_EQ(plan.shapes.size(), 120u);
  std::map<std::string, int> families, parts;
  for (const plan::Shape& shape : plan.shapes) {
    ++families[shape.family];
    ++parts[shape.split_shape];
    EXPECT_TRUE(shape.id.starts_with(shape.family + "_")) << shape.id;
    const bool test = std::stoi(shape.id.substr(shape.id.size() - 4)) > 40;
    EXPECT_EQ(shape.split_shape == "test", test) << shape.id;
    ASSERT_TRUE(shape.surface.has_value()) << "the file was read";
    EXPECT_NEAR(plan::expected_object(shape).extent.longest_side, 0.3, 1e-9);
  }
  EXPECT_EQ(families, (std::map<std::string, int>{{"bed", 60}, {"desk", 60}}));
  EXPECT_NEAR(parts["validation"], 20, 12) << "a quarter of 80, by three deviations";
}

TEST_F(ModelNetFolders, AreTakenInPartByClass) {
  const auto files = [&](const std::string& more) {
    return configuration::object_files(config_of(entry(more)).objects[0].object);
  };
  const auto few = files(", per_class: 20"), more = files(", per_class: 30");
  EXPECT_EQ(few.size(), 40u);
  EXPECT_TRUE(std::includes(more.begin(), more.end(), few.begin(), few.end()));
  const auto tests = std::count_if(few.begin(), few.end(), [](const std::string& path) {
    return configuration::modelnet_place(path).part == "test";
  });
  EXPECT_NEAR(static_cast<double>(tests), 13, 8) << "a third, as there are";
  for (const std::string& path : files(", classes: [desk]"))
    EXPECT_EQ(configuration::modelnet_place(path).family, "desk");
  EXPECT_EQ(files(", classes: [desk]").size(), 60u);
  EXPECT_THROW(plan::make_plan(config_of(entry(", classes: [chair]"))), core::InputError);
  EXPECT_NE(refusal("  - {modelnet: a, mesh: b}\n").find("modelnet"), std::string::npos);
}

/// The ready task as one of its variants has it.
configuration::BuildConfig ready_task(const std::string& materials, const std::string& sizes) {
  const std::string path = CARILLON_CONFIGS "/families10.yaml";
  return configuration::read_build_config(
      core::read_text_file(path), path,
      {"variants.material_choice=" + materials, "variants.size_choice=" + sizes});
}

TEST(Families10, TwinsAreDrawnFromTheSameRanges) {
  const configuration::BuildConfig config = ready_task("first", "first");
  std::map<std::string, const configuration::ObjectSource*> by_family;
  for (const configuration::ObjectSource& source : config.objects)
    by_family[source.object.family] = &source;
  EXPECT_EQ(by_family.size(), 10u);
  for (const auto& [solid, hollow] :
       {std::pair{"block", "box"}, std::pair{"cylinder", "can"}, std::pair{"pebble", "bauble"}}) {
    const configuration::ObjectSource &one = *by_family.at(solid), &other = *by_family.at(hollow);
    EXPECT_EQ(one.object.file.length, other.object.file.length);
    EXPECT_EQ(one.count, other.count);
    auto outside = other.object.parameters;
    EXPECT_EQ(outside.erase("wall"), 1u);
    EXPECT_EQ(one.object.parameters, outside) << solid;
  }
}

TEST(Families10, HasTwoHundredDifferentBodiesOfEachFamilyInEveryVariant) {
  for (const auto& [materials, sizes] : {std::pair{"first", "first"}, std::pair{"last", "last"}}) {
    const plan::BuildPlan plan = plan::make_plan(ready_task(materials, sizes));
    EXPECT_EQ(plan.samples.size(), 2000u);
    std::set<std::string> identities, heard;
    std::map<std::string, std::set<std::string>> parts, spoken;
    for (const plan::Sample& sample : plan.samples) {
      const plan::Shape& shape = plan.shapes[sample.shape];
      const plan::Variant& variant = shape.variants[sample.variant];
      identities.insert(shape.identity);
      parts[shape.family].insert(shape.split_shape);
      spoken[shape.family].insert(variant.material);
      EXPECT_NEAR(solvers::families::extent_of(shape.request.shape).longest_side, 0.4, 1e-6);
      EXPECT_EQ(variant.size == 1, sizes == std::string("first"));
      heard.insert(variant.material);
    }
    EXPECT_EQ(identities.size(), 2000u) << "no object is there twice";
    EXPECT_EQ(parts.size(), 10u);
    for (const auto& [family, seen] : parts) EXPECT_EQ(seen.size(), 3u) << family;
    for (const auto& [family, named] : spoken) EXPECT_EQ(named.size(), 1u) << family;
    EXPECT_EQ(heard.size() == 1, materials == std::string("first"));
  }
}

}  // namespace
}  // namespace carillon::dataset
