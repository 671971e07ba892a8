// Modes from a basis of other Poisson's ratios, against solves of their own.
#include <fmt/core.h>
#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <Eigen/QR>
#include <algorithm>
#include <cmath>

#include "closed_forms.hpp"
#include "core/temporary_folder.hpp"
#include "reference_bodies.hpp"
#include "solve.hpp"
#include "solvers/basis/solve_materials.hpp"
#include "test_meshes.hpp"

namespace carillon {
namespace {

using namespace solvers;

constexpr double kilohertz = 1000;

solvers::basis::ModeRequest request(double ratio, const solvers::modes::Band& band,
                                    double modulus = 7e10, double density = 2700) {
  return {{{modulus, ratio, density}}, band};
}

solvers::modes::Modes solved_alone(const test::TetMesh& mesh,
                                   const solvers::basis::ModeRequest& wanted) {
  core::Trace trace;
  solvers::eigen::SolveOptions options;
  options.band = wanted.band;
  options.estimate_errors = false;
  return solvers::eigen::solve_modes(mesh, wanted.regions, options, MPI_COMM_SELF, trace);
}

std::vector<solvers::modes::Modes> solved_together(
    const test::TetMesh& mesh, const std::vector<solvers::basis::ModeRequest>& requests,
    core::Trace& trace, const std::filesystem::path& cache = {}) {
  solvers::eigen::SolveOptions options;
  options.estimate_errors = false;
  return solvers::basis::solve_materials(mesh, requests, options, MPI_COMM_SELF, cache, trace);
}

double cents(double a, double b) {
  return 600 * std::abs(std::log2(a / b));
}

/// Part of a shape that the shapes of near frequencies in another set do not span.
double outside_of(const solvers::modes::Modes& set, const solvers::modes::Modes& other,
                  std::size_t mode) {
  std::vector<Eigen::Index> near;
  for (std::size_t k = 0; k < other.size(); ++k) {
    if (cents(set.eigenvalues[mode], other.eigenvalues[k]) < 20) {
      near.push_back(static_cast<Eigen::Index>(k));
    }
  }
  const Eigen::MatrixXd span = other.shapes.select(near).at_nodes().cast<double>().transpose();
  const Eigen::VectorXd shape = set.shapes.of(static_cast<Eigen::Index>(mode));
  const Eigen::VectorXd left = shape - span * span.colPivHouseholderQr().solve(shape);
  return left.norm() / shape.norm();
}

struct Body {
  std::string name;
  test::TetMesh mesh;
  solvers::modes::Band band;
};

std::vector<Body> bodies() {
  return {{"plate", test::box_mesh({0.1, 0.1, 0.01}, {6, 6, 1}, 3), {20, 20 * kilohertz, 300}},
          {"block", test::box_mesh({0.05, 0.06, 0.07}, {3, 3, 4}, 2), {20, 60 * kilohertz, 300}},
          {"ball", test::ball_mesh(0.05, 2, 3), {20, 50 * kilohertz, 300}}};
}

TEST(PoissonBasis, ThreeSnapshotsServeEveryOrdinaryMaterial) {
  for (const auto& body : bodies()) {
    std::vector<solvers::basis::ModeRequest> requests;
    for (const double ratio : {0.05, 0.13, 0.20, 0.27, 0.33, 0.37, 0.41, 0.45}) {
      requests.push_back(request(ratio, body.band));
    }
    core::Trace trace;
    const auto sets = solved_together(body.mesh, requests, trace);
    EXPECT_LE(trace.stages["solve"].calls, 3) << body.name;
    EXPECT_EQ(trace.stages["ritz"].calls, static_cast<std::int64_t>(requests.size()));
    EXPECT_EQ(trace.stages["solved apart"].calls, 0) << body.name;
    for (std::size_t i = 0; i < requests.size(); ++i) {
      SCOPED_TRACE(fmt::format("{} nu {}", body.name, requests[i].regions[0].poisson_ratio));
      const auto& set = sets[i];
      const auto own = solved_alone(body.mesh, requests[i]);
      const auto& certificate = set.certificate;
      EXPECT_EQ(certificate.snapshots, 3);
      EXPECT_LE(certificate.basis_error, 0.1);
      EXPECT_TRUE(certificate.complete);
      EXPECT_TRUE(certificate.count_verified);
      EXPECT_EQ(certificate.complete_to_hz, body.band.max_frequency);
      EXPECT_EQ(certificate.modes_in_band, own.certificate.modes_in_band);
      EXPECT_NEAR(set.mass, own.mass, 1e-12 * own.mass);
      ASSERT_GT(own.size(), 8u);
      ASSERT_EQ(set.size(), own.size());
      for (std::size_t k = 0; k < set.size(); ++k) {
        // The bound holds, and Ritz values err upwards.
        EXPECT_LE(cents(set.eigenvalues[k], own.eigenvalues[k]), certificate.basis_error + 1e-5);
        EXPECT_GT(set.eigenvalues[k], own.eigenvalues[k] * (1 - 1e-8));
      }
      // The last may belong to a pair that the band cuts.
      for (std::size_t k = 0; k + 2 < set.size(); ++k) EXPECT_LT(outside_of(set, own, k), 0.01);
    }
  }
}

TEST(PoissonBasis, NarrowRangesNeedTwoSnapshots) {
  const auto body = bodies()[0];
  std::vector<solvers::basis::ModeRequest> requests;
  for (const double ratio : {0.27, 0.29, 0.31, 0.34}) {
    requests.push_back(request(ratio, body.band));
  }
  core::Trace trace;
  const auto sets = solved_together(body.mesh, requests, trace);
  EXPECT_EQ(trace.stages["solve"].calls, 2);
  EXPECT_EQ(trace.stages["solved apart"].calls, 0);
  for (std::size_t i = 0; i < requests.size(); ++i) {
    const auto own = solved_alone(body.mesh, requests[i]);
    ASSERT_EQ(sets[i].size(), own.size());
    EXPECT_EQ(sets[i].certificate.snapshots, 2);
    for (std::size_t k = 0; k < own.size(); ++k) {
      EXPECT_LT(cents(sets[i].eigenvalues[k], own.eigenvalues[k]), 0.02);
    }
  }
}

TEST(PoissonBasis, AuxeticAndNearlyIncompressibleMaterialsAreSolvedAlone) {
  const auto body = bodies()[1];
  std::vector<solvers::basis::ModeRequest> requests;
  for (const double ratio : {-0.3, 0.49, 0.1, 0.15, 0.2, 0.25, 0.3, 0.35, 0.4}) {
    requests.push_back(request(ratio, body.band));
  }
  core::Trace trace;
  const auto sets = solved_together(body.mesh, requests, trace);
  for (const std::size_t i : {0u, 1u}) {
    EXPECT_EQ(sets[i].certificate.snapshots, 0);
    EXPECT_EQ(sets[i].eigenvalues, solved_alone(body.mesh, requests[i]).eigenvalues);
  }
  for (std::size_t i = 2; i < sets.size(); ++i) EXPECT_EQ(sets[i].certificate.snapshots, 3);
  EXPECT_EQ(trace.stages["solve"].calls, 5);
}

TEST(PoissonBasis, WhatCannotBeCertifiedGetsASolveOfItsOwn) {
  // A body of few modes: those above them, which bear the difference, are in no snapshot.
  const auto mesh = test::box_mesh({0.02, 0.03, 0.1}, {2, 2, 4}, 2);
  const solvers::modes::Band band{20, 30 * kilohertz, 300};
  std::vector<solvers::basis::ModeRequest> requests;
  for (const double ratio : {0.0, 0.2, 0.3, 0.46}) requests.push_back(request(ratio, band));
  core::Trace trace;
  const auto sets = solved_together(mesh, requests, trace);
  EXPECT_EQ(sets[1].certificate.snapshots, 3);
  EXPECT_EQ(sets[3].certificate.snapshots, 0);
  EXPECT_EQ(sets[3].certificate.basis_error, 0);
  EXPECT_GE(trace.stages["solved apart"].calls, 1);
  EXPECT_EQ(trace.stages["solve"].calls, 3 + trace.stages["solved apart"].calls);
  for (std::size_t i = 0; i < requests.size(); ++i) {
    const auto own = solved_alone(mesh, requests[i]);
    EXPECT_TRUE(sets[i].certificate.complete);
    ASSERT_EQ(sets[i].size(), own.size());
    for (std::size_t k = 0; k < own.size(); ++k) {
      EXPECT_LT(cents(sets[i].eigenvalues[k], own.eigenvalues[k]), 0.1);
    }
  }
}

TEST(PoissonBasis, ModulusDensityAndBandRescaleExactly) {
  const auto body = bodies()[0];
  // The last has the first's waves at half the speed, and half its band.
  std::vector<solvers::basis::ModeRequest> requests = {
      request(0.3, body.band), request(0.2, body.band), request(0.25, body.band),
      request(0.4, body.band),
      request(0.3, {10, body.band.max_frequency / 2, 300}, 7e10 / 2, 2 * 2700)};
  core::Trace trace;
  const auto sets = solved_together(body.mesh, requests, trace);
  const auto &a = sets.front(), &b = sets.back();
  ASSERT_EQ(a.size(), b.size());
  EXPECT_EQ(b.certificate.max_frequency, body.band.max_frequency / 2);
  for (std::size_t k = 0; k < a.size(); ++k) {
    EXPECT_NEAR(a.eigenvalues[k] / b.eigenvalues[k], 4, 1e-10);
  }
  EXPECT_NEAR(b.mass / a.mass, 2, 1e-12);
}

TEST(PoissonBasis, TheLowestModesAreKnownWithoutTheRest) {
  auto body = bodies()[1];
  body.band.max_modes = 12;
  std::vector<solvers::basis::ModeRequest> requests;
  for (const double ratio : {0.15, 0.2, 0.3, 0.4}) requests.push_back(request(ratio, body.band));
  core::Trace trace;
  const auto sets = solved_together(body.mesh, requests, trace);
  EXPECT_EQ(trace.stages["solve"].calls, 3);
  for (std::size_t i = 0; i < requests.size(); ++i) {
    const auto own = solved_alone(body.mesh, requests[i]);
    const auto& certificate = sets[i].certificate;
    ASSERT_EQ(sets[i].size(), own.size());
    EXPECT_EQ(certificate.snapshots, 3);
    EXPECT_FALSE(certificate.complete);
    EXPECT_GT(certificate.complete_to_hz, own.frequency(own.size() - 1));
    EXPECT_LT(certificate.complete_to_hz, body.band.max_frequency);
    // How many there are in the whole band no one has counted.
    EXPECT_FALSE(certificate.count_verified);
    EXPECT_GE(certificate.modes_in_band, 12);
    EXPECT_LE(certificate.modes_in_band, own.certificate.modes_in_band);
  }
}

TEST(PoissonBasis, NoModeInTheBandIsAResult) {
  const auto body = bodies()[1];
  std::vector<solvers::basis::ModeRequest> requests;
  for (const double ratio : {0.15, 0.2, 0.3, 0.4}) {
    requests.push_back(request(ratio, {20, kilohertz, 300}));
  }
  core::Trace trace;
  for (const auto& set : solved_together(body.mesh, requests, trace)) {
    EXPECT_EQ(set.size(), 0u);
    EXPECT_TRUE(set.certificate.complete);
    EXPECT_EQ(set.certificate.complete_to_hz, kilohertz);
  }
}

TEST(PoissonBasis, OtherMaterialsOfABuildHardlyMatter) {
  const auto body = bodies()[0];
  std::vector<solvers::basis::ModeRequest> few, more;
  for (const double ratio : {0.2, 0.25, 0.35, 0.4}) few.push_back(request(ratio, body.band));
  more = few;
  more.push_back(request(0.43, body.band, 3e10));
  more.push_back(request(0.18, body.band, 6e10));
  core::Trace trace;
  const auto first = solved_together(body.mesh, few, trace);
  const auto second = solved_together(body.mesh, more, trace);
  for (std::size_t i = 0; i < few.size(); ++i) {
    ASSERT_EQ(first[i].size(), second[i].size());
    for (std::size_t k = 0; k < first[i].size(); ++k) {
      EXPECT_LT(cents(first[i].eigenvalues[k], second[i].eigenvalues[k]), 0.01);
    }
  }
}

/// Estimated where modes were solved for, carried over to other materials: against Rayleigh and
/// Ritz's polynomials for each.
TEST(PoissonBasis, PitchErrorsComeFromTheSnapshots) {
  const Vec3 sides(0.02, 0.03, 0.05);
  const auto mesh = test::box_mesh(sides, {2, 3, 5}, 2);
  std::vector<solvers::basis::ModeRequest> requests;
  for (const double ratio : {0.15, 0.2, 0.29, 0.35, 0.41}) {
    requests.push_back(request(ratio, {20, 1e6, 30}));
  }
  core::Trace trace;
  const auto sets = solvers::basis::solve_materials(mesh, requests, {}, MPI_COMM_SELF, {}, trace);
  EXPECT_EQ(trace.stages["estimate"].calls, 3);
  for (std::size_t i = 0; i < requests.size(); ++i) {
    const auto& material = requests[i].regions[0];
    EXPECT_EQ(sets[i].certificate.snapshots, 3);
    const auto truth =
        test::box_frequencies({0.02, 0.03, 0.05}, {9, 10, 12}, material.youngs_modulus,
                              material.poisson_ratio, material.density, 20);
    const auto found = test::measure_effectivity(sets[i], truth);
    EXPECT_GT(found.compared, 15u) << material.poisson_ratio;
    EXPECT_EQ(found.complaint, "") << material.poisson_ratio;
  }
}

TEST(PoissonBasis, RegionsOfOneContrastShareABasis) {
  const auto mesh = test::box_mesh({0.02, 0.03, 0.1}, {2, 2, 6}, 2,
                                   [](const Vec3& x) { return x[2] < 0.05 ? 0 : 1; });
  std::vector<solvers::basis::ModeRequest> requests;
  for (const double ratio : {0.15, 0.22, 0.3, 0.4}) {
    requests.push_back({{{2e11, ratio, 7850}, {5e10, ratio, 2000}}, {20, 40 * kilohertz, 300}});
  }
  // Another contrast is another problem.
  requests.push_back({{{2e11, 0.3, 7850}, {6e10, 0.3, 2000}}, {20, 40 * kilohertz, 300}});
  core::Trace trace;
  const auto sets = solved_together(mesh, requests, trace);
  EXPECT_EQ(trace.stages["solve"].calls, 4);
  for (std::size_t i = 0; i < requests.size(); ++i) {
    const auto own = solved_alone(mesh, requests[i]);
    EXPECT_EQ(sets[i].certificate.snapshots, i < 4 ? 3 : 0);
    ASSERT_EQ(sets[i].size(), own.size());
    for (std::size_t k = 0; k < own.size(); ++k) {
      EXPECT_LT(cents(sets[i].eigenvalues[k], own.eigenvalues[k]), 0.1);
    }
    EXPECT_LT((sets[i].strain_fraction - own.strain_fraction).cwiseAbs().maxCoeff(), 1e-2);
  }
}

TEST(PoissonBasis, NothingIsSolvedTwice) {
  const core::TemporaryFolder folder;
  const auto body = bodies()[1];
  std::vector<solvers::basis::ModeRequest> requests;
  for (const double ratio : {0.15, 0.2, 0.3, 0.4}) requests.push_back(request(ratio, body.band));
  core::Trace first, second;
  const auto made = solved_together(body.mesh, requests, first, folder.path());
  const auto found = solved_together(body.mesh, requests, second, folder.path());
  EXPECT_EQ(second.stages["solve"].calls, 0);
  EXPECT_EQ(second.stages["modes from cache"].calls, 4);
  for (std::size_t i = 0; i < made.size(); ++i) {
    EXPECT_EQ(made[i].eigenvalues, found[i].eigenvalues);
    EXPECT_EQ(made[i].certificate.snapshots, found[i].certificate.snapshots);
    EXPECT_EQ(made[i].certificate.basis_error, found[i].certificate.basis_error);
  }
}

/// Some forty modes below 20 kHz are expected of it in a stiff material.
test::TetMesh plate() {
  auto mesh = test::box_mesh({0.2, 0.2, 0.008}, {4, 4, 1}, 1);
  mesh.faces = solvers::mesh::boundary_faces(mesh);
  return mesh;
}

std::size_t solves_of(const std::vector<solvers::basis::SolveGroup>& groups) {
  std::size_t solves = 0;
  for (const auto& group : groups) solves += group.solves();
  return solves;
}

/// To a factor of 2.5, beside five that matter little.
TEST(PlanSolves, AboutAsManyModesAreExpectedAsThereAre) {
  for (const auto& body : bodies()) {
    auto mesh = body.mesh;
    if (mesh.faces.empty()) mesh.faces = solvers::mesh::boundary_faces(mesh);
    const auto wanted = request(0.25, body.band);
    const auto found = solved_alone(mesh, wanted).certificate.modes_in_band;
    const double expected = solvers::basis::expected_modes(
        solvers::mesh::measure_quality(mesh).volume, solvers::mesh::mean_thickness(mesh),
        wanted.regions[0], body.band.max_frequency);
    EXPECT_LT(std::abs(std::log2((expected + 5) / static_cast<double>(found + 5))), 1.3)
        << body.name << ": " << found << ", expected " << expected;
  }
}

TEST(PlanSolves, AFewRatiosAreSolvedOneByOne) {
  const solvers::modes::Band band{20, 20000, 300};
  for (std::size_t count = 1; count <= 3; ++count) {
    std::vector<solvers::basis::ModeRequest> requests;
    for (std::size_t i = 0; i < count; ++i) {
      requests.push_back(request(0.15 + 0.1 * static_cast<double>(i), band));
    }
    EXPECT_EQ(solves_of(solvers::basis::plan_solves(plate(), requests)), count);
  }
}

TEST(PlanSolves, SoftMaterialsAreKeptApartWhereThatPays) {
  std::vector<solvers::basis::ModeRequest> requests;
  const auto plan = [&](int max_modes) {
    auto limited = requests;
    for (auto& one : limited) one.band.max_modes = max_modes;
    return solvers::basis::plan_solves(plate(), limited);
  };
  for (const double ratio : {0.17, 0.2, 0.25, 0.29, 0.33, 0.37}) {
    requests.push_back(request(ratio, {20, 20000, 0}));
  }
  auto groups = plan(1000);
  ASSERT_EQ(groups.size(), 1u);
  EXPECT_EQ(groups[0].snapshots, (std::vector<double>{0.10, 0.30, 0.44}));
  EXPECT_EQ(groups[0].solves(), 3u);
  // A hundred times slower: foam, with a hundred times the modes.
  requests.push_back(request(0.35, {20, 20000, 0}, 7e6));
  groups = plan(1000);
  EXPECT_EQ(solves_of(groups), 4u);
  const auto foam =
      std::find_if(groups.begin(), groups.end(), [](const solvers::basis::SolveGroup& group) {
        return std::count(group.requests.begin(), group.requests.end(), 6u) == 1;
      });
  ASSERT_NE(foam, groups.end());
  EXPECT_EQ(foam->requests.size(), 1u);
  // Where all are held to as many modes, it is a material like the others.
  groups = plan(30);
  ASSERT_EQ(groups.size(), 1u);
  EXPECT_EQ(groups[0].solves(), 3u);
}

TEST(PlanSolves, EveryRequestIsServedOnce) {
  EXPECT_TRUE(rc::check([] {
    const auto count = *rc::gen::inRange<std::size_t>(0, 12);
    std::vector<solvers::basis::ModeRequest> requests;
    for (std::size_t i = 0; i < count; ++i) {
      requests.push_back(request(*rc::gen::inRange(-90, 50) / 100.0, {20, 20000, 300},
                                 std::pow(10.0, *rc::gen::inRange(60, 115) / 10.0)));
    }
    std::vector<int> served(count, 0);
    for (const auto& group : solvers::basis::plan_solves(plate(), requests)) {
      for (const auto i : group.requests) ++served[i];
      RC_ASSERT(group.solves() <= group.requests.size());
      RC_ASSERT(std::is_sorted(group.snapshots.begin(), group.snapshots.end()));
    }
    RC_ASSERT(std::all_of(served.begin(), served.end(), [](int n) { return n == 1; }));
  }));
}

}  // namespace
}  // namespace carillon
