// Mass, centre and inertia of bodies of several densities, against closed forms.
#include "synth/surface/rigid_body.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "core/error.hpp"
#include "tests/solvers/test_meshes.hpp"

namespace carillon::synth {
namespace {

// A hammer: a head of steel on a handle of wood, both bricks along x.
TEST(RigidBody, OfTwoDensitiesTurnsAboutItsWeight) {
  const double a = 0.3, b = 0.02, c = 0.03, head = 0.1, heavy = 7800, light = 600;
  const solvers::mesh::TetMesh mesh = test::box_mesh(
      {a, b, c}, {6, 2, 2}, 2, [&](const Vec3& middle) { return middle.x() > a - head ? 1 : 0; });
  const std::vector<surface::RegionMoments> regions = surface::region_moments(mesh);
  ASSERT_EQ(regions.size(), 2u);
  EXPECT_NEAR(regions[0].volume, (a - head) * b * c, 1e-15);
  EXPECT_NEAR(regions[1].centroid.x(), a - head / 2, 1e-12);
  const double m0 = light * (a - head) * b * c, m1 = heavy * head * b * c, mass = m0 + m1;
  const surface::RigidBody body =
      surface::rigid_body(regions, std::vector<double>{light, heavy}, mass);
  const double x = (m0 * (a - head) / 2 + m1 * (a - head / 2)) / mass;
  EXPECT_NEAR((body.centre - Vec3(x, b / 2, c / 2)).norm(), 0, 1e-12);
  const auto brick = [&](double m, double length, double middle) {
    return m * (length * length / 12 + std::pow(middle - x, 2));
  };
  const double along = brick(m0, a - head, (a - head) / 2) + brick(m1, head, a - head / 2);
  std::vector<double> inertia(body.inertia.begin(), body.inertia.end());
  std::sort(inertia.begin(), inertia.end());
  EXPECT_NEAR(inertia[0], mass * (b * b + c * c) / 12, 1e-12);
  EXPECT_NEAR(inertia[1], along + mass * b * b / 12, 1e-12);
  EXPECT_NEAR(inertia[2], along + mass * c * c / 12, 1e-12);
}

// Where it lies and how it is turned changes nothing but where its axes are.
TEST(RigidBody, IsTheSameFarFromTheOrigin) {
  const auto region = [](const Vec3& middle) { return middle.x() > 0.1 ? 1 : 0; };
  const solvers::mesh::TetMesh mesh = test::box_mesh({0.2, 0.05, 0.02}, {4, 2, 1}, 1, region);
  const Eigen::AngleAxisd turn(0.7, Vec3(1, 2, 3).normalized());
  const Vec3 far(1000, -500, 200);
  const auto moved = test::moved(mesh, [&](const Vec3& p) -> Vec3 { return turn * p + far; });
  const std::vector<double> densities = {1000, 2000};
  const surface::RigidBody here = surface::rigid_body(surface::region_moments(mesh), densities, 2);
  const surface::RigidBody there =
      surface::rigid_body(surface::region_moments(moved), densities, 2);
  EXPECT_NEAR((there.centre - (turn * here.centre + far)).norm(), 0, 1e-9);
  EXPECT_NEAR((there.inertia - here.inertia).norm() / here.inertia.norm(), 0, 1e-8);
}

TEST(RigidBody, RefusesWhatHasNoMassOrNoVolume) {
  const std::vector<surface::RegionMoments> regions =
      surface::region_moments(test::box_mesh({1, 1, 1}, {1, 1, 1}, 1));
  EXPECT_THROW(surface::rigid_body(regions, std::vector<double>{1}, 0), core::InputError);
  EXPECT_THROW(surface::rigid_body(regions, std::vector<double>{1, 2}, 1), core::InputError);
  EXPECT_THROW(surface::rigid_body(regions, std::vector<double>{0}, 1), core::InputError);
  EXPECT_THROW(surface::rigid_body(regions, std::vector<double>{std::nan("")}, 1),
               core::InputError);
  solvers::mesh::TetMesh empty = test::box_mesh({1, 1, 1}, {1, 1, 1}, 1);
  empty.region_names.push_back("nothing");
  EXPECT_THROW(surface::region_moments(empty), core::InputError);
}

}  // namespace
}  // namespace carillon::synth
