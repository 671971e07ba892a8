// Estimated pitch errors against true ones, and what they must not depend on.
#include <fmt/core.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <string>

#include "closed_forms.hpp"
#include "reference_bodies.hpp"
#include "solve.hpp"
#include "solvers/eigen/pitch_error.hpp"
#include "solvers/mesh/raise_order.hpp"
#include "test_meshes.hpp"

namespace carillon {
namespace {

using namespace solvers;
using test::box_mesh;
using test::lowest_modes;

/// Truth for the lowest modes; half as many again are solved for, as some may lie too high.
void expect_effective(const std::string& name, const test::TetMesh& mesh,
                      const solvers::elements::Elastic& material,
                      const std::vector<double>& truth) {
  const auto modes = lowest_modes(mesh, {material}, static_cast<int>(3 * truth.size() / 2));
  const auto found = test::measure_effectivity(modes, truth);
  fmt::print("{:14} order {}: worst {:8.3f} cents, effectivity {:.2f} {:.2f} {:.2f} of {} modes\n",
             name, mesh.order, found.worst_error, found.minimum, found.median, found.maximum,
             found.compared);
  EXPECT_GT(found.compared, truth.size() / 3);
  EXPECT_EQ(found.complaint, "") << name;
}

TEST(PitchError, OfABlockByRayleighRitz) {
  const auto truth = test::box_frequencies({0.02, 0.03, 0.05}, {9, 10, 12}, 2.0e11, 0.29, 7850, 20);
  const std::array<int, 3> cells[] = {{4, 6, 10}, {2, 3, 5}, {1, 2, 3}, {1, 1, 2}};
  for (int order = 1; order <= 4; ++order) {
    expect_effective("block", box_mesh({0.02, 0.03, 0.05}, cells[order - 1], order), test::steel,
                     truth);
  }
}

TEST(PitchError, OfAThinPlateByRayleighRitz) {
  const auto truth = test::box_frequencies({0.1, 0.1, 0.005}, {17, 17, 4}, 6.2e10, 0.2, 2600, 20);
  for (const int order : {1, 2, 3}) {
    const int n = order == 1 ? 12 : 6;
    expect_effective("plate", box_mesh({0.1, 0.1, 0.005}, {n, n, 1}, order), test::glass, truth);
  }
}

/// Curved: part of the error is the surface's, and makes pitches too low as well.
TEST(PitchError, OfASphereByLamb) {
  std::vector<double> truth;
  for (const auto& root : test::sphere_modes(0.05, 2.0e11, 0.29, 7850, 50000)) {
    for (int m = 0; m < 2 * root.degree + 1; ++m) truth.push_back(root.frequency);
  }
  for (const int order : {1, 2, 3}) {
    const int cells = order == 1 ? 4 : 2;
    expect_effective("sphere",
                     test::with_finer_nodes(test::ball_mesh(0.05, cells, order),
                                            test::ball_mesh(0.05, cells, order + 1)),
                     test::steel, truth);
  }
}

TEST(PitchError, OfReferenceBodies) {
  if (test::data_folder().empty()) GTEST_SKIP() << "CARILLON_TEST_DATA is not set";
  const std::pair<const char*, int> cases[] = {{"disc", 2}, {"disc", 3}, {"hollow sphere", 2},
                                               {"ring", 3}, {"tube", 3}, {"rod", 2},
                                               {"bar", 4}};
  for (const auto& [name, order] : cases) {
    const auto& body = test::reference_body(name);
    auto truth = test::table_frequencies(body.table);
    truth.resize(std::min<std::size_t>(truth.size(), 24));
    expect_effective(name, body.mesh(order, 0), body.material, truth);
  }
}

void expect_same(const std::vector<double>& a, const std::vector<double>& b, double tolerance) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t k = 0; k < a.size(); ++k) {
    EXPECT_NEAR(a[k], b[k], tolerance * b[k] + 0.002) << "mode " << k + 1;
  }
}

TEST(PitchError, DoesNotDependOnUnitsOrPlace) {
  const auto mesh = box_mesh({0.02, 0.031, 0.053}, {1, 2, 3}, 2);
  const auto errors = lowest_modes(mesh, {test::steel}, 12).pitch_errors;
  const auto turn = Eigen::AngleAxisd(0.7, Vec3(1, 2, 3).normalized()).toRotationMatrix();
  for (const double scale : {1e-5, 1e3}) {
    const auto other = test::moved(
        mesh, [&](const Vec3& x) -> Vec3 { return scale * (turn * x + Vec3(1, 0, 2)); });
    solvers::elements::Elastic soft = test::steel;
    soft.youngs_modulus *= 1e-4;
    expect_same(lowest_modes(other, {soft}, 12).pitch_errors, errors, 0.01);
  }
}

/// The eigenvalue solver may return any basis of a repeated mode.
TEST(PitchError, DoesNotDependOnTheBasisOfRepeatedModes) {
  const auto mesh = box_mesh(Vec3::Constant(0.05), {2, 2, 2}, 2);
  const std::vector<solvers::elements::Elastic> regions = {test::steel};
  solvers::eigen::SolveOptions options;
  options.band = {0, 1e9, 11};
  core::Trace trace;
  const auto system = solvers::assembly::assemble(
      mesh, regions, solvers::assembly::partition(mesh, 1), MPI_COMM_SELF);
  auto found = solvers::eigen::search_modes(mesh, regions, options, system, MPI_COMM_SELF, trace);
  const std::vector<std::size_t> chosen(found.flexible.begin(), found.flexible.begin() + 11);
  std::vector<double> values;
  for (const auto k : chosen) values.push_back(found.pairs.values[k] * system.scales.eigenvalue());
  const auto errors = [&] {
    return solvers::eigen::pitch_errors(
        values, solvers::eigen::estimate_true_modes(mesh, regions, system, found, chosen, values,
                                                    1 << 30, MPI_COMM_SELF)
                    .modes);
  };
  const auto before = errors();
  int turned = 0;
  for (std::size_t k = 0; k + 1 < chosen.size(); ++k) {
    if (values[k + 1] - values[k] > 1e-9 * values[k]) continue;
    const auto a = static_cast<Eigen::Index>(chosen[k]);
    const auto b = static_cast<Eigen::Index>(chosen[k + 1]);
    const Eigen::VectorXd x = found.pairs.vectors.col(a), y = found.pairs.vectors.col(b);
    found.pairs.vectors.col(a) = 0.6 * x + 0.8 * y;
    found.pairs.vectors.col(b) = 0.8 * x - 0.6 * y;
    ++turned;
  }
  ASSERT_GE(turned, 3);
  expect_same(errors(), before, 0.02);
}

/// Memory bounds how many modes go together, and whether matrices are kept.
TEST(PitchError, IsTheSameInLittleMemory) {
  const auto mesh = box_mesh({0.02, 0.031, 0.053}, {1, 2, 3}, 3);
  const std::vector<solvers::elements::Elastic> regions = {test::steel};
  core::Trace trace;
  solvers::eigen::SolveOptions options;
  options.band = {0, 1e9, 20};
  const auto roomy = solvers::eigen::solve_modes(mesh, regions, options, MPI_COMM_SELF, trace);
  const auto system = solvers::assembly::assemble(
      mesh, regions, solvers::assembly::partition(mesh, 1), MPI_COMM_SELF);
  const auto found =
      solvers::eigen::search_modes(mesh, regions, options, system, MPI_COMM_SELF, trace);
  const std::vector<std::size_t> chosen(found.flexible.begin(), found.flexible.begin() + 20);
  const auto truth = solvers::eigen::estimate_true_modes(mesh, regions, system, found, chosen,
                                                         roomy.eigenvalues, 1000, MPI_COMM_SELF);
  expect_same(solvers::eigen::pitch_errors(roomy.eigenvalues, truth.modes), roomy.pitch_errors,
              0.1);
}

/// A mode that comes down by 300 cents passes one 280 cents below it where it is likely to.
TEST(PitchError, ModesChangePlacesWhereThatIsLikely) {
  const auto lower = [](double eigenvalue, double cents) {
    return eigenvalue * std::exp2(-cents / 600);
  };
  const double low = 1e8, high = low * std::exp2(280 / 600.0);
  const std::vector found{low, high};
  const solvers::eigen::TrueMode stays{low, lower(low, 3), 0, lower(low, 3)};
  auto errors =
      solvers::eigen::pitch_errors(found, {{high, lower(high, 300), 0, lower(high, 270)}, stays});
  EXPECT_NEAR(errors[0], 3, 1e-6);
  EXPECT_NEAR(errors[1], 300, 1e-6);
  for (const double likely : {lower(high, 290), 0.0}) {
    errors = solvers::eigen::pitch_errors(found, {stays, {high, lower(high, 300), 0, likely}});
    EXPECT_NEAR(errors[0], 20, 1e-6);
    EXPECT_NEAR(errors[1], 283, 1e-6);
  }
}

/// Two bodies alike have every mode twice, and their own rigid motions.
TEST(PitchError, OfSeparateBodiesIsThatOfEach) {
  const auto block = box_mesh({0.02, 0.031, 0.053}, {1, 2, 3}, 2);
  const auto copy =
      test::moved(block, [](const Vec3& x) -> Vec3 { return x + Vec3(0.1, 0.02, 0); });
  const auto alone = lowest_modes(block, {test::steel}, 10);
  const auto both = lowest_modes(test::joined(block, copy), {test::steel, test::steel}, 20);
  ASSERT_EQ(both.size(), 2 * alone.size());
  for (std::size_t k = 0; k < both.size(); ++k) {
    EXPECT_NEAR(both.pitch_errors[k] / alone.pitch_errors[k / 2], 1, 0.03) << "mode " << k + 1;
  }
}

/// Straight elements that are their own truth.
TEST(PitchError, TakesTheMeshsOwnCurveWithoutFinerNodes) {
  auto mesh = test::ball_mesh(0.05, 2, 2);
  const auto own = lowest_modes(mesh, {test::steel}, 11).pitch_errors;
  mesh.finer_nodes = solvers::mesh::raise_order(mesh, 3).nodes;
  expect_same(lowest_modes(mesh, {test::steel}, 11).pitch_errors, own, 1e-6);
  // The true surface bulges over the elements' by an error of its own.
  const auto curved = test::with_finer_nodes(mesh, test::ball_mesh(0.05, 2, 3));
  const auto true_errors = lowest_modes(curved, {test::steel}, 11).pitch_errors;
  double maximum = 0;
  for (std::size_t k = 0; k < own.size(); ++k) {
    maximum = std::max(maximum, std::abs(own[k] - true_errors[k]));
  }
  EXPECT_GT(maximum, 0.5);
}

/// Nodes of the next order that are kept from the true surface count with what they lack.
TEST(PitchError, GapsCountAsIfTheyWereClosed) {
  for (const int order : {1, 2}) {
    const auto mesh = test::ball_mesh(0.05, 2, order);
    const auto curved = test::with_finer_nodes(mesh, test::ball_mesh(0.05, 2, order + 1));
    auto held_back = mesh;
    held_back.finer_nodes = solvers::mesh::raise_order(mesh, order + 1).nodes;
    for (std::size_t n = 0; n < curved.finer_nodes.size(); ++n) {
      held_back.finer_gaps.push_back(curved.finer_nodes[n] - held_back.finer_nodes[n]);
    }
    const auto truth = lowest_modes(curved, {test::steel}, 11).pitch_errors;
    const auto errors = lowest_modes(held_back, {test::steel}, 11).pitch_errors;
    const auto ignored = lowest_modes(mesh, {test::steel}, 11).pitch_errors;
    double apart = 0, apart_without = 0;
    for (std::size_t k = 0; k < truth.size(); ++k) {
      apart = std::max(apart, std::abs(errors[k] - truth[k]));
      apart_without = std::max(apart_without, std::abs(ignored[k] - truth[k]));
    }
    EXPECT_LT(apart, 0.2 * apart_without) << "order " << order;
  }
}

/// Nodes of the next order that would turn an element inside out are left where they were, and what
/// they lack counts as a gap.
TEST(PitchError, NodesThatFoldBecomeGaps) {
  const Vec3 offset(0.01, 0.02, -0.01);
  auto folding = box_mesh({0.02, 0.031, 0.053}, {1, 2, 3}, 2);
  folding.finer_nodes = solvers::mesh::raise_order(folding, 3).nodes;
  auto told = folding;
  folding.finer_nodes.back() += offset;
  told.finer_gaps.assign(told.finer_nodes.size(), Vec3::Zero());
  told.finer_gaps.back() = offset;
  const auto errors = lowest_modes(folding, {test::steel}, 12).pitch_errors;
  EXPECT_TRUE(std::all_of(errors.begin(), errors.end(), [](double e) { return std::isfinite(e); }));
  expect_same(errors, lowest_modes(told, {test::steel}, 12).pitch_errors, 1e-6);
}

TEST(PitchError, GoesWithItsModesAndOnlyWhenAsked) {
  const auto mesh = box_mesh({0.02, 0.031, 0.053}, {1, 2, 3}, 2);
  const auto modes = lowest_modes(mesh, {test::steel}, 12);
  EXPECT_EQ(modes.pitch_errors.size(), modes.size());
  EXPECT_EQ(solvers::modes::rescale(modes, 2, 3, 4).pitch_errors, modes.pitch_errors);
  const solvers::modes::Band upper{modes.frequency(3) * 0.999, modes.frequency(8) * 1.001, 100};
  const auto some = solvers::modes::restrict_to(modes, upper);
  EXPECT_EQ(some.pitch_errors,
            std::vector(modes.pitch_errors.begin() + 3, modes.pitch_errors.begin() + 9));
  solvers::eigen::SolveOptions options;
  options.band = {0, 1e9, 12};
  options.estimate_errors = false;
  core::Trace trace;
  const auto plain =
      solvers::eigen::solve_modes(mesh, std::vector{test::steel}, options, MPI_COMM_SELF, trace);
  EXPECT_TRUE(plain.pitch_errors.empty());
  EXPECT_EQ(trace.stages.count("estimate"), 0u);
  EXPECT_EQ(plain.eigenvalues, modes.eigenvalues);
}

}  // namespace
}  // namespace carillon
