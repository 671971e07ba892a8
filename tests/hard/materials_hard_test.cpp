// Materials at their limits: nearly incompressible, auxetic, extreme, and of extreme contrast.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "../solvers/closed_forms.hpp"
#include "../solvers/test_meshes.hpp"
#include "core/temporary_folder.hpp"
#include "hard_case.hpp"
#include "solvers/mesh/raise_order.hpp"
#include "solvers/mesh/readers/read_mesh.hpp"
#include "tests/solvers/written_files.hpp"

namespace carillon {
namespace {

using namespace solvers;
using namespace test;

/// The lowest modes of a sphere, each as often as it comes; whole multiplets, `count` in all.
std::vector<double> sphere_truth(double nu, std::size_t count) {
  std::vector<double> truth;
  for (double top = 5000; truth.size() < count; top *= 1.5) {
    truth.clear();
    for (const auto& mode : sphere_modes(0.05, 1e9, nu, 1000, top))
      truth.insert(truth.end(), static_cast<std::size_t>(2 * mode.degree + 1), mode.frequency);
  }
  truth.resize(count);
  return truth;
}

/// Worst error [cents] of a sphere's first 20 modes, elements of one size.
double sphere_error(double nu, int order) {
  const auto modes = lowest_modes(ball_mesh(0.05, 2, order), {{1e9, nu, 1000}}, 20);
  expect_sound(modes);
  return worst_cents(frequencies(modes), sphere_truth(nu, 20), 20);
}

/// Volumetric locking, in cents against Lamb's sphere. Order 2 loses two thirds of its accuracy at
/// nu = 0.49 and more beyond; orders 3 and 4 stay ten and a hundred times nearer.
TEST(Hard, NearlyIncompressibleSphere) {
  struct Limit {
    double nu;
    double cents[3];  ///< at orders 2, 3 and 4
  };
  for (const auto& [nu, maximum] : {Limit{0.3, {60, 4, 0.4}},
                                    {0.49, {110, 9, 0.9}},
                                    {0.499, {220, 28, 3}},
                                    {0.4999, {420, 70, 9}}}) {
    double before = 1e9;
    for (int order = 2; order <= 4; ++order) {
      const double error = sphere_error(nu, order);
      EXPECT_LT(error, maximum[order - 2]) << "nu " << nu << " order " << order;
      EXPECT_LT(error, before / 5) << "nu " << nu << " order " << order;
      before = error;
    }
  }
}

/// The same on a block, against polynomials.
TEST(Hard, NearlyIncompressibleBlock) {
  for (const double nu : {0.45, 0.49, 0.499}) {
    const auto truth = box_frequencies({0.02, 0.03, 0.05}, {7, 8, 10}, 1e9, nu, 1000, 10);
    const auto modes =
        lowest_modes(box_mesh({0.02, 0.03, 0.05}, {2, 3, 5}, 3), {{1e9, nu, 1000}}, 10);
    expect_sound(modes);
    EXPECT_LT(worst_cents(frequencies(modes), truth, 10), 10) << nu;
  }
}

TEST(Hard, AuxeticAndZeroPoissonRatio) {
  for (const double nu : {0.0, -0.5, -0.8}) {
    const auto truth = box_frequencies({0.02, 0.03, 0.05}, {7, 8, 10}, 1e9, nu, 1000, 10);
    const auto modes =
        lowest_modes(box_mesh({0.02, 0.03, 0.05}, {2, 3, 5}, 3), {{1e9, nu, 1000}}, 10);
    expect_sound(modes);
    EXPECT_LT(worst_cents(frequencies(modes), truth, 10), 10) << nu;
  }
}

/// From jelly to diamond, from aerogel to osmium: one dimensionless result.
TEST(Hard, StiffnessAndDensityOfAnySize) {
  const auto body = box_mesh({0.02, 0.03, 0.05}, {1, 2, 3}, 3);
  const auto truth = lowest_modes(body, {{1e9, 0.3, 1000}}, 10);
  expect_sound(truth);
  for (const double modulus : {1e3, 1.2e12})
    for (const double density : {1.0, 22600.0}) {
      const auto modes = lowest_modes(body, {{modulus, 0.3, density}}, 10);
      expect_sound(modes);
      ASSERT_EQ(modes.size(), 10u);
      const double speed = std::sqrt(modulus / density / 1e6);
      for (std::size_t k = 0; k < 10; ++k) {
        EXPECT_NEAR(modes.frequency(k) / truth.frequency(k) / speed, 1, 1e-9);
      }
    }
}

/// Frequency of a free rod of two halves without lateral contraction nearest to a guess [Hz]:
/// Z1 sin(k1 l) cos(k2 l) + Z2 sin(k2 l) cos(k1 l) = 0, Z = rho c. Plane waves u_z(z) are exact in
/// three dimensions at nu = 0.
double axial_root(const solvers::elements::Elastic& first, const solvers::elements::Elastic& second,
                  double half, double guess) {
  const double c1 = std::sqrt(first.youngs_modulus / first.density);
  const double c2 = std::sqrt(second.youngs_modulus / second.density);
  const auto residual = [&](double frequency) {
    const double a = 2 * std::numbers::pi * frequency * half / c1;
    const double b = 2 * std::numbers::pi * frequency * half / c2;
    return first.density * c1 * std::sin(a) * std::cos(b) +
           second.density * c2 * std::sin(b) * std::cos(a);
  };
  double low = 0.99 * guess, high = 1.01 * guess;
  EXPECT_LT(residual(low) * residual(high), 0) << "no root within 1 % of " << guess << " Hz";
  for (int i = 0; i < 100; ++i) {
    const double middle = (low + high) / 2;
    (residual(middle) * residual(low) > 0 ? low : high) = middle;
  }
  return low;
}

/// Axial modes among a set: nothing moves across.
std::vector<std::size_t> axial_modes(const solvers::modes::Modes& modes) {
  std::vector<std::size_t> out;
  for (std::size_t k = 0; k < modes.size(); ++k) {
    const Eigen::VectorXd shape = modes.shapes.of(static_cast<Eigen::Index>(k));
    double across = 0, along = 0;
    for (Eigen::Index i = 0; i < shape.size(); ++i)
      (i % 3 == 2 ? along : across) += std::pow(shape[i], 2);
    if (across < 1e-3 * along) out.push_back(k);
  }
  return out;
}

/// Bar of two halves of 50 mm through a file with physical groups.
TetMesh bar_of_groups() {
  auto bar =
      box_mesh({0.03, 0.04, 0.1}, {1, 1, 6}, 2, [](const Vec3& x) { return x[2] < 0.05 ? 0 : 1; });
  bar.region_names = {"lower half", "upper half"};
  const core::TemporaryFolder folder;
  return solvers::mesh::raise_order(
      solvers::mesh::readers::read_msh(written(folder, "bar.msh", msh_text(bar))), 4);
}

/// Two materials in groups of an MSH file, one a million times softer: the axial modes are those of
/// plane waves to rounding, and the soft half holds the strain.
TEST(Hard, StiffnessContrastOfAMillion) {
  const auto bar = bar_of_groups();
  ASSERT_EQ(bar.region_names, (std::vector<std::string>{"lower half", "upper half"}));
  const solvers::elements::Elastic hard{2e11, 0, 7850}, soft{2e5, 0, 1100};
  const auto modes = lowest_modes(bar, {hard, soft}, 16);
  // K has the hard half's rounding.
  expect_sound(modes, 1e-5);
  const auto axial = axial_modes(modes);
  ASSERT_GE(axial.size(), 1u);
  for (const auto k : axial) {
    const double truth = axial_root(hard, soft, 0.05, modes.frequency(k));
    EXPECT_LT(std::abs(cents(modes.frequency(k), truth)), 1e-4) << modes.frequency(k) << " Hz";
  }
  EXPECT_GT(modes.strain_fraction.col(1).minCoeff(), 0.9999);
  EXPECT_NEAR(modes.mass, 0.03 * 0.04 * 0.05 * (7850 + 1100), 1e-12);
  // The same to any contrast: the lowest axial mode is that of the soft half on a rigid mass.
  for (const double contrast : {1e2, 1e8}) {
    const solvers::elements::Elastic other{2e11 / contrast, 0, 1100};
    const auto set = lowest_modes(bar, {hard, other}, 16);
    const auto first = axial_modes(set);
    ASSERT_FALSE(first.empty()) << contrast;
    const double found = set.frequency(first[0]);
    EXPECT_LT(std::abs(cents(found, axial_root(hard, other, 0.05, found))), 1e-4) << contrast;
  }
}

/// Equal stiffness, densities a million apart: air-light beside heavier than lead.
TEST(Hard, DensityContrastOfAMillion) {
  const solvers::elements::Elastic heavy{1e9, 0, 1e6}, light{1e9, 0, 1};
  for (const int order : {2, 3, 4}) {
    SCOPED_TRACE(order);
    const auto bar = box_mesh({0.03, 0.04, 0.1}, {1, 1, 6}, order,
                              [](const Vec3& x) { return x[2] < 0.05 ? 0 : 1; });
    const auto modes = lowest_modes(bar, {heavy, light}, 30);
    expect_sound(modes);
    EXPECT_GT(modes.kinetic_fraction.col(0).minCoeff(), 0.99);
    const auto axial = axial_modes(modes);
    ASSERT_GE(axial.size(), 1u);
    const double found = modes.frequency(axial[0]);
    const double maximum[] = {5, 0.1, 0.001};
    EXPECT_LT(std::abs(cents(found, axial_root(heavy, light, 0.05, found))), maximum[order - 2]);
  }
}

}  // namespace
}  // namespace carillon
