// The axisymmetric solver on the families' sections: against tetrahedra of the same bodies, and
// their surfaces and responses to strikes.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "closed_forms.hpp"
#include "core/files.hpp"
#include "core/temporary_folder.hpp"
#include "solve.hpp"
#include "solvers/axisymmetric/solve_axisymmetric.hpp"
#include "solvers/families/families.hpp"
#include "solvers/mesh/repair/detail/surface_topology.hpp"
#include "solvers/modes/modes_file.hpp"
#include "synth/modal/ring_down.hpp"

namespace carillon {
namespace {

using namespace solvers;
using test::cents;

solvers::mesh::GeneratedShape shape_of(const std::string& family,
                                       const std::map<std::string, double>& given = {}) {
  solvers::mesh::GeneratedShape shape{family, {}, {}};
  for (const auto& p : solvers::families::find_family(family).parameters) {
    shape.parameters[p.name] = 0.5 * (p.low + p.high);
  }
  for (const auto& [name, value] : given) shape.parameters[name] = value;
  return shape;
}

solvers::modes::Modes axisymmetric(const solvers::mesh::Meridian& body,
                                   const solvers::elements::Elastic& material, double top,
                                   int max_modes = 1000, double pitch_target = 0.01) {
  solvers::eigen::SolveOptions solve;
  solve.band = {0, top, max_modes};
  core::Trace trace;
  return solvers::axisymmetric::solve_axisymmetric(body, material, solve,
                                                   {.pitch_target = pitch_target}, trace);
}

solvers::modes::Modes axisymmetric(const solvers::mesh::GeneratedShape& shape,
                                   const solvers::elements::Elastic& material, double top,
                                   int max_modes = 1000) {
  return axisymmetric(solvers::families::find_family(shape.family).meridian(shape), material, top,
                      max_modes);
}

solvers::modes::Modes tetrahedra(const solvers::mesh::GeneratedShape& shape,
                                 const solvers::elements::Elastic& material, int modes) {
  solvers::mesh::MeshOptions options;
  options.order = 4;
  return test::lowest_modes(solvers::families::mesh_family(shape, options).mesh, {material}, modes);
}

struct Thick {
  std::string family;
  std::map<std::string, double> given;
  int modes;
};
// NOLINTNEXTLINE(readability-identifier-naming): GoogleTest's name
std::ostream& operator<<(std::ostream& out, const Thick& c) {
  return out << c.family;
}

class Against3d : public testing::TestWithParam<Thick> {};

/// Elements lie above the truth by their own error, and below only by that of their geometry.
TEST_P(Against3d, TheLowestModesAgree) {
  const auto& [family, given, count] = GetParam();
  const auto shape = shape_of(family, given);
  const auto solid = tetrahedra(shape, test::glass, count);
  const auto modes = axisymmetric(shape, test::glass, 1.01 * solid.frequency(solid.size() - 1));
  ASSERT_GE(modes.size(), solid.size());
  EXPECT_NEAR(modes.mass / solid.mass, 1, 1e-4);
  for (std::size_t k = 0; k < solid.size(); ++k) {
    const double error = cents(solid.frequency(k), modes.frequency(k));
    EXPECT_GT(error, -0.1) << "mode " << k + 1;
    EXPECT_LT(error, 5) << "mode " << k + 1 << " harmonic " << modes.shapes.waves()[k].harmonic;
    EXPECT_LT(modes.pitch_errors[k], 0.02) << "mode " << k + 1;
  }
}

INSTANTIATE_TEST_SUITE_P(Families, Against3d,
                         testing::Values(Thick{"bowl", {{"wall", 0.006}}, 8},
                                         Thick{"cup", {{"wall", 0.005}}, 8},
                                         Thick{"vase", {{"wall", 0.008}, {"height", 0.16}}, 8},
                                         Thick{"plate", {{"wall", 0.006}}, 8},
                                         Thick{"disc", {}, 12}, Thick{"sphere", {}, 21},
                                         Thick{"torus", {}, 8}),
                         [](const auto& given) { return given.param.family; });

/// Energy of the response along d at the surface point nearest to `where`: sum over a pair of
/// (phi . d)^2, which no choice of basis in the pair changes.
double response(const solvers::modes::Modes& modes, std::size_t first, std::size_t count,
                const Vec3& where, const Vec3& direction) {
  const synth::modal::SurfaceSampler sampler(modes.surface);
  const auto shapes = synth::modal::shapes_at(modes, sampler.nearest(where));
  double sum = 0;
  for (std::size_t k = first; k < first + count; ++k) {
    sum += std::pow(shapes.row(static_cast<Eigen::Index>(k)) * direction, 2);
  }
  return sum;
}

TEST(AxisymmetricShapes, RespondAsTetrahedraDo) {
  const auto shape = shape_of("bell");
  const auto solid = tetrahedra(shape, test::glass, 6);
  const auto modes = axisymmetric(shape, test::glass, 1.01 * solid.frequency(5));
  const double radius = shape.parameters.at("radius");
  for (std::size_t k = 0; k < 6; ++k) {
    EXPECT_LT(std::abs(cents(solid.frequency(k), modes.frequency(k)) - 2.5), 2.6);
  }
  // Three pairs, far from each other, struck outward at the mouth.
  for (std::size_t pair = 0; pair < 6; pair += 2) {
    for (const double angle : {0.3, 2.0, 5.1}) {
      const Vec3 out(std::cos(angle), std::sin(angle), 0);
      const Vec3 point = radius * out + Vec3(0, 0, 0.002);
      const double here = response(modes, pair, 2, point, out);
      const double there = response(solid, pair, 2, point, out);
      EXPECT_GT(here, 0);
      EXPECT_NEAR(here / there, 1, 0.01) << "pair " << pair << " angle " << angle;
    }
  }
}

/// Turning a body about its axis does not change what a pair answers: at nodes on one circle the
/// pair's displacements along, around and across the axis have one sum of squares each.
TEST(AxisymmetricShapes, PairsKnowNoDirection) {
  const auto modes = axisymmetric(shape_of("bowl"), test::glass, 12000);
  ASSERT_GT(modes.size(), 20u);
  const auto& nodes = modes.surface.nodes;
  for (std::size_t k = 0; k<modes.size(); k += modes.shapes.waves()[k].harmonic> 0 ? 2 : 1) {
    const std::size_t count = modes.shapes.waves()[k].harmonic > 0 ? 2 : 1;
    // Circles by height and radius, in micrometres.
    std::map<std::pair<long, long>, Eigen::Vector3d> first;
    double largest = 0, difference = 0;
    for (std::size_t n = 0; n < nodes.size(); ++n) {
      const double radius = nodes[n].head<2>().norm();
      if (radius == 0) continue;
      const double c = nodes[n].x() / radius, s = nodes[n].y() / radius;
      Eigen::Vector3d squares = Eigen::Vector3d::Zero();
      for (std::size_t m = k; m < k + count; ++m) {
        const Eigen::Vector3d u = modes.shapes.at(static_cast<Eigen::Index>(n))
                                      .row(static_cast<Eigen::Index>(m))
                                      .transpose();
        squares += Eigen::Vector3d(c * u.x() + s * u.y(), c * u.y() - s * u.x(), u.z()).cwiseAbs2();
      }
      const auto [circle, is_new] =
          first.try_emplace({std::lround(1e6 * radius), std::lround(1e6 * nodes[n].z())}, squares);
      largest = std::max(largest, squares.sum());
      difference = std::max(difference, (squares - circle->second).cwiseAbs().maxCoeff());
    }
    EXPECT_LT(difference, 1e-3 * largest) << "mode " << k + 1;
    if (count == 2) {
      EXPECT_EQ(modes.eigenvalues[k], modes.eigenvalues[k + 1]);
      EXPECT_EQ(modes.shapes.waves()[k].harmonic, modes.shapes.waves()[k + 1].harmonic);
    }
  }
}

TEST(AxisymmetricSurface, EncloseTheBody) {
  for (const auto& family : solvers::families::families()) {
    if (!family.meridian || family.parameters.empty()) continue;
    const auto shape = shape_of(family.name);
    const auto size = solvers::mesh::measure(family.meridian(shape));
    const auto modes = axisymmetric(shape, test::steel, 12000, 4);
    const auto surface = solvers::modes::flatten(modes.surface);
    EXPECT_TRUE(solvers::mesh::repair::is_closed_and_oriented(surface.triangles)) << family.name;
    const double volume = modes.mass / test::steel.density;
    EXPECT_NEAR(solvers::mesh::signed_volume(surface) / volume, 1, 0.02) << family.name;
    EXPECT_NEAR(solvers::mesh::area(surface) / size.surface, 1, 0.02) << family.name;
    EXPECT_NEAR(size.volume / volume, 1, 0.02) << family.name;
  }
}

TEST(AxisymmetricModes, KeepTheirHarmonicsInFilesAndBands) {
  const auto modes = axisymmetric(shape_of("ring"), test::steel, 20000);
  ASSERT_GT(modes.size(), 6u);
  const auto upper = solvers::modes::restrict_to(modes, {modes.frequency(3), 20000, 300});
  ASSERT_EQ(upper.size(), modes.shapes.waves().size() - (modes.size() - upper.size()));
  EXPECT_EQ(upper.shapes.waves().back(), modes.shapes.waves().back());
  const core::TemporaryFolder folder;
  const auto path = folder.path() / "modes.h5";
  solvers::modes::write_modes(core::Hdf5Group::create_file(path), modes);
  EXPECT_EQ(solvers::modes::read_modes(core::Hdf5Group::open_file(path)).shapes.waves(),
            modes.shapes.waves());
}

solvers::mesh::GeneratedShape turned(const std::vector<std::array<double, 2>>& profile) {
  return {"turned", {}, profile};
}

void expect_same(const solvers::modes::Modes& a, const solvers::modes::Modes& b, double maximum) {
  ASSERT_EQ(a.size(), b.size());
  ASSERT_GT(a.size(), 10u);
  for (std::size_t k = 0; k < a.size(); ++k) {
    EXPECT_LT(std::abs(cents(a.frequency(k), b.frequency(k))), maximum) << "mode " << k + 1;
    EXPECT_EQ(a.shapes.waves()[k], b.shapes.waves()[k]) << "mode " << k + 1;
  }
}

/// Triangulated sections against rectangles, one that keeps off the axis and one whose cells meet
/// it in sides and in corners.
TEST(AxisymmetricTurned, PolygonsGiveWhatRectanglesGive) {
  expect_same(
      axisymmetric(turned({{0.04, 0}, {0.05, 0}, {0.05, 0.01}, {0.04, 0.01}}), test::steel, 30000),
      axisymmetric(solvers::mesh::rectangular_meridian({0.04, 0.05}, {0, 0.01}), test::steel,
                   30000),
      0.01);
  expect_same(
      axisymmetric(turned({{0, 0}, {0.02, 0}, {0.02, 0.06}, {0, 0.06}}), test::steel, 70000),
      axisymmetric(solvers::mesh::rectangular_meridian({0, 0.02}, {0, 0.06}), test::steel, 70000),
      0.01);
}

/// A disc much thicker than it is wide has one block, as a cylinder has.
TEST(AxisymmetricTurned, AThickDiscIsACylinder) {
  const auto meridian_of = [](const char* family, const char* along) {
    return solvers::families::find_family(family).meridian(
        {family, {{"radius", 0.01}, {along, 0.12}}, {}});
  };
  expect_same(axisymmetric(meridian_of("disc", "thickness"), test::steel, 70000),
              axisymmetric(meridian_of("cylinder", "length"), test::steel, 70000), 0.01);
}

/// A goblet's foot: re-entrant corners, graded in one and cut into other blocks in the other.
TEST(AxisymmetricTurned, ReentrantCornersConverge) {
  const auto polygon =
      turned({{0, 0}, {0.04, 0}, {0.04, 0.01}, {0.012, 0.01}, {0.012, 0.05}, {0, 0.05}});
  solvers::mesh::Meridian blocks =
      solvers::mesh::rectangular_meridian({0, 0.012, 0.04}, {0, 0.01, 0.05});
  blocks.blocks.pop_back();
  solvers::mesh::grade_towards(blocks, 4, 4);
  expect_same(axisymmetric(polygon, test::steel, 40000), axisymmetric(blocks, test::steel, 40000),
              0.03);
}

/// Outlines whose corners turn inward, by 10 degrees (three cones) and by 90 (a stepped shaft): no
/// polynomial follows the field there.
TEST(AxisymmetricTurned, ErrorBarsHoldWhereCornersTurnInward) {
  for (const auto& profile :
       {std::vector<std::array<double, 2>>{
            {0, 0}, {0.0149, 0}, {0.0426, 0.02}, {0.025, 0.04}, {0.0126, 0.06}, {0, 0.06}},
        {{0, 0}, {0.03, 0}, {0.03, 0.03}, {0.015, 0.03}, {0.015, 0.09}, {0, 0.09}}}) {
    const auto body = solvers::families::find_family("turned").meridian(turned(profile));
    const auto usual = axisymmetric(body, test::steel, 1e9, 16, 5);
    const auto fine = axisymmetric(body, test::steel, 1e9, 16, 0.01);
    ASSERT_GE(usual.size(), 12u);
    for (std::size_t k = 0; k < 12; ++k) {
      const double error = std::abs(cents(usual.frequency(k), fine.frequency(k)));
      EXPECT_LE(error, usual.pitch_errors[k]) << "mode " << k + 1;
      EXPECT_LT(fine.pitch_errors[k], 0.4 * usual.pitch_errors[k]) << "mode " << k + 1;
    }
  }
}

}  // namespace
}  // namespace carillon
