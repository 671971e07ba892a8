// Ill-shaped elements, thin bodies, curved walls, tiny and huge bodies.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "../solvers/closed_forms.hpp"
#include "../solvers/family_shapes.hpp"
#include "../solvers/test_meshes.hpp"
#include "core/error.hpp"
#include "hard_case.hpp"
#include "solvers/axisymmetric/solve_axisymmetric.hpp"
#include "tests/solvers/written_files.hpp"

namespace carillon {
namespace {

using namespace solvers;
using namespace test;

const Vec3 block_sides(0.02, 0.03, 0.05);
constexpr std::array<int, 3> block_cells = {2, 3, 5};

std::vector<double> block_truth(std::size_t count) {
  return box_frequencies({0.02, 0.03, 0.05}, {8, 9, 11}, 2.0e11, 0.29, 7850, count);
}

/// A layer of tetrahedra of 0.1 degree inside, orders 1 to 4: the modes stay those of the mesh
/// without it, but for the layer's crossed diagonals, which are another mesh of the same fineness.
TEST(Hard, SliversOfATenthOfADegree) {
  const auto truth = block_truth(20);
  const double max_apart[] = {100, 30, 2, 0.1};
  for (int order = 1; order <= 4; ++order) {
    SCOPED_TRACE(order);
    const auto whole = box_mesh(block_sides, block_cells, order);
    const auto spoiled = sliver_mesh(block_sides, block_cells, 2, 0.1, order);
    const auto quality = solvers::mesh::measure_quality(spoiled);
    EXPECT_NEAR(quality.min_dihedral_deg, 0.1, 1e-4);
    EXPECT_NEAR(quality.volume, 0.02 * 0.03 * 0.05, 1e-17);
    EXPECT_EQ(spoiled.faces.size(), whole.faces.size()) << "the slivers lie inside";
    const auto modes = lowest_modes(spoiled, {steel}, 20);
    expect_sound(modes);
    const auto unspoiled = frequencies(lowest_modes(whole, {steel}, 20));
    EXPECT_LT(worst_cents(frequencies(modes), unspoiled, 20), max_apart[order - 1]);
    EXPECT_LT(worst_cents(frequencies(modes), truth, 20), 1.25 * worst_cents(unspoiled, truth, 20));
  }
}

/// Flatter slivers change nothing as long as double precision holds, and are refused beyond: modes
/// come out right or not at all.
TEST(Hard, SliversOfAnyFlatness) {
  const auto limit =
      frequencies(lowest_modes(sliver_mesh(block_sides, block_cells, 2, 1e-3, 3), {steel}, 20));
  for (const double dihedral : {1e-4, 1e-6, 1e-8, 1e-10, 1e-12}) {
    SCOPED_TRACE(dihedral);
    const auto spoiled = sliver_mesh(block_sides, block_cells, 2, dihedral, 3);
    const auto solve = [&] {
      const auto modes = lowest_modes(spoiled, {steel}, 20);
      expect_sound(modes, 1);
      EXPECT_LT(worst_cents(frequencies(modes), limit, 20), 0.01);
    };
    if (dihedral >= 1e-8) {
      solve();
      continue;
    }
    const auto refusal = message_of<core::SolverError>(solve);
    EXPECT_TRUE(refusal.empty() || refusal.find("nearly flat") != std::string::npos) << refusal;
  }
}

/// A whole layer of cells pressed to 1/2000 of its thickness, beside good ones.
TEST(Hard, APressedLayer) {
  const double layer = 0.05 / 6;
  const auto pressed = moved(box_mesh(block_sides, {3, 4, 6}, 1), [layer](const Vec3& x) -> Vec3 {
    if (x[2] < 1.5 * layer || x[2] > 2.5 * layer) return x;
    return {x[0], x[1], layer * (1 + 5e-4)};
  });
  const auto modes = lowest_modes(with_order(pressed, 3), {steel}, 10);
  expect_sound(modes);
  EXPECT_LT(worst_cents(frequencies(modes), block_truth(10), 10), 5);
}

/// Steel sheet of 100 x 100 x 0.1 mm, one element through it: within a cent of polynomials on the
/// solid box, and of Kirchhoff's plate, omega a^2 sqrt(rho h / D) = 13.468, 19.596, 24.270 at
/// nu = 0.3 (Leissa 1973, table C.18).
TEST(Hard, PlateOfATenthOfAMillimetre) {
  const double side = 0.1, thickness = 1e-4;
  const solvers::elements::Elastic material{2.0e11, 0.3, 7850};
  const auto modes = lowest_modes(box_mesh({side, side, thickness}, {6, 6, 1}, 4), {material}, 10);
  // In double precision no vector has a small residual here; see EigenPairs::energy_residuals.
  expect_sound(modes, 1);
  const auto ritz = box_frequencies({side, side, thickness}, {12, 12, 3}, 2.0e11, 0.3, 7850, 10);
  EXPECT_LT(worst_cents(frequencies(modes), ritz, 10), 1);
  const double rigidity = material.youngs_modulus * std::pow(thickness, 3) / (12 * (1 - 0.09));
  const double unit =
      std::sqrt(rigidity / (material.density * thickness)) / (2 * std::numbers::pi * side * side);
  EXPECT_LT(worst_cents(frequencies(modes), {13.468 * unit, 19.596 * unit, 24.270 * unit}, 3), 1);
  EXPECT_NEAR(modes.frequency(0), 32.7, 0.1);
}

/// A wire of 1 m, 1 x 1.2 mm thick: bending in both planes as Euler and Bernoulli have it, whose
/// shear and rotary inertia are 1e-5 here. (beta L)^2 = 22.3733, 61.6728, 120.9034.
TEST(Hard, WireOfAThousandThicknesses) {
  const double length = 1, width = 1.2e-3, height = 1e-3;
  const auto modes = lowest_modes(box_mesh({height, width, length}, {1, 1, 16}, 4), {steel}, 6);
  expect_sound(modes, 1);
  std::vector<double> truth;
  for (const double thickness : {width, height})
    for (const double root : {22.3733, 61.6728, 120.9034})
      truth.push_back(root / (2 * std::numbers::pi * length * length) * thickness *
                      std::sqrt(steel.youngs_modulus / (12 * steel.density)));
  std::sort(truth.begin(), truth.end());
  EXPECT_LT(worst_cents(frequencies(modes), truth, 6), 1);
}

/// Every corner of every element lies on the surface.
bool one_element_through(const TetMesh& mesh) {
  std::vector<bool> on_surface(mesh.nodes.size(), false);
  for (const auto n : mesh.faces) on_surface[static_cast<std::size_t>(n)] = true;
  for (std::size_t e = 0; e < mesh.element_count(); ++e)
    for (const auto n : mesh.element(e).first(4))
      if (!on_surface[static_cast<std::size_t>(n)]) return false;
  return true;
}

struct CurvedWall {
  GeneratedShape shape;
  int order;
  double size;       ///< of the elements [m]
  double max_cents;  ///< of the first 16 modes
};

/// One element through a curved wall, against the body's own Fourier harmonics on its section.
TEST(Hard, OneElementThroughACurvedWall) {
  const auto tube = shape_of("tube", {{"radius", 0.02}, {"wall", 0.003}, {"length", 0.1}});
  const auto bowl = shape_of(
      "bowl", {{"radius", 0.06}, {"base_radius", 0.03}, {"height", 0.04}, {"wall", 0.004}});
  for (const CurvedWall& wall :
       {CurvedWall{tube, 3, 0.012, 8}, {tube, 4, 0.018, 2}, {bowl, 3, 0.022, 30}}) {
    SCOPED_TRACE(wall.shape.family);
    const auto mesh = mesh_of(wall.shape, wall.order, wall.size).mesh;
    EXPECT_TRUE(one_element_through(mesh));
    const auto modes = lowest_modes(mesh, {aluminium}, 16);
    expect_sound(modes, 1e-7);
    core::Trace trace;
    solvers::eigen::SolveOptions options;
    options.band = {0, 1e9, 16};
    const auto truth = solvers::axisymmetric::solve_axisymmetric(
        find_family(wall.shape.family).meridian(wall.shape), aluminium, options, {}, trace);
    ASSERT_EQ(modes.size(), truth.size());
    EXPECT_LT(worst_cents(frequencies(modes), frequencies(truth), modes.size()), wall.max_cents);
  }
}

/// A disc of elements six to ten times as wide as thick: errors that single elements cannot tell.
TEST(Hard, PitchErrorsOfFlatElements) {
  const auto disc = shape_of("disc", {{"radius", 0.15}, {"thickness", 0.003}});
  core::Trace trace;
  solvers::eigen::SolveOptions options;
  options.band = {0, 1e9, 16};
  const auto truth = solvers::axisymmetric::solve_axisymmetric(find_family("disc").meridian(disc),
                                                               steel, options, {}, trace);
  for (const int order : {2, 3, 4}) {
    const auto modes = lowest_modes(mesh_of(disc, order).mesh, {steel}, 16);
    ASSERT_EQ(modes.size(), truth.size());
    int compared = 0;
    for (std::size_t k = 0; k < modes.size(); ++k) {
      const double error = std::abs(cents(modes.frequency(k), truth.frequency(k)));
      if (error < 0.2) continue;
      ++compared;
      EXPECT_GT(modes.pitch_errors[k], 0.5 * error) << "order " << order << ", mode " << k + 1;
      EXPECT_LT(modes.pitch_errors[k], 3 * error) << "order " << order << ", mode " << k + 1;
    }
    EXPECT_GT(compared, 4) << order;
  }
}

/// The same body from a micrometre to 100 m with its band: one result in units of 1 / length.
TEST(Hard, AMicrometreAndAHundredMetres) {
  const auto body = box_mesh({0.4, 0.6, 1}, {2, 3, 4}, 3);
  const solvers::modes::Band band{500, 8000, 300};
  const auto truth = modes_in(body, {steel}, band);
  expect_sound(truth);
  expect_complete(truth);
  ASSERT_GT(truth.size(), 20u);
  for (const double length : {1e-6, 1e-3, 100.0}) {
    SCOPED_TRACE(length);
    const auto scaled = moved(body, [length](const Vec3& x) -> Vec3 { return length * x; });
    const auto modes =
        modes_in(scaled, {steel}, {band.min_frequency / length, band.max_frequency / length, 300});
    expect_sound(modes);
    expect_complete(modes);
    ASSERT_EQ(modes.size(), truth.size());
    EXPECT_EQ(modes.pitch_errors.size(), truth.pitch_errors.size());
    const double mass = std::pow(length, 3);
    EXPECT_NEAR(modes.mass / truth.mass / mass, 1, 1e-12);
    double apart = 0;
    for (std::size_t k = 0; k < truth.size(); ++k) {
      EXPECT_NEAR(modes.frequency(k) * length / truth.frequency(k), 1, 1e-9);
      if (!truth.pitch_errors.empty()) {
        // The estimate stops when its own gain is known to a few per cent.
        EXPECT_NEAR(modes.pitch_errors[k], truth.pitch_errors[k],
                    0.06 * truth.pitch_errors[k] + 1e-3);
      }
      const auto row = static_cast<Eigen::Index>(k);
      const Eigen::VectorXd shape = std::sqrt(mass) * modes.shapes.of(row);
      const Eigen::VectorXd right = truth.shapes.of(row);
      apart = std::max(apart, (shape - right).cwiseAbs().maxCoeff() / right.cwiseAbs().maxCoeff());
    }
    EXPECT_LT(apart, 1e-5);
  }
}

}  // namespace
}  // namespace carillon
