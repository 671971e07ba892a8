// What a plan says of bytes before anything is written.
#include "dataset/run/expected_bytes.hpp"

#include <gtest/gtest.h>

#include "dataset/plan/disk.hpp"
#include "dataset/run/expected_shapes.hpp"

namespace carillon::dataset {
namespace {

run::LoadedBuild build_of(const std::string& more, int strikes = 4) {
  run::LoadedBuild build;
  build.config = configuration::read_build_config(
      "materials: [steel, glass]\nobjects: [{shape: bar}, {shape: bowl}]\n"
      "audio: {sample_rate: 10 kHz, seconds: 1 s}\n"
      "strikes: {per_object: " +
          std::to_string(strikes) + "}\n" + more,
      "test.yaml", {});
  build.plan = plan::make_plan(build.config);
  return build;
}

TEST(SampleBytes, AreThoseOfTheValues) {
  const plan::SampleBytes plain = plan::sample_bytes(build_of("").config);
  EXPECT_EQ(plain.audio, 4e4);
  EXPECT_EQ(plain.total(), 4e4);
  const plan::SampleBytes heard = plan::sample_bytes(
      build_of("listeners: [{position: [1, 0, 0]}, {position: [0, 1, 0]}]\nfiles: {wav: true}\n"
               "mel: {bands: 16, frames: 10}\n")
          .config);
  EXPECT_EQ(heard.audio, 8e4);
  EXPECT_EQ(heard.wav, 8e4);
  EXPECT_EQ(heard.mel, 2 * 16 * 10 * 4);
}

TEST(ExpectedBytes, SoundsGoWithTheirNumberAndModesDoNot) {
  const auto few = run::expected_bytes(build_of("files: {wav: true}\n", 10));
  const auto many = run::expected_bytes(build_of("files: {wav: true}\n", 60));
  EXPECT_NEAR(many.sounds / few.sounds, 6, 0.5);
  EXPECT_DOUBLE_EQ(many.wav / few.wav, 6);
  EXPECT_EQ(many.modes, few.modes);
  EXPECT_GT(many.index, few.index);
  EXPECT_GT(many.records, few.records);
  EXPECT_EQ(many.voxels + many.pictures + many.movies, 0);
}

TEST(ExpectedBytes, EveryKindCountsOnce) {
  const auto bytes = run::expected_bytes(
      build_of("voxels: {resolution: 20}\ncamera: {width: 64, height: 64}\nfiles: {png: true}\n"));
  const nlohmann::json kinds = run::to_json(bytes);
  double sum = 0;
  for (const auto& [kind, size] : kinds.items()) sum += size.get<double>();
  EXPECT_DOUBLE_EQ(sum, bytes.total());
  EXPECT_GT(bytes.voxels, 0);
  EXPECT_GT(bytes.pictures, 0);
  EXPECT_NE(run::bytes_text(bytes).find("pictures"), std::string::npos);
  EXPECT_EQ(run::bytes_text(bytes).find("movies"), std::string::npos);
}

TEST(ExpectedBytes, FramesGoWithMaterialsAndViews) {
  const auto pictures = [](const std::string& camera) {
    return run::expected_bytes(build_of("camera: {width: 256, height: 256" + camera + "}\n"))
        .pictures;
  };
  const double one = pictures("");
  EXPECT_GT(pictures(", views: 3"), 2 * one);
  EXPECT_NEAR(pictures(", views: 5") - one, 2 * (pictures(", views: 3") - one), 1e-6 * one);
}

TEST(ExpectedShapes, ATargetThatIsHardToMeetTakesAnotherStep) {
  const auto bar_of = [](const std::string& cents) {
    const run::LoadedBuild build = build_of("solver: {pitch_cents: " + cents + "}\n");
    return run::expected_shapes(build.config, build.plan).front();
  };
  const run::ExpectedShape loose = bar_of("500"), tight = bar_of("0.1");
  EXPECT_EQ(loose.probes, 0);
  EXPECT_EQ(tight.probes, 1);
  EXPECT_GT(tight.last.unknowns(), loose.last.unknowns());
  EXPECT_GT(run::modes_seconds(tight), run::modes_seconds(loose));
  EXPECT_EQ(tight.modes.size(), 2u);
}

TEST(ExpectedShapes, BodiesOfRevolutionAreCountedOnTheirSection) {
  const run::LoadedBuild build = build_of("");
  const run::ExpectedShape bowl = run::expected_shapes(build.config, build.plan).back();
  EXPECT_TRUE(bowl.about_axis);
  EXPECT_GT(bowl.surface.nodes, 20 * bowl.surface.rows);
}

}  // namespace
}  // namespace carillon::dataset
