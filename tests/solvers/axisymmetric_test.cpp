// Bodies of revolution by harmonics, against Rayleigh-Ritz tables, Lamb and tetrahedra.
#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <cmath>
#include <numbers>
#include <ostream>
#include <set>
#include <string>
#include <vector>

#include "closed_forms.hpp"
#include "core/error.hpp"
#include "solve.hpp"
#include "solvers/axisymmetric/solve_axisymmetric.hpp"
#include "test_meshes.hpp"

namespace carillon {
namespace {

using namespace solvers;
using test::cents;

solvers::modes::Modes axisymmetric(const solvers::mesh::Meridian& body,
                                   const solvers::elements::Elastic& material, double top,
                                   const solvers::axisymmetric::AxisymmetricOptions& options = {},
                                   int max_modes = 100000, bool estimate = true) {
  solvers::eigen::SolveOptions solve;
  solve.band = {0, top, max_modes};
  solve.estimate_errors = estimate;
  core::Trace trace;
  return solvers::axisymmetric::solve_axisymmetric(body, material, solve, options, trace);
}

/// Rows of a table: frequency, multiplicity and harmonic, as far up as the table is complete.
struct Row {
  double frequency;
  int multiplicity, harmonic;
};

std::vector<Row> table_of(const std::string& name) {
  const auto file = test::data_folder() + "/reference_modes/" + name + ".csv";
  const auto frequency = test::csv_column(file, "f_hz");
  const auto multiplicity = test::csv_column(file, "multiplicity");
  const auto harmonic = test::csv_column(file, "n_circumferential");
  std::vector<Row> rows;
  for (std::size_t k = 0; k < frequency.size(); ++k) {
    rows.push_back({std::stod(frequency[k]), std::stoi(multiplicity[k]), std::stoi(harmonic[k])});
  }
  return rows;
}

struct Case {
  std::string name;
  solvers::mesh::Meridian body;
  solvers::elements::Elastic material;
};
std::ostream& operator<<(std::ostream& out, const Case& c) {
  return out << c.name;
}

class Table : public testing::TestWithParam<Case> {};

TEST_P(Table, AgreesWithinAHundredthOfACent) {
  if (test::data_folder().empty()) GTEST_SKIP() << "CARILLON_TEST_DATA is not set";
  const auto& [name, body, material] = GetParam();
  const auto rows = table_of(name);
  ASSERT_GT(rows.size(), 5u);
  const auto modes = axisymmetric(body, material, 1.001 * rows.back().frequency);
  EXPECT_TRUE(modes.certificate.complete);
  EXPECT_TRUE(modes.certificate.count_verified);
  EXPECT_EQ(modes.certificate.rigid_modes, 6);
  std::size_t k = 0;
  for (const auto& row : rows) {
    for (int copy = 0; copy < row.multiplicity; ++copy, ++k) {
      ASSERT_LT(k, modes.size());
      EXPECT_LT(std::abs(cents(modes.frequency(k), row.frequency)), 0.01) << "mode " << k + 1;
      EXPECT_EQ(modes.shapes.waves()[k].harmonic, row.harmonic) << "mode " << k + 1;
    }
  }
  EXPECT_EQ(k, modes.size());
}

const solvers::elements::Elastic alloy{6.99524e+10, 0.345238, 2713};

INSTANTIATE_TEST_SUITE_P(
    RayleighRitz, Table,
    testing::Values(
        Case{"disc_steel_R60_h8mm",
             solvers::mesh::rectangular_meridian({0, 0.048, 0.06}, {0, 0.008}), test::steel},
        Case{"ring_steel_Ro50_Ri40_h10mm",
             solvers::mesh::rectangular_meridian({0.04, 0.05}, {0, 0.01}), test::steel},
        Case{"tube_alu_Ro20_Ri17_L100mm",
             solvers::mesh::rectangular_meridian({0.017, 0.02},
                                                 solvers::mesh::with_edge_layers(0.1, 0.003)),
             test::aluminium},
        Case{"rod_alu_R5_L200mm",
             solvers::mesh::rectangular_meridian({0, 0.005}, {0, 0.01, 0.19, 0.2}),
             test::aluminium},
        Case{"solid_cylinder_steel_R20_L60mm",
             solvers::mesh::rectangular_meridian({0, 0.02}, {0, 0.06}), test::steel},
        Case{"solid_cylinder_alu_D44.2_H64.14mm",
             solvers::mesh::rectangular_meridian({0, 0.0221}, {0, 0.06414}), alloy}),
    [](const auto& given) { return given.param.name.substr(0, given.param.name.find('.')); });

/// A mode of degree l of a sphere has one of every harmonic from 0 to l.
void expect_sphere(const solvers::modes::Modes& modes, const std::vector<test::SphereMode>& truth,
                   double maximum) {
  std::size_t k = 0;
  for (const auto& root : truth) {
    std::multiset<int> harmonics, expected{0};
    for (int n = 1; n <= root.degree; ++n) expected.insert({n, n});
    for (int copy = 0; copy < 2 * root.degree + 1; ++copy, ++k) {
      ASSERT_LT(k, modes.size());
      EXPECT_LT(std::abs(cents(modes.frequency(k), root.frequency)), maximum) << "mode " << k + 1;
      harmonics.insert(modes.shapes.waves()[k].harmonic);
    }
    EXPECT_EQ(harmonics, expected) << root.type << root.degree;
  }
  EXPECT_EQ(k, modes.size());
}

TEST(AxisymmetricSphere, SolidAgreesWithLamb) {
  const auto truth = test::sphere_modes(0.05, 2.0e11, 0.29, 7850, 63000);
  const auto modes = axisymmetric(solvers::mesh::ball_meridian(0.05), test::steel, 63000);
  expect_sphere(modes, truth, 0.001);
  EXPECT_NEAR(modes.mass / (7850 * 4 * std::numbers::pi / 3 * 1.25e-4), 1, 1e-8);
}

/// Arcs between two radii, cut at the equator.
solvers::mesh::Meridian hollow_ball(double inner, double outer) {
  const auto block = [=](std::array<int, 4> corners, double first,
                         double last) -> solvers::mesh::MeridianBlock {
    return {corners, [=](double u, double v) {
              const double r = (1 - v) * inner + v * outer, angle = (1 - u) * first + u * last;
              return Vec2(r * std::cos(angle), r * std::sin(angle));
            }};
  };
  const double quarter = std::numbers::pi / 2;
  return {{block({0, 1, 2, 3}, -quarter, 0), block({1, 4, 5, 2}, 0, quarter)}};
}

TEST(AxisymmetricSphere, HollowAgreesWithItsTable) {
  if (test::data_folder().empty()) GTEST_SKIP() << "CARILLON_TEST_DATA is not set";
  const auto file = test::data_folder() + "/reference_modes/hollow_sphere_alu_R60mm_r50mm.csv";
  const auto frequency = test::csv_column(file, "f_hz"), degree = test::csv_column(file, "l");
  std::vector<test::SphereMode> truth;
  for (std::size_t k = 0; k < frequency.size(); ++k) {
    truth.push_back({'?', std::stoi(degree[k]), std::stod(frequency[k])});
  }
  const auto modes =
      axisymmetric(hollow_ball(0.05, 0.06), test::aluminium, truth.back().frequency + 50);
  expect_sphere(modes, truth, 0.001);
}

/// The error of a smooth mode falls by a factor with every order, as no algebraic rate does.
TEST(AxisymmetricConvergence, IsExponentialInTheOrder) {
  const auto truth = test::sphere_modes(0.05, 2.0e11, 0.29, 7850, 45000);
  double before = 0;
  for (int order = 4; order <= 9; ++order) {
    const auto modes = axisymmetric(solvers::mesh::ball_meridian(0.05), test::steel, 46000,
                                    {order, 0.05, 0}, 1000, false);
    ASSERT_GE(modes.size(), 27u);
    double worst = 0;
    std::size_t k = 0;
    for (const auto& root : truth) {
      for (int copy = 0; copy < 2 * root.degree + 1; ++copy, ++k) {
        worst = std::max(worst, std::abs(cents(modes.frequency(k), root.frequency)));
      }
    }
    if (before > 0) {
      EXPECT_LT(worst, before / 4) << "order " << order;
    }
    before = worst;
  }
  EXPECT_LT(before, 1e-4);
}

/// Estimates of coarse solutions against the truth.
TEST(AxisymmetricErrors, EstimateIsNearTheTrueError) {
  if (test::data_folder().empty()) GTEST_SKIP() << "CARILLON_TEST_DATA is not set";
  const auto rows = table_of("ring_steel_Ro50_Ri40_h10mm");
  const auto modes = axisymmetric(solvers::mesh::rectangular_meridian({0.04, 0.05}, {0, 0.01}),
                                  test::steel, 1.02 * rows.back().frequency, {4, 0.01, 0});
  std::size_t k = 0;
  int judged = 0;
  for (const auto& row : rows) {
    for (int copy = 0; copy < row.multiplicity; ++copy, ++k) {
      const double error = std::abs(cents(modes.frequency(k), row.frequency));
      if (error < 0.01) continue;
      ++judged;
      EXPECT_NEAR(modes.pitch_errors[k] / error, 1, 0.2) << "mode " << k + 1;
    }
  }
  EXPECT_GT(judged, 20);
}

TEST(AxisymmetricBand, LowestModesOfAnUnboundedBand) {
  const auto body = solvers::mesh::rectangular_meridian({0.04, 0.05}, {0, 0.01});
  const auto all = axisymmetric(body, test::steel, 30000);
  const auto some = axisymmetric(body, test::steel, 1e9, {}, 13);
  ASSERT_EQ(some.size(), 13u);
  EXPECT_FALSE(some.certificate.complete);
  EXPECT_FALSE(some.certificate.count_verified);
  EXPECT_GT(some.certificate.complete_to_hz, some.frequency(12));
  EXPECT_LT(some.certificate.complete_to_hz, all.frequency(13));
  for (std::size_t k = 0; k < some.size(); ++k) {
    EXPECT_LT(std::abs(cents(some.frequency(k), all.frequency(k))), 0.001);
  }
}

TEST(AxisymmetricBand, CountsBelowAndInsideAndNothing) {
  const auto body = solvers::mesh::rectangular_meridian({0.04, 0.05}, {0, 0.01});
  solvers::eigen::SolveOptions options;
  core::Trace trace;
  options.band = {5000, 20000, 4};
  const auto modes =
      solvers::axisymmetric::solve_axisymmetric(body, test::steel, options, {}, trace);
  EXPECT_EQ(modes.certificate.modes_in_band, 12);  // the table's modes 5 to 16
  EXPECT_EQ(modes.size(), 4u);
  EXPECT_NEAR(modes.frequency(0), 7817.86, 0.1);
  EXPECT_TRUE(modes.certificate.count_verified);
  EXPECT_FALSE(modes.certificate.complete);

  options.band = {20, 2000, 300};
  const auto none =
      solvers::axisymmetric::solve_axisymmetric(body, test::steel, options, {}, trace);
  EXPECT_EQ(none.size(), 0u);
  EXPECT_TRUE(none.certificate.complete);
  EXPECT_EQ(none.certificate.rigid_modes, 6);
  EXPECT_GT(none.surface.faces.size(), 0u);
}

TEST(AxisymmetricMaterials, ShareASurfaceAndChangeNothing) {
  const auto body = solvers::mesh::rectangular_meridian({0.03, 0.05}, {0, 0.02});
  const solvers::elements::Elastic rubber{5e7, 0.47, 1200}, glass{7e10, 0.21, 2500};
  const std::vector<solvers::axisymmetric::MaterialBand> wanted = {
      {test::steel, {0, 30000, 20}}, {rubber, {0, 3000, 40}}, {glass, {0, 40000, 30}}};
  solvers::eigen::SolveOptions options;
  core::Trace trace;
  const solvers::axisymmetric::AxisymmetricOptions cells{.pitch_target = 5};
  const auto together =
      solvers::axisymmetric::solve_axisymmetric(body, wanted, options, cells, trace);
  ASSERT_EQ(together.size(), wanted.size());
  for (std::size_t s = 0; s < wanted.size(); ++s) {
    const auto& modes = together[s];
    EXPECT_EQ(modes.surface.nodes, together[0].surface.nodes);
    EXPECT_EQ(modes.surface.faces, together[0].surface.faces);
    EXPECT_EQ(modes.shapes.nodes(), static_cast<Eigen::Index>(modes.surface.nodes.size()));
    options.band = wanted[s].band;
    const auto alone =
        solvers::axisymmetric::solve_axisymmetric(body, wanted[s].material, options, cells, trace);
    ASSERT_EQ(modes.size(), alone.size());
    EXPECT_EQ(modes.shapes.waves(), alone.shapes.waves());
    EXPECT_EQ(modes.certificate.modes_in_band, alone.certificate.modes_in_band);
    EXPECT_NEAR(modes.mass, alone.mass, 1e-6 * alone.mass);
    for (std::size_t k = 0; k < modes.size(); ++k)
      EXPECT_LE(std::abs(cents(modes.frequency(k), alone.frequency(k))),
                modes.pitch_errors[k] + alone.pitch_errors[k] + 1e-6);
  }
}

TEST(AxisymmetricTime, IsHeeded) {
  const auto body = solvers::mesh::rectangular_meridian({0.03, 0.05}, {0, 0.02});
  solvers::eigen::SolveOptions options;
  options.time.seconds = 1e-9;
  core::Trace trace;
  EXPECT_THROW(solvers::axisymmetric::solve_axisymmetric(body, test::steel, options, {}, trace),
               core::TimeError);
}

TEST(AxisymmetricInput, IsRefusedWithTheReason) {
  const auto body = solvers::mesh::rectangular_meridian({0.04, 0.05}, {0, 0.01});
  EXPECT_THROW(axisymmetric(body, {2e11, 0.5, 7850}, 1e4), core::InputError);
  EXPECT_THROW(axisymmetric(body, {0, 0.3, 7850}, 1e4), core::InputError);
  EXPECT_THROW(axisymmetric(body, test::steel, -1), core::InputError);
  EXPECT_THROW(axisymmetric({}, test::steel, 1e4), core::InputError);
  EXPECT_THROW(axisymmetric(body, test::steel, 1e4, {1, 0, 0.01}), core::InputError);
}

/// Any ring scaled by any length: frequencies and shapes scale exactly.
TEST(AxisymmetricProperty, ScalesWithLength) {
  EXPECT_TRUE(rc::check("scales", [] {
    const double scale = std::pow(10.0, *rc::gen::inRange(-20, 30) / 10.0);
    const double wall = *rc::gen::inRange(2, 40) / 100.0;
    const auto ring = [wall](double s) {
      return solvers::mesh::rectangular_meridian({s * (1 - wall), s}, {0, 0.3 * s});
    };
    const auto one =
        axisymmetric(ring(1), test::steel, 1200 * (1 + 5 * wall), {4, 1, 0}, 1000, false);
    const auto other = axisymmetric(ring(scale), test::steel, 1200 * (1 + 5 * wall) / scale,
                                    {4, scale, 0}, 1000, false);
    RC_ASSERT(one.size() == other.size());
    for (std::size_t k = 0; k < one.size(); ++k) {
      RC_ASSERT(std::abs(other.frequency(k) * scale / one.frequency(k) - 1) < 1e-9);
      RC_ASSERT(one.shapes.waves()[k] == other.shapes.waves()[k]);
    }
    RC_ASSERT(std::abs(other.mass / std::pow(scale, 3) / one.mass - 1) < 1e-12);
  }));
}

}  // namespace
}  // namespace carillon
