#include "scene/strikes.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "../synth/curved_bodies.hpp"
#include "core/error.hpp"

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

}  // namespace
}  // namespace carillon::scene
