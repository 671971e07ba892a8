// Modes that repeat, exactly or nearly: cubes, rings, bowls, and equal bodies side by side.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "../solvers/closed_forms.hpp"
#include "../solvers/family_shapes.hpp"
#include "../solvers/test_meshes.hpp"
#include "hard_case.hpp"
#include "solvers/axisymmetric/solve_axisymmetric.hpp"

namespace carillon {
namespace {

using namespace solvers;
using namespace test;

constexpr double side = 0.05;

/// Neighbours in an ascending list that belong together.
struct Cluster {
  std::size_t first, count;
};

std::vector<Cluster> clusters_of(const std::vector<double>& ascending, double gap) {
  std::vector<Cluster> out;
  std::size_t first = 0;
  for (const int size : cluster_sizes(ascending, gap)) {
    out.push_back({first, static_cast<std::size_t>(size)});
    first += out.back().count;
  }
  return out;
}

/// Largest minus smallest [cents].
double spread(const std::vector<double>& ascending, const Cluster& cluster) {
  return cents(ascending.at(cluster.first + cluster.count - 1), ascending.at(cluster.first));
}

std::vector<double> cube_truth(const Vec3& sides, std::size_t count) {
  return box_frequencies({sides[0], sides[1], sides[2]}, {10, 10, 10}, steel.youngs_modulus,
                         steel.poisson_ratio, steel.density, count);
}

/// Lame's modes of the cube's three mid-planes have one frequency, c_T / (sqrt(2) a), without any
/// symmetry that would make a mesh repeat all three.
bool is_lame(double frequency) {
  const double shear = steel.youngs_modulus / (2 * (1 + steel.poisson_ratio));
  const double lame = std::sqrt(shear / steel.density) / (std::sqrt(2.0) * side);
  return std::abs(frequency / lame - 1) < 1e-5;
}

/// A mesh with the cube's symmetries repeats its pairs and triples to rounding; all come whole.
TEST(Hard, CubeOnASymmetricMesh) {
  const auto truth = cube_truth(Vec3::Constant(side), 29);
  const auto modes =
      modes_in(symmetric_box_mesh(Vec3::Constant(side), {2, 2, 2}, 3), {steel}, {20, 63000, 300});
  expect_sound(modes);
  expect_complete(modes);
  const auto found = frequencies(modes);
  ASSERT_EQ(found.size(), 29u);
  EXPECT_LT(worst_cents(found, truth, 29), 5);
  const auto clusters = clusters_of(truth, 1e-6);
  ASSERT_EQ(cluster_sizes(truth, 1e-6), (std::vector<int>{2, 3, 3, 3, 3, 3, 2, 1, 3, 3, 3}));
  for (const auto& cluster : clusters) {
    EXPECT_LT(spread(found, cluster), is_lame(truth[cluster.first]) ? 0.5 : 1e-8)
        << cluster.count << "-fold at " << truth[cluster.first] << " Hz";
  }
}

/// On a mesh of less symmetry they come out close, and as many.
TEST(Hard, CubeOnAnUnsymmetricMesh) {
  const auto truth = cube_truth(Vec3::Constant(side), 30);
  const auto modes = lowest_modes(box_mesh({side, side, side}, {3, 3, 3}, 3), {steel}, 30);
  expect_sound(modes);
  const auto found = frequencies(modes);
  // The thirtieth belongs to a pair: it is left out as a whole.
  ASSERT_EQ(found.size(), 29u);
  EXPECT_LT(worst_cents(found, truth, 29), 10);
  for (const auto& cluster : clusters_of(truth, 1e-6)) {
    if (cluster.first + cluster.count > found.size()) break;
    EXPECT_LT(spread(found, cluster), 5) << truth[cluster.first] << " Hz";
  }
}

/// Sum over a cluster of phi phi^T, at a few nodes of the surface: what a strike sees of it.
Eigen::MatrixXd projector(const solvers::modes::Modes& modes, const Cluster& cluster) {
  Eigen::MatrixXd sample(static_cast<Eigen::Index>(cluster.count), 30);
  for (Eigen::Index row = 0; row < sample.rows(); ++row) {
    const Eigen::VectorXd shape = modes.shapes.of(static_cast<Eigen::Index>(cluster.first) + row);
    for (Eigen::Index c = 0; c < sample.cols(); ++c) sample(row, c) = shape[17 * c % shape.size()];
  }
  return sample.transpose() * sample;
}

/// Sides that differ by 1e-6 split what the cube repeats. Splits come out as polynomials on the
/// same box have them, though they are a thousand times smaller than the mesh's own error, and the
/// sum over a cluster stays that of the cube while the modes inside turn into others.
TEST(Hard, NearlyACube) {
  const Vec3 sides(side, side * (1 + 1e-6), side * (1 + 3e-6));
  const auto truth = cube_truth(sides, 29);
  const auto modes = lowest_modes(symmetric_box_mesh(sides, {2, 2, 2}, 3), {steel}, 29);
  const auto cube =
      lowest_modes(symmetric_box_mesh(Vec3::Constant(side), {2, 2, 2}, 3), {steel}, 29);
  expect_sound(modes);
  ASSERT_EQ(modes.size(), 29u);
  ASSERT_EQ(cube.size(), 29u);
  const auto found = frequencies(modes);
  int compared = 0;
  for (const auto& cluster : clusters_of(truth, 1e-5)) {
    const auto first = cluster.first;
    if (is_lame(truth[first])) continue;
    for (std::size_t k = first + 1; k < first + cluster.count; ++k) {
      const double expected = truth[k] / truth[first] - 1;
      EXPECT_GT(expected, 5e-8);
      EXPECT_NEAR((found[k] / found[first] - 1) / expected, 1, 0.05) << truth[first] << " Hz";
      ++compared;
    }
    const auto turned = projector(modes, cluster), whole = projector(cube, cluster);
    EXPECT_LT((turned - whole).norm(), 1e-4 * whole.norm()) << truth[first] << " Hz";
  }
  EXPECT_GT(compared, 12);
}

struct Round {
  GeneratedShape shape;
  double size;        ///< of the elements [m]
  double max_cents;   ///< from the truth
  double max_spread;  ///< between the two of a pair [cents]
};

/// Bodies of revolution: every harmonic from n = 1 on comes in pairs, as many as the section's own
/// harmonics have and within a small part of a cent.
TEST(Hard, PairsOfARingAndABowl) {
  const auto ring = shape_of("ring", {{"radius", 0.05}, {"inner_radius", 0.04}, {"height", 0.01}});
  const auto bowl = shape_of(
      "bowl", {{"radius", 0.06}, {"base_radius", 0.03}, {"height", 0.04}, {"wall", 0.004}});
  for (const Round& body : {Round{ring, 0.015, 2, 0.01}, {bowl, 0.022, 30, 0.1}}) {
    SCOPED_TRACE(body.shape.family);
    const auto modes = lowest_modes(mesh_of(body.shape, 3, body.size).mesh, {steel}, 20);
    expect_sound(modes, 1e-7);
    const auto found = frequencies(modes);
    core::Trace trace;
    solvers::eigen::SolveOptions options;
    options.band = {0, 1e9, 20};
    const auto truth = solvers::axisymmetric::solve_axisymmetric(
        find_family(body.shape.family).meridian(body.shape), steel, options, {}, trace);
    ASSERT_EQ(modes.size(), truth.size());
    EXPECT_LT(worst_cents(found, frequencies(truth), found.size()), body.max_cents);
    for (const auto& cluster : clusters_of(frequencies(truth), 1e-9)) {
      EXPECT_EQ(cluster.count, truth.shapes.waves()[cluster.first].harmonic == 0 ? 1u : 2u);
      EXPECT_LT(spread(found, cluster), body.max_spread) << found[cluster.first] << " Hz";
    }
  }
}

/// The same ring against a table made by polynomials in polar coordinates.
TEST(Hard, PairsOfTheTabulatedRing) {
  const auto folder = data_folder();
  if (folder.empty()) GTEST_SKIP() << "CARILLON_TEST_DATA is not set";
  const auto file = folder + "/reference_modes/ring_steel_Ro50_Ri40_h10mm.csv";
  const auto frequency = csv_column(file, "f_hz"), count = csv_column(file, "multiplicity");
  const auto ring = shape_of("ring", {{"radius", 0.05}, {"inner_radius", 0.04}, {"height", 0.01}});
  const auto modes =
      modes_in(mesh_of(ring, 3, 0.015).mesh, {{2.0e11, 0.29, 7850}}, {20, 25500, 300});
  expect_sound(modes);
  expect_complete(modes);
  std::vector<double> truth;
  for (std::size_t k = 0; k < frequency.size() && std::stod(frequency[k]) < 25500; ++k)
    truth.insert(truth.end(), static_cast<std::size_t>(std::stoi(count[k])),
                 std::stod(frequency[k]));
  ASSERT_EQ(modes.size(), truth.size());
  ASSERT_EQ(truth.size(), 24u);
  EXPECT_LT(worst_cents(frequencies(modes), truth, truth.size()), 2);
  EXPECT_EQ(cluster_sizes(frequencies(modes), 1e-5), cluster_sizes(truth, 1e-9));
}

/// Exactly repeated: identical bodies beside each other give every mode many times.
TEST(Hard, EightEqualBodies) {
  const auto one = box_mesh({0.02, 0.03, 0.05}, {1, 2, 3}, 2);
  auto all = one;
  for (int n = 1; n < 8; ++n) {
    all = joined(all, moved(one, [n](const Vec3& x) -> Vec3 { return x + Vec3(0.03 * n, 0, 0); }));
  }
  const std::vector<solvers::elements::Elastic> regions(8, steel);
  const auto single = lowest_modes(one, {steel}, 6);
  const auto modes = lowest_modes(all, regions, 44);
  expect_sound(modes);
  EXPECT_EQ(modes.certificate.components, 8);
  EXPECT_EQ(modes.certificate.rigid_modes, 48);
  // 44 would cut the sixth eightfold mode: five come whole.
  ASSERT_EQ(modes.size(), 40u);
  for (std::size_t k = 0; k < modes.size(); ++k) {
    EXPECT_NEAR(modes.frequency(k) / single.frequency(k / 8), 1, 1e-9) << k;
  }
  // Complete up to the one that is left out, and no further.
  EXPECT_FALSE(modes.certificate.complete);
  EXPECT_GT(modes.certificate.complete_to_hz, single.frequency(4));
  EXPECT_LE(modes.certificate.complete_to_hz, single.frequency(5) * (1 + 1e-9));
}

/// A bar of square section, sides equal but for 1e-7: bending in two planes.
TEST(Hard, BarOfNearlySquareSection) {
  const auto modes =
      lowest_modes(box_mesh({0.02, 0.02 * (1 + 1e-7), 0.1}, {2, 2, 8}, 3), {steel}, 12);
  expect_sound(modes);
  EXPECT_LT(cents(modes.frequency(1), modes.frequency(0)), 0.5);
}

}  // namespace
}  // namespace carillon
