#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <cmath>
#include <numbers>

#include "core/error.hpp"
#include "synth/modal/ring_down.hpp"
#include "synth/surface/outer_surface.hpp"
#include "tests/synth/curved_bodies.hpp"

namespace carillon::synth {
namespace {

constexpr double pi = std::numbers::pi;

TEST(FacePieces, TileTheFaceWithItsOrientation) {
  for (int order = 1; order <= 4; ++order) {
    const auto pieces = surface::face_pieces(order);
    ASSERT_EQ(pieces.size(), std::size_t(order * order));
    for (const surface::FacePiece& piece : pieces) {
      const auto& [a, b, c] = piece.corners;
      const double area = (b[1] - a[1]) * (c[2] - a[2]) - (b[2] - a[2]) * (c[1] - a[1]);
      EXPECT_NEAR(area, 1.0 / (order * order), 1e-14);
    }
  }
}

TEST(FrameAt, FollowsTheCurvedSphere) {
  const Vec3 centre(0.3, -0.1, 2);
  double last = 1;
  for (int order = 1; order <= 4; ++order) {
    const auto surface = curved_sphere(0.05, centre, 3, order);
    double worst_radius = 0, worst_normal = 0;
    for (std::int32_t face = 0; face < 72; ++face) {
      for (const Eigen::Vector3d& b : {Eigen::Vector3d(0.2, 0.5, 0.3), Eigen::Vector3d(1, 0, 0),
                                       Eigen::Vector3d(0, 0.5, 0.5)}) {
        const modal::PointFrame frame = modal::frame_at(surface, {face, b});
        const Vec3 radial = frame.position - centre;
        worst_radius = std::max(worst_radius, std::abs(radial.norm() / 0.05 - 1));
        worst_normal = std::max(worst_normal, (frame.normal - radial.normalized()).norm());
        EXPECT_NEAR(frame.normal.norm(), 1, 1e-14);
      }
    }
    EXPECT_LT(worst_normal, 0.7 * last) << order;
    EXPECT_LT(worst_radius, worst_normal) << order;
    last = worst_normal;
  }
  EXPECT_LT(last, 1e-2);
}

TEST(FrameAt, RefusesPointsThatAreNone) {
  const auto surface = curved_sphere(1, Vec3::Zero(), 1, 2);
  EXPECT_THROW(modal::frame_at(surface, {8, {1, 0, 0}}), core::InputError);
  EXPECT_THROW(modal::frame_at(surface, {-1, {1, 0, 0}}), core::InputError);
  EXPECT_THROW(modal::frame_at(surface, {0, {0.5, 0.6, 0}}), core::InputError);
  EXPECT_THROW(modal::frame_at(surface, {0, {1.5, -0.5, 0}}), core::InputError);
  EXPECT_THROW(modal::frame_at(surface, {0, {std::nan(""), 0, 0}}), core::InputError);
}

TEST(OuterHull, IntegratesExactlyOverCurvedFaces) {
  const Vec3 centre(5, 2, -3);
  for (int order = 1; order <= 4; ++order) {
    const auto surface = curved_sphere(0.1, centre, 3, order);
    const surface::OuterHull hull = surface::outer_hull(surface);
    // The integral of n over a closed surface is zero; that of x . n is three times the volume.
    Vec3 sum = Vec3::Zero();
    double volume = 0;
    for (std::size_t a = 0; a < surface.nodes.size(); ++a) {
      const Vec3 weight = hull.volume_weights.segment<3>(3 * Eigen::Index(a));
      sum += weight;
      volume += weight.dot(surface.nodes[a] - centre) / 3;
    }
    EXPECT_LT(sum.norm(), 1e-16);
    // Independent of the quadrature: the curved volume as Riemann sum over fine pieces.
    double fine = 0;
    constexpr int cuts = 24;
    for (std::int32_t face = 0; face < 72; ++face) {
      const auto at = [&](int i, int j) -> Vec3 {
        const Eigen::Vector3d b(cuts - i - j, i, j);
        return modal::frame_at(surface, {face, b / cuts}).position - centre;
      };
      for (int i = 0; i < cuts; ++i) {
        for (int j = 0; i + j < cuts; ++j) {
          fine += at(i, j).dot(at(i + 1, j).cross(at(i, j + 1))) / 6;
          if (i + j + 2 <= cuts) {
            fine += at(i + 1, j).dot(at(i + 1, j + 1).cross(at(i, j + 1))) / 6;
          }
        }
      }
    }
    EXPECT_NEAR(volume / fine, 1, order == 1 ? 1e-12 : 3e-4) << order;
    if (order >= 3) {
      EXPECT_NEAR(volume / (4.0 / 3 * pi * 1e-3), 1, 1e-3) << order;
    }
    EXPECT_LT((hull.centroid - centre).norm(), 1e-12);
    EXPECT_NEAR(hull.radius, 0.1, 1e-12);
  }
}

TEST(SurfaceSampler, AreaTendsToTheSpheres) {
  const modal::SurfaceSampler coarse(curved_sphere(0.1, Vec3::Zero(), 4, 2));
  const modal::SurfaceSampler fine(curved_sphere(0.1, Vec3::Zero(), 8, 2));
  const double exact = 4 * pi * 0.01;
  EXPECT_LT(coarse.area(), exact);
  EXPECT_NEAR((exact - coarse.area()) / (exact - fine.area()), 4, 0.3);
}

TEST(SurfaceSampler, LeavesOutCavities) {
  solvers::modes::ModeSurface shell = curved_sphere(0.1, Vec3(1, 0, 0), 3, 2);
  const double outer_area = modal::SurfaceSampler(shell).area();
  append(shell, curved_sphere(0.09, Vec3(1, 0, 0), 3, 2, true));
  // A second body beside it counts.
  append(shell, curved_sphere(0.02, Vec3(2, 0, 0), 3, 2));
  const modal::SurfaceSampler sampler(shell);
  EXPECT_NEAR(sampler.area(), outer_area * (1 + 0.04), 1e-12);
  core::RandomStream random(1, 2, "test");
  for (int i = 0; i < 500; ++i) {
    const Vec3 position = modal::frame_at(shell, sampler.sample(random)).position;
    const double big = (position - Vec3(1, 0, 0)).norm();
    EXPECT_TRUE(std::abs(big - 0.1) < 1e-3 || (position - Vec3(2, 0, 0)).norm() < 0.0201);
  }
  const modal::SurfacePoint from_inside = sampler.nearest({1, 0, 0.08});
  EXPECT_NEAR(modal::frame_at(shell, from_inside).position.z(), 0.1, 2e-3);
}

TEST(SurfaceSampler, IsUniformByArea) {
  // On a sphere every coordinate is uniform (Archimedes).
  const auto surface = curved_sphere(1, Vec3::Zero(), 3, 3);
  const modal::SurfaceSampler sampler(surface);
  core::RandomStream random(7, 0, "uniform");
  constexpr int bins = 10, samples = 20000;
  std::array<std::array<int, bins>, 3> counts{};
  for (int i = 0; i < samples; ++i) {
    const Vec3 p = modal::frame_at(surface, sampler.sample(random)).position;
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
      const int bin = std::clamp(int((p[axis] + 1) / 2 * bins), 0, bins - 1);
      ++counts[std::size_t(axis)][std::size_t(bin)];
    }
  }
  for (const auto& axis : counts) {
    double chi2 = 0;
    for (const int count : axis) chi2 += std::pow(count - samples / bins, 2) * bins / samples;
    EXPECT_LT(chi2, 33.7);  // 9 degrees of freedom, 1e-4
  }
}

TEST(SurfaceSampler, SameStreamSamePoints) {
  const modal::SurfaceSampler sampler(curved_sphere(1, Vec3::Zero(), 2, 2));
  core::RandomStream one(3, 4, "strike"), two(3, 4, "strike");
  for (int i = 0; i < 10; ++i) {
    const modal::SurfacePoint a = sampler.sample(one), b = sampler.sample(two);
    EXPECT_EQ(a.face, b.face);
    EXPECT_EQ(a.barycentric, b.barycentric);
  }
}

TEST(SurfaceSampler, NearestIsNearest) {
  const auto surface = curved_sphere(1, Vec3(0.2, 0, 0), 2, 1);
  const modal::SurfaceSampler sampler(surface);
  EXPECT_TRUE(rc::check("no sampled point is nearer", [&] {
    const auto coordinate = [] { return *rc::gen::inRange(-2000, 2000) * 1e-3; };
    const double x = coordinate(), y = coordinate(), z = coordinate();
    const Vec3 query(x, y, z);
    const modal::SurfacePoint nearest = sampler.nearest(query);
    const double distance = (modal::frame_at(surface, nearest).position - query).norm();
    core::RandomStream random(std::uint64_t(1e6 * (x + 5)), 0, "nearest");
    for (int i = 0; i < 300; ++i) {
      const double other =
          (modal::frame_at(surface, sampler.sample(random)).position - query).norm();
      RC_ASSERT(other >= distance - 1e-12);
    }
  }));
  // A point of the surface is its own nearest.
  core::RandomStream random(1, 1, "own");
  for (int i = 0; i < 50; ++i) {
    const Vec3 position = modal::frame_at(surface, sampler.sample(random)).position;
    EXPECT_LT((modal::frame_at(surface, sampler.nearest(position)).position - position).norm(),
              1e-12);
  }
}

TEST(SurfaceSampler, NeedsAnOuterSurface) {
  EXPECT_THROW(modal::SurfaceSampler(solvers::modes::ModeSurface{}), core::InputError);
  EXPECT_THROW(modal::SurfaceSampler(curved_sphere(1, Vec3::Zero(), 2, 2, true)), core::InputError);
}

}  // namespace
}  // namespace carillon::synth
