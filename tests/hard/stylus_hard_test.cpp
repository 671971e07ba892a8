// What a stylus could be thrown about by: docs/hard-cases.md says what each must come to.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "../synth/scraped_face.hpp"
#include "core/error.hpp"
#include "render/maps/generated_maps.hpp"
#include "synth/touch/stylus.hpp"

namespace carillon::synth {
namespace {

using Corners = std::vector<Vec3>;

render::maps::TexturedFace face_of(const render::maps::SurfaceMap& map, double side = 1) {
  render::maps::TexturedFace face;
  face.map = std::make_shared<const render::maps::SurfaceMap>(map);
  face.size = {side, side};
  return face;
}

/// A path, and the hand's rest at its end for half a second.
Corners drawn_and_held(const Corners& corners, double speed) {
  Corners hand = touch::drawn_path(corners, speed, 1000);
  hand.resize(hand.size() + 500, hand.back());
  return hand;
}

/// Drawn twice, it is the same; it is finite, and no force is beyond the largest.
touch::Touch sound_touch(const render::maps::TexturedFace& face, const Corners& hand,
                         const touch::Stylus& stylus, const touch::TouchOptions& options = {}) {
  const touch::Touch touch = touch::draw_stylus(face, hand, stylus, options);
  const touch::Touch again = touch::draw_stylus(face, hand, stylus, options);
  EXPECT_EQ(touch.tip, again.tip);
  EXPECT_EQ(touch.forces, again.forces);
  EXPECT_EQ(touch.held_back, again.held_back);
  EXPECT_EQ(touch.tip.size(), hand.size());
  for (std::size_t k = 0; k < hand.size(); ++k) {
    EXPECT_TRUE(touch.tip[k].allFinite() && touch.forces[k].allFinite());
    EXPECT_LE(touch.forces[k].norm(), stylus.largest_force * (1 + 1e-12));
  }
  return touch;
}

/// How far the tip lies beneath the surface [m].
double depth_of(const render::maps::SurfaceMap& map, const Vec3& tip) {
  return (map.relief() ? render::maps::height_at(map, tip.head<2>()) : 0) - tip.z();
}

/// Speed of the last tick [m/s].
double last_speed(const touch::Touch& touch) {
  return (touch.tip.back() - touch.tip[touch.tip.size() - 2]).norm() * touch.rate;
}

/// Heights that a normal map stands for, above their lowest; 0 on a relief.
class StandsFor {
 public:
  explicit StandsFor(const render::maps::SurfaceMap& map)
      : normals_(!map.relief()), heights_(render::maps::integrated_relief(map)) {
    lowest_ = *std::min_element(heights_.heights.begin(), heights_.heights.end());
  }
  double height(const Vec3& tip) const {
    return normals_ ? render::maps::height_at(heights_, tip.head<2>()) - lowest_ : 0;
  }

 private:
  bool normals_;
  render::maps::SurfaceMap heights_;
  double lowest_ = 0;
};

// Steep and narrow valleys, where papers saw the tip swing between the sides: energy of tip and
// springs never grows while the hand stands still.
TEST(StylusHard, InANarrowValleyEnergyNeverGrows) {
  for (const double texel : {2e-5, 1e-4}) {
    for (const double depth : {1e-4, 1e-3, 5e-3}) {
      for (const bool normal_map : {false, true}) {
        for (const double stiffness : {500.0, 5000.0, 50000.0}) {
          SCOPED_TRACE(testing::Message()
                       << texel << ' ' << depth << ' ' << normal_map << ' ' << stiffness);
          const render::maps::SurfaceMap relief = sine_map(8 * texel, depth / 2, 8, 8);
          const auto face = face_of(normal_map ? render::maps::normal_map_of(relief) : relief);
          touch::Stylus stylus;
          stylus.stiffness = stiffness;
          stylus.press = 3;
          // Above the valley's side.
          const Corners hand(2000, Vec3(0.01 + 3.3 * texel, 0.5, 1e-4));
          const touch::Touch touch = sound_touch(face, hand, stylus);
          const auto energy = [&](const Vec3& tip, const Vec3& velocity) {
            return stylus.mass * velocity.squaredNorm() / 2 +
                   stylus.hold * (tip - hand[0]).head<2>().squaredNorm() / 2 +
                   stylus.press * (tip.z() + depth);
          };
          // A normal map stands for heights, and may give what lies below the start.
          const double begin = energy(touch.tip[0], Vec3::Zero()) +
                               stylus.press * StandsFor(*face.map).height(hand[0]);
          for (std::size_t k = 0; k + 1 < touch.tip.size(); ++k) {
            const Vec3 way = touch.tip[k + 1] - touch.tip[k];
            EXPECT_LE(energy(touch.tip[k] + way / 2, way * touch.rate), begin * 1.01) << k;
            // It is at rest long before the end.
            if (k > 1500) {
              EXPECT_LT(way.norm() * touch.rate, 1e-6) << k;
            }
          }
          // It lies on the valley's bottom, sunk in by press over stiffness.
          const double sunk = depth_of(*face.map, touch.tip.back()) - stylus.press / stiffness;
          EXPECT_GT(sunk, -1e-9);
          EXPECT_LT(sunk, normal_map ? 2.5e-4 : 2.5e-5);
          EXPECT_NEAR(touch.forces.back().z(), stylus.press, 1e-6);
        }
      }
    }
  }
}

// A wall: the tip is held back until the hand pulls it over, and comes out of the wall again.
TEST(StylusHard, UpAVerticalEdgeForcesStayBelowTheLargest) {
  constexpr double texel_size = 1e-4;
  for (const double depth : {5e-4, 2e-3, 2e-2}) {
    for (const double speed : {0.05, 0.3}) {
      SCOPED_TRACE(testing::Message() << depth << ' ' << speed);
      const auto face = face_of(step_map(texel_size, depth));
      const Corners hand = drawn_and_held({{0.005, 1e-4, -depth}, {0.001, 1e-4, -depth}}, speed);
      const touch::Stylus stylus;
      const touch::Touch touch = sound_touch(face, hand, stylus);
      double maximum = 0, allowed = 1e9;
      for (std::size_t k = 0; k + 1 < touch.tip.size(); ++k) {
        maximum = std::max(maximum, touch.forces[k].x());
        // It is not thrown off, and is never deeper in the wall than the stretched springs press.
        EXPECT_LT(touch.tip[k].z(), 1e-3);
        const double sunk = std::max(0.0, depth_of(*face.map, touch.tip[k]));
        EXPECT_LT(sunk, 1e-3);
        if (k < hand.size() - 500) continue;
        // While the hand stands still no state has more than any earlier one and its spring.
        const Vec3 way = touch.tip[k + 1] - touch.tip[k], at = touch.tip[k] + way / 2;
        const double energy = stylus.mass * (way * touch.rate).squaredNorm() / 2 +
                              stylus.hold * (at - hand[k]).head<2>().squaredNorm() / 2 +
                              stylus.press * (at.z() + depth);
        EXPECT_LE(energy, 1.01 * allowed) << k;
        allowed = std::min(allowed, energy + stylus.stiffness * sunk * sunk / 2);
      }
      EXPECT_GT(maximum, 1);
      EXPECT_LT(last_speed(touch), 1e-6);
      EXPECT_LT(depth_of(*face.map, touch.tip.back()), stylus.press / stylus.stiffness + 2e-4);
    }
  }
}

// To and fro for seconds, with friction, which takes all the time: the face's spring still gives
// no more than it holds. Measured from path and forces alone: what the face's normal part gave
// since any earlier tick (friction does no work along the normal) is at most the potential of that
// tick. On a relief that is the spring's alone; on a normal map spring and damper hold the press.
TEST(StylusHard, RubbedForSecondsTheFaceGivesNoMoreThanItHolds) {
  constexpr double full_length = 8e-3, groove_depth = 8e-4, audio_rate = 20000, press_force = 1;
  const render::maps::SurfaceMap relief = sine_map(full_length, groove_depth / 2, 32, 8);
  std::size_t held_back = 0;
  for (const bool normal_map : {false, true}) {
    const auto face = face_of(normal_map ? render::maps::normal_map_of(relief) : relief);
    const StandsFor stands_for(*face.map);
    for (const double friction : {0.0, 0.3}) {
      for (const double speed : {0.1, 0.2, 0.3}) {
        SCOPED_TRACE(testing::Message() << normal_map << ' ' << friction << ' ' << speed);
        Corners corners = {{0.02, 0.5, 0}};
        for (double way = 0; way < 3 * speed; way += 0.04) {
          corners.emplace_back(corners.back().x() < 0.04 ? 0.06 : 0.02, 0.5, 0);
        }
        touch::Stylus stylus;
        stylus.friction = friction;
        const touch::Touch touch =
            sound_touch(face, touch::drawn_path(corners, speed, audio_rate), stylus, {audio_rate});
        ASSERT_EQ(touch.limited, 0u);
        double given = 0, bound = 1e9, upwards = 0;
        for (std::size_t k = 0; k + 1 < touch.tip.size(); ++k) {
          const Vec3 &tip = touch.tip[k], way = touch.tip[k + 1] - tip;
          const double depth = std::max(0.0, depth_of(*face.map, tip));
          const double potential =
              stylus.stiffness * depth * depth / 2 + press_force * stands_for.height(tip);
          bound = std::min(bound, given + potential);
          const Vec3 normal =
              render::maps::normal_of(render::maps::slope_at(*face.map, (tip + way / 2).head<2>()));
          const double push = touch.forces[k].dot(normal), outward = normal.dot(way);
          const double damper = normal_map || push <= 0 ? 0 : stylus.damping * outward * audio_rate;
          given += std::max(0.0, push + damper) * outward;
          ASSERT_LE(given, bound + 1e-6) << k;
          upwards += touch.forces[k].z();
        }
        // The forces shown are all that bears the press: nothing else stops the tip.
        EXPECT_NEAR(upwards / static_cast<double>(touch.tip.size() - 1), press_force, 2e-3);
        if (!normal_map) {
          EXPECT_EQ(touch.held_back, 0u);
        }
        held_back += touch.held_back;
      }
    }
  }
  EXPECT_GT(held_back, 0u);
}

// After a stretch in which it was held back, a slow hand feels the slope again.
TEST(StylusHard, AfterAFastStretchASlowOneIsFeltAsBefore) {
  const auto face = face_of(render::maps::normal_map_of(sine_map(8e-3, 4e-4, 32, 8)));
  const Corners there_and_back = {
      {0.02, 0.5, 0}, {0.08, 0.5, 0}, {0.02, 0.5, 0}, {0.08, 0.5, 0}, {0.02, 0.5, 0}};
  Corners hand = touch::drawn_path(there_and_back, 0.3, 1000);
  const std::size_t fast = hand.size();
  const Corners slowly = touch::drawn_path(Corners{{0.02, 0.5, 0}, {0.08, 0.5, 0}}, 0.03, 1000);
  hand.insert(hand.end(), slowly.begin(), slowly.end());
  touch::Stylus stylus;
  stylus.friction = 0.3;
  const touch::Touch touch = sound_touch(face, hand, stylus);
  EXPECT_GT(touch.held_back, 0u);
  for (std::size_t k = fast + 100; k + 1 < hand.size(); ++k) {
    const Vec3 normal =
        render::maps::normal_of(render::maps::slope_at(*face.map, touch.tip[k].head<2>()));
    EXPECT_NEAR(touch.forces[k].z(), 1, 0.1) << k;
    EXPECT_NEAR(touch.forces[k].dot(normal), 1, 0.2) << k;
  }
}

// A hand that begins beside the face, or leaves it and comes back, also below its surface: over
// nothing the tip does not fall, and it is not shot out of the face when it comes back.
TEST(StylusHard, FromBesideTheFaceItIsNeitherDroppedNorThrown) {
  const render::maps::SurfaceMap relief = sine_map(8e-3, 4e-4, 32, 8);
  for (const bool normal_map : {false, true}) {
    const auto face = face_of(normal_map ? render::maps::normal_map_of(relief) : relief, 0.1);
    for (const double press : {0.0, 1.0}) {
      for (const double height : {0.0, -1e-3, -2e-2}) {
        SCOPED_TRACE(testing::Message() << normal_map << ' ' << press << ' ' << height);
        const Vec3 inside(0.05, 0.05, height), left(-0.05, 0.05, height);
        const Vec3 right(0.15, 0.05, height), behind(0.05, 0.15, height);
        touch::Stylus stylus;
        stylus.press = press;
        stylus.friction = 0.3;
        const Corners paths[] = {{left, inside}, {left, inside, right, inside, behind, inside}};
        for (const Corners& corners : paths) {
          const Corners hand = drawn_and_held(corners, 0.1);
          const touch::Touch touch = sound_touch(face, hand, stylus);
          double farthest = 0, strongest = 0;
          for (std::size_t k = 0; k < hand.size(); ++k) {
            farthest = std::max(farthest, (touch.tip[k] - hand[k]).norm());
            strongest = std::max(strongest, touch.forces[k].norm());
            const Vec3& tip = touch.tip[k];
            // It leads or lags by the springs' stretch.
            if (std::abs(tip.x() - 0.05) > 0.051 || tip.y() > 0.101) {
              EXPECT_EQ(touch.forces[k].norm(), 0) << k;
              EXPECT_NEAR(tip.z(), hand[k].z(), 2e-3) << k;
            }
          }
          EXPECT_LT(farthest, 4e-3);
          EXPECT_LT(strongest, 5);
          EXPECT_LT(last_speed(touch), 1e-6);
        }
      }
    }
  }
  // Begun over the face, but below its surface, it is put on it.
  const auto face = face_of(relief, 0.1);
  const touch::Touch touch =
      sound_touch(face, Corners(500, Vec3(0.05, 0.05, -0.02)), touch::Stylus{});
  EXPECT_NEAR(depth_of(*face.map, touch.tip.front()), 0, 1e-12);
  EXPECT_NEAR(depth_of(*face.map, touch.tip.back()), 2e-4, 1e-5);
}

// Every generated map, at the end of a fast stroke: where the hand rests, the tip comes to rest,
// and it is borne up by the press.
TEST(StylusHard, WhereTheHandRestsTheTipComesToRest) {
  for (const auto& generated : render::maps::generated_maps()) {
    const render::maps::SurfaceMap relief =
        render::maps::generate_map(generated.name, generated.defaults, 256, 1);
    for (const bool normal_map : {false, true}) {
      const auto face = face_of(normal_map ? render::maps::normal_map_of(relief) : relief);
      for (const double friction : {0.0, 0.3}) {
        for (const double press : {0.0, 1.0}) {
          SCOPED_TRACE(testing::Message()
                       << generated.name << ' ' << normal_map << ' ' << friction << ' ' << press);
          touch::Stylus stylus;
          stylus.friction = friction;
          stylus.press = press;
          const double height = press > 0 ? 0 : -1e-3;
          const touch::Touch touch = sound_touch(
              face, drawn_and_held({{0.3, 0.5, height}, {0.4, 0.53, height}}, 0.5), stylus);
          EXPECT_LT(last_speed(touch), 1e-6);
          if (press > 0) {
            EXPECT_NEAR(touch.forces.back().z(), press, 1e-6);
          }
        }
      }
    }
  }
}

// A tip wider than the valleys rides on the crests: halfway between two of them, L apart, a ball
// of radius r hangs r - sqrt(r^2 - L^2/4) below.
TEST(StylusHard, ATipWiderThanTheValleysRidesOnTheCrests) {
  constexpr double full_length = 5e-4, fixed_radius = 2e-3, groove_depth = 5e-4;
  const auto face = face_of(sine_map(full_length, groove_depth / 2, 32, 8));
  const double sag =
      fixed_radius - std::sqrt(fixed_radius * fixed_radius - full_length * full_length / 4);
  touch::Stylus stylus;
  stylus.radius = fixed_radius;
  const touch::Touch touch = sound_touch(
      face, touch::drawn_path(Corners{{0.1, 0.5, 0}, {0.11, 0.5, 0}}, 0.01, 1000), stylus);
  double lowest = 0, highest = -1;
  for (std::size_t k = 200; k < touch.tip.size(); ++k) {
    lowest = std::min(lowest, touch.tip[k].z() + stylus.press / stylus.stiffness);
    highest = std::max(highest, touch.tip[k].z() + stylus.press / stylus.stiffness);
  }
  EXPECT_NEAR(lowest, -sag, 5e-6);
  EXPECT_NEAR(highest, 0, 5e-6);
}

TEST(StylusHard, RefusesPathsThatAreNone) {
  const auto face = face_of(sine_map(2e-3, 0, 16, 4));
  const Corners nan = {{0, 0, 0}, {NAN, 0, 0}}, far = {{0, 0, 0}, {INFINITY, 0, 0}};
  for (const auto& path : {nan, far, Corners{}}) {
    EXPECT_THROW(touch::draw_stylus(face, path, {}, {}), core::InputError);
    EXPECT_THROW(touch::drawn_path(path, 0.1, 1000), core::InputError);
  }
  const Corners fine = {{0, 0, 0}, {0.1, 0, 0}};
  EXPECT_THROW(touch::drawn_path(fine, 0, 1000), core::InputError);
  EXPECT_THROW(touch::drawn_path(fine, 1e-12, 1000), core::InputError);
  EXPECT_THROW(touch::drawn_path(fine, NAN, 1000), core::InputError);
  touch::Stylus massless;
  massless.mass = 0;
  EXPECT_THROW(touch::draw_stylus(face, fine, massless, {}), core::InputError);
  try {
    touch::draw_stylus(face, nan, {}, {});
  } catch (const core::InputError& error) {
    EXPECT_NE(error.message().find("at tick 1"), std::string::npos);
  }
}

}  // namespace
}  // namespace carillon::synth
