// Torus and cone: against rings of beam theory, closed forms of volume and inertia, and tetrahedra.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "closed_forms.hpp"
#include "solve.hpp"
#include "solvers/axisymmetric/solve_axisymmetric.hpp"
#include "solvers/families/families.hpp"
#include "solvers/mesh/surface_mesh.hpp"

namespace carillon {
namespace {

constexpr double pi = std::numbers::pi;

solvers::modes::Modes modes_of(const solvers::mesh::GeneratedShape& shape,
                               const solvers::elements::Elastic& material, double top) {
  solvers::eigen::SolveOptions solve;
  solve.band = {0, top, 1000};
  core::Trace trace;
  return solvers::axisymmetric::solve_axisymmetric(
      solvers::families::find_family(shape.family).meridian(shape), material, solve,
      {.pitch_target = 0.01}, trace);
}

/// A slender ring of a round section bends in its plane at n (n^2 - 1) / sqrt(n^2 + 1), and out of
/// it at n (n^2 - 1) / sqrt(n^2 + 1 + nu), of sqrt(EI / (rho A R^4)) (Love 1927, articles 293 and
/// 294, with GJ = EI / (1 + nu)). What shear and rotation take is of (n r / R)^2.
TEST(Torus, BendsAsASlenderRing) {
  constexpr double ring = 0.1, tube = 0.001;
  const auto& material = test::steel;
  const double unit =
      std::sqrt(material.youngs_modulus / material.density) * tube / 2 / (ring * ring) / (2 * pi);
  const auto modes =
      modes_of({"torus", {{"ring_radius", ring}, {"tube_radius", tube}}, {}}, material, 16 * unit);
  ASSERT_EQ(modes.size(), 12u);  // pairs, n = 2, 3, 4, in the plane and out of it
  for (int n = 2; n <= 4; ++n) {
    const auto pair = static_cast<std::size_t>(4 * (n - 2));
    const double shape = n * (n * n - 1);
    const double out = shape / std::sqrt(n * n + 1 + material.poisson_ratio) * unit;
    const double in = shape / std::sqrt(n * n + 1) * unit;
    for (std::size_t i = 0; i < 2; ++i) {
      EXPECT_NEAR(modes.frequency(pair + i) / out, 1, 1e-3) << n;
      EXPECT_NEAR(modes.frequency(pair + 2 + i) / in, 1, 1e-3) << n;
    }
  }
}

TEST(Torus, WeighsWhatPappusSays) {
  const auto modes =
      modes_of({"torus", {{"ring_radius", 0.05}, {"tube_radius", 0.02}}, {}}, test::steel, 30000);
  EXPECT_NEAR(modes.mass / (test::steel.density * 2 * pi * pi * 0.05 * 4e-4), 1, 1e-9);
}

/// As far as the straight pieces that measure() lays between nodes follow the circle.
TEST(Torus, IsMeasured) {
  for (const double tube : {0.001, 0.02, 0.049}) {
    const auto size = solvers::mesh::measure(solvers::families::find_family("torus").meridian(
        {"torus", {{"ring_radius", 0.05}, {"tube_radius", tube}}, {}}));
    EXPECT_NEAR(size.volume / (2 * pi * pi * 0.05 * tube * tube), 1, 0.003);
    EXPECT_NEAR(size.surface / (4 * pi * pi * 0.05 * tube), 1, 0.003);
    EXPECT_NEAR(size.longest_side(), 2 * (0.05 + tube), 1e-12);
  }
}

/// Volume, height of the centroid times it, and the integral of x^2 + y^2 inside a closed surface.
std::array<double, 3> moments(const solvers::mesh::SurfaceMesh& surface) {
  std::array<double, 3> sum{};
  for (const auto& triangle : surface.triangles) {
    std::array<Vec3, 3> p;
    for (std::size_t i = 0; i < 3; ++i)
      p[i] = surface.vertices[static_cast<std::size_t>(triangle[i])];
    const double volume = p[0].dot(p[1].cross(p[2])) / 6;
    const Vec3 total = p[0] + p[1] + p[2];
    sum[0] += volume;
    sum[1] += volume * total.z() / 4;
    for (int axis = 0; axis < 2; ++axis) {
      double squares = total[axis] * total[axis];
      for (const Vec3& corner : p) squares += corner[axis] * corner[axis];
      sum[2] += volume * squares / 20;
    }
  }
  return sum;
}

/// With a blunt top and with a tip: V = pi h (R^2 + R r + r^2) / 3, centroid and inertia as usual.
TEST(Cone, HasVolumeCentroidAndInertia) {
  constexpr double radius = 0.05, height = 0.12;
  for (const double top : {0.02, 1e-5, 0.0}) {
    SCOPED_TRACE(top);
    const solvers::mesh::GeneratedShape shape{
        "cone", {{"radius", radius}, {"top_radius", top}, {"height", height}}, {}};
    const double volume = pi * height / 3 * (radius * radius + radius * top + top * top);
    const auto size =
        solvers::mesh::measure(solvers::families::find_family("cone").meridian(shape));
    EXPECT_NEAR(size.volume / volume, 1, 1e-9);
    EXPECT_NEAR(solvers::families::extent_of(shape).longest_side, height, 1e-12);
    const double centroid = height / 4 * (radius * radius + 2 * radius * top + 3 * top * top) /
                            (radius * radius + radius * top + top * top);
    double fifth = 0;  // R^4 + R^3 r + ... + r^4
    for (int k = 0; k <= 4; ++k) fifth += std::pow(radius, 4 - k) * std::pow(top, k);
    const double inertia = pi * height / 10 * fifth;
    solvers::mesh::MeshOptions options;
    options.order = 1;
    options.element_size = 0.008;
    const auto made = solvers::families::mesh_family(shape, options);
    solvers::mesh::SurfaceMesh surface;
    surface.vertices = made.mesh.nodes;
    for (std::size_t f = 0; f < made.mesh.faces.size(); f += 3) {
      surface.triangles.push_back(
          {made.mesh.faces[f], made.mesh.faces[f + 1], made.mesh.faces[f + 2]});
    }
    const auto [v, vz, iz] = moments(surface);
    // Chords lie inside the circle.
    EXPECT_NEAR(v / volume, 0.99, 0.01);
    EXPECT_NEAR(vz / v / centroid, 1, 0.005);
    EXPECT_NEAR(iz / inertia, 0.98, 0.02);
  }
}

/// Gmsh's triangles of the surface are curved to the body's; what they miss of its edge lets
/// tetrahedra lie a cent below the truth.
class Cones : public testing::TestWithParam<double> {};

TEST_P(Cones, RingAsTetrahedraDo) {
  const solvers::mesh::GeneratedShape tip{
      "cone", {{"radius", 0.04}, {"top_radius", GetParam()}, {"height", 0.1}}, {}};
  solvers::mesh::MeshOptions options;
  options.order = 4;
  const auto solid =
      test::lowest_modes(solvers::families::mesh_family(tip, options).mesh, {test::glass}, 8);
  const auto modes = modes_of(tip, test::glass, 1.01 * solid.frequency(7));
  ASSERT_GE(modes.size(), 8u);
  EXPECT_NEAR(modes.mass / solid.mass, 1, 1e-3);
  for (std::size_t k = 0; k < 8; ++k) {
    const double error = test::cents(solid.frequency(k), modes.frequency(k));
    EXPECT_GT(error, -1.5) << k;
    EXPECT_LT(error, 5) << k;
  }
}

INSTANTIATE_TEST_SUITE_P(TipAndTop, Cones, testing::Values(0.0, 0.015));

/// The tip is the limit of ever smaller tops: the pitch changes in proportion to the top's radius.
TEST(Cone, WithATipIsTheLimitOfBluntOnes) {
  const auto with_top = [](double top) {
    return modes_of({"cone", {{"radius", 0.04}, {"top_radius", top}, {"height", 0.1}}, {}},
                    test::glass, 35000);
  };
  const auto tip = with_top(0), small = with_top(1e-6), larger = with_top(1e-5);
  EXPECT_NEAR(tip.mass / (test::glass.density * pi * 0.1 / 3 * 0.0016), 1, 1e-9);
  ASSERT_GE(tip.size(), 4u);
  ASSERT_EQ(small.size(), tip.size());
  ASSERT_EQ(larger.size(), tip.size());
  for (std::size_t k = 0; k < tip.size(); ++k) {
    const double ten = test::cents(larger.frequency(k), tip.frequency(k));
    EXPECT_LT(std::abs(ten), 1) << k;
    EXPECT_NEAR(test::cents(small.frequency(k), tip.frequency(k)), ten / 10, 0.01) << k;
  }
}

}  // namespace
}  // namespace carillon
