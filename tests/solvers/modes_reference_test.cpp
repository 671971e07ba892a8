// Frequencies against independent truths: another code's discrete answer, Rayleigh-Ritz and Lamb.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>
#include <string>

#include "closed_forms.hpp"
#include "solve.hpp"
#include "test_meshes.hpp"

namespace carillon {
namespace {

using namespace solvers;
using test::box_frequencies;
using test::box_mesh;
using test::cents;
using test::lowest_modes;

constexpr int compared = 20;

/// Both lie above the truth where the body is a box; elements further than polynomials of a degree
/// that leaves less than half a cent.
void expect_within_cents(const std::vector<double>& found, const std::vector<double>& truth,
                         double maximum, double minimum = -0.5) {
  ASSERT_GE(found.size(), truth.size());
  for (std::size_t k = 0; k < truth.size(); ++k) {
    const double error = cents(found[k], truth[k]);
    EXPECT_GT(error, minimum) << "mode " << k + 1;
    EXPECT_LT(error, maximum) << "mode " << k + 1 << ": " << found[k] << " Hz, " << truth[k]
                              << " Hz expected";
  }
}

TEST(Reference, DiscreteBoxOfAnotherCode) {
  const auto folder = test::data_folder();
  if (folder.empty()) GTEST_SKIP() << "CARILLON_TEST_DATA is not set";
  const auto linear =
      test::read_tetrahedra(folder + "/reference_modes/tet_meshes/box_20x30x50mm_2x3x5.txt");
  const auto file = folder + "/reference_modes/tetfem_box_20x30x50mm_2x3x5.csv";
  for (const int order : {1, 2}) {
    const auto column = test::csv_column(file, order == 1 ? "P1_consistent" : "P2_consistent");
    const auto modes = lowest_modes(test::with_order(linear, order), {test::steel},
                                    static_cast<int>(column.size()));
    ASSERT_EQ(modes.size(), column.size());
    EXPECT_NEAR(modes.mass, 0.2355, 1e-12);
    for (std::size_t k = 0; k < column.size(); ++k) {
      EXPECT_NEAR(modes.frequency(k) / std::stod(column[k]), 1, 1e-6);
    }
  }
}

TEST(Reference, SteelBlockByRayleighRitz) {
  const auto truth = box_frequencies({0.02, 0.03, 0.05}, {8, 9, 11}, 2.0e11, 0.29, 7850, compared);
  const auto modes =
      lowest_modes(box_mesh({0.02, 0.03, 0.05}, {2, 3, 5}, 3), {test::steel}, compared);
  expect_within_cents(test::frequencies(modes), truth, 5);
  const auto finer =
      lowest_modes(box_mesh({0.02, 0.03, 0.05}, {5, 7, 12}, 2), {test::steel}, compared);
  expect_within_cents(test::frequencies(finer), truth, 5);
}

TEST(Reference, GlassPlateByRayleighRitz) {
  const auto truth = box_frequencies({0.1, 0.1, 0.005}, {17, 17, 4}, 6.2e10, 0.2, 2600, compared);
  const auto modes =
      lowest_modes(box_mesh({0.1, 0.1, 0.005}, {12, 12, 1}, 3), {test::glass}, compared);
  expect_within_cents(test::frequencies(modes), truth, 5);
  EXPECT_GT(modes.frequency(0), 20);
  EXPECT_LT(modes.frequency(compared - 1), 20000);
}

TEST(Reference, AluminiumBarByRayleighRitz) {
  const auto truth = box_frequencies({0.01, 0.015, 0.2}, {5, 5, 18}, 7.0e10, 0.33, 2700, compared);
  const auto modes =
      lowest_modes(box_mesh({0.01, 0.015, 0.2}, {1, 1, 14}, 4), {test::aluminium}, compared);
  expect_within_cents(test::frequencies(modes), truth, 5);
}

TEST(Reference, SteelSphereByLamb) {
  const auto roots = test::sphere_modes(0.05, 2.0e11, 0.29, 7850, 45000);
  std::vector<double> truth;
  for (const auto& root : roots) {
    for (int m = 0; m < 2 * root.degree + 1; ++m) truth.push_back(root.frequency);
  }
  ASSERT_EQ(truth.size(), 27u);
  const auto modes = lowest_modes(test::ball_mesh(0.05, 3, 3), {test::steel}, 27);
  expect_within_cents(test::frequencies(modes), truth, 5, -5);
  // Volume and mass follow the curved boundary.
  EXPECT_NEAR(modes.mass / (7850 * 4 * std::numbers::pi / 3 * std::pow(0.05, 3)), 1, 2e-4);
}

/// The oracles themselves against tables made by others.
TEST(Reference, OraclesAgreeWithPublishedTables) {
  const auto folder = test::data_folder();
  if (folder.empty()) GTEST_SKIP() << "CARILLON_TEST_DATA is not set";
  const auto ritz = box_frequencies({0.02, 0.03, 0.05}, {8, 9, 11}, 2.0e11, 0.29, 7850, compared);
  const auto block =
      test::csv_column(folder + "/reference_modes/rpr_block_steel_20x30x50mm.csv", "f_hz");
  for (std::size_t k = 0; k < ritz.size(); ++k) {
    EXPECT_LT(std::abs(cents(ritz[k], std::stod(block[k]))), 0.05);
  }
  const auto file = folder + "/reference_modes/sphere_steel_R50mm.csv";
  const auto frequency = test::csv_column(file, "f_hz");
  const auto degree = test::csv_column(file, "l");
  const auto roots = test::sphere_modes(0.05, 2.0e11, 0.29, 7850, 70000);
  ASSERT_GE(frequency.size(), roots.size());
  for (std::size_t k = 0; k < roots.size(); ++k) {
    EXPECT_NEAR(roots[k].frequency / std::stod(frequency[k]), 1, 1e-9);
    EXPECT_EQ(roots[k].degree, std::stoi(degree[k]));
  }
}

/// Lame's mode of a square cross-section, u = (cos kx sin ky, -sin kx cos ky, 0) with k = pi / a,
/// is an exact mode of a free box of any depth: frequency c_T / (sqrt(2) a). Found by its shape.
double lame_mode(const solvers::modes::Modes& modes, double side) {
  Eigen::VectorXf exact(3 * modes.shapes.nodes());
  for (std::size_t n = 0; n < modes.surface.nodes.size(); ++n) {
    const Vec3 angle = modes.surface.nodes[n] * std::numbers::pi / side;
    exact.segment<3>(3 * static_cast<Eigen::Index>(n)) =
        Vec3(std::cos(angle[0]) * std::sin(angle[1]), -std::sin(angle[0]) * std::cos(angle[1]), 0)
            .cast<float>();
  }
  exact.normalize();
  Eigen::Index best = 0;
  const Eigen::VectorXf likeness =
      (modes.shapes.at_nodes().rowwise().normalized() * exact).cwiseAbs();
  EXPECT_GT(likeness.maxCoeff(&best), 0.9);
  return modes.frequency(static_cast<std::size_t>(best));
}

/// Errors of a smooth mode's eigenvalue fall as h^(2 p), from above.
TEST(Convergence, IsOfTwiceTheOrder) {
  const double side = 0.05;
  const double truth = std::sqrt(2.0e11 / (2 * (1 + 0.29)) / 7850) / (std::sqrt(2.0) * side);
  const std::array<int, 3> coarse[] = {{14, 14, 4}, {6, 6, 2}, {4, 4, 1}, {3, 3, 1}};
  for (int order = 1; order <= 4; ++order) {
    double error[2];
    for (int level = 0; level < 2; ++level) {
      auto cells = coarse[order - 1];
      for (auto& n : cells) n <<= level;
      const auto modes =
          lowest_modes(box_mesh({side, side, 0.3 * side}, cells, order), {test::steel}, 16);
      error[level] = std::pow(lame_mode(modes, side) / truth, 2) - 1;
      EXPECT_GT(error[level], 0);
    }
    const double rate = std::log2(error[0] / error[1]);
    EXPECT_NEAR(rate, 2 * order, 0.5)
        << "order " << order << ", errors " << error[0] << " " << error[1];
  }
}

}  // namespace
}  // namespace carillon
