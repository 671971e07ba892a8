#include "scene/strikes.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "../synth/curved_bodies.hpp"
#include "core/error.hpp"
#include "scene/columns.hpp"
#include "tests/scene/heard_scene.hpp"

namespace carillon::scene {
namespace {

/// A sphere of 60 mm.
struct Ball {
  solvers::modes::ModeSurface surface = synth::curved_sphere(0.03, {0, 0, 0}, 3, 2);
  synth::modal::SurfaceSampler sampler{surface};

  Vec3 struck(const Vec3& position, double tolerance = usual_tolerance) const {
    return synth::modal::frame_at(surface, nearest_point(sampler, surface, position, tolerance))
        .position;
  }
};

TEST(NearestPoint, IsOnTheSurfaceUpToATenthOfTheLongestSideAway) {
  const Ball ball;
  for (const double distance : {-0.0059, -0.002, 0.0, 0.002, 0.0059}) {
    const Vec3 position(0, 0, 0.03 + distance);
    const Vec3 struck = ball.struck(position);
    EXPECT_NEAR(struck.norm(), 0.03, 1e-4) << distance;
    EXPECT_NEAR((struck - position).norm(), std::abs(distance), 3e-4) << distance;
  }
  for (const double distance : {-0.0065, 0.0065, 4.97}) {
    EXPECT_THROW(ball.struck({0, 0, 0.03 + distance}), core::InputError) << distance;
  }
  EXPECT_LT((ball.struck({0, 0, 0.08}, 1) - Vec3(0, 0, 0.03)).norm(), 3e-4);
  EXPECT_THROW(ball.struck({0, 0, 0.1}, 1), core::InputError);
}

TEST(NearestPoint, IsNamedWhereAPointIsRefused) {
  try {
    Ball().struck({0, 0, 5});
    FAIL();
  } catch (const core::InputError& error) {
    EXPECT_EQ(
        error.message(),
        "the point struck, (0, 0, 5) m, is 4.97 m off the object; the nearest on it is (0, 0, "
        "0.03) m");
    EXPECT_NE(error.hint().find("from (-0.03, -0.03, -0.03) m to (0.03, 0.03, 0.03) m"),
              std::string::npos)
        << error.hint();
  }
}

TEST(Repeats, AreDrawnForEachSample) {
  const Repeats repeats{{0, 2}, {1, 3}, {0.1, 0.4}};
  core::Columns record{columns()};
  std::set<std::size_t> counts;
  for (std::uint64_t id = 0; id < 200; ++id) {
    Sound sound;
    sound.seed = 7;
    sound.id = id;
    sound.record = &record;
    draw_repeats(repeats, 1000, sound);
    ASSERT_EQ(sound.before, 800u);
    ASSERT_TRUE(std::is_sorted(sound.strikes.begin(), sound.strikes.end()));
    const auto own = std::find(sound.strikes.begin(), sound.strikes.end(), 0.8);
    ASSERT_NE(own, sound.strikes.end());
    EXPECT_LE(own - sound.strikes.begin(), 2);
    EXPECT_GE(sound.strikes.end() - own, 2);
    EXPECT_LE(sound.strikes.end() - own, 4);
    EXPECT_GE(sound.strikes.front(), 0);
    for (std::size_t i = 1; i < sound.strikes.size(); ++i) {
      const double interval = sound.strikes[i] - sound.strikes[i - 1];
      EXPECT_GT(interval, 0.1 - 1e-12);
      EXPECT_LT(interval, 0.4 + 1e-12);
    }
    counts.insert(sound.strikes.size());
    const std::vector<double> strikes = sound.strikes;
    draw_repeats(repeats, 1000, sound);
    EXPECT_EQ(sound.strikes, strikes);
  }
  EXPECT_EQ(counts, (std::set<std::size_t>{2, 3, 4, 5, 6}));
  EXPECT_EQ(record.last_row().at("strike_times").size(), 6u);
}

TEST(Repeats, OfOneStrikeAreNone) {
  core::Columns record{columns()};
  Sound sound;
  sound.record = &record;
  draw_repeats({}, 1000, sound);
  EXPECT_EQ(sound.strikes, std::vector<double>{0});
  EXPECT_EQ(sound.before, 0u);
}

/// The ball struck at 0.1 s or, with a strike before that, at 0 too; heard from `begin` [s] on.
std::vector<float> ball_struck_twice(double begin, double seconds) {
  static const solvers::modes::Modes modes = ringing_ball();
  static const std::vector<synth::material::Material> materials = {
      synth::material::parse_material("ceramic")};
  core::ConfigNode root = core::ConfigNode::parse(
      fmt::format("audio: {{seconds: {}}}\n"
                  "room: {{input: dry, dimensions: [5, 4, 3], source: [1, 1, 1], "
                  "listener: [3, 2, 1.5], rt60: 0.4}}\n",
                  seconds),
      "scene.yaml");
  const Scene scene = read_scene(root, "scene.yaml");
  root.finish();
  core::Trace trace;
  SoundChain chain(scene, "", trace);
  const RingingObject object = chain.prepare("ball", "ball", modes, materials);
  Sound sound;
  sound.object = &object;
  sound.strike = {
      synth::modal::SurfaceSampler(modes.surface).nearest({0, 0, 0.05}), {0, 0, -1}, 0.01, {}};
  sound.contact_time = 2e-4;
  sound.before = static_cast<std::size_t>(std::lround(begin * 44100));
  sound.strikes = {0, 0.1};
  chain.make(sound);
  return sound.audio;
}

TEST(Repeats, BeforeTheClipLeaveTheirTailsInIt) {
  const std::vector<float> whole = ball_struck_twice(0, 0.4);
  const std::vector<float> clip = ball_struck_twice(0.1, 0.3);
  ASSERT_EQ(whole.size(), 17640u);
  ASSERT_EQ(clip.size(), 13230u);
  EXPECT_TRUE(std::equal(clip.begin(), clip.end(), whole.begin() + 4410));
  EXPECT_GT(std::abs(whole[4409]), 0);
}

TEST(Repeats, AreCountsAndTimesFromZero) {
  const auto refused = [](const std::string& strikes) {
    core::ConfigNode root = core::ConfigNode::parse("strikes: " + strikes, "scene.yaml");
    try {
      read_scene(root, "scene.yaml");
    } catch (const core::ConfigError& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_NE(refused("{later: 1.5}").find("strikes.later: must be whole numbers from 0 to 100"),
            std::string::npos);
  EXPECT_NE(refused("{earlier: [-1, 1]}").find("whole numbers"), std::string::npos);
  EXPECT_NE(refused("{interval: 0.2 s}").find("there is one strike in a clip"), std::string::npos);
  EXPECT_NE(refused("{later: 1, interval: 0 s}").find("above 0 and at most 10 s"),
            std::string::npos);
  EXPECT_EQ(refused("{later: [0, 2], interval: [0.1 s, 0.4 s]}"), "");
}

}  // namespace
}  // namespace carillon::scene
