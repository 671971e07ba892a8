// Solvers that lose modes: what is missing is noticed, sought again, found or stated.
#include "solvers/eigen/search.hpp"

#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <algorithm>
#include <cmath>

#include "core/error.hpp"
#include "solve.hpp"
#include "test_meshes.hpp"

namespace carillon {
namespace {

using namespace solvers;
using test::box_mesh;

test::TetMesh block() {
  return box_mesh({0.02, 0.031, 0.053}, {2, 3, 4}, 2);
}

/// Square section, nearly: bending modes come in pairs that lie within a few thousandths.
test::TetMesh bar() {
  return box_mesh({0.02, 0.02, 0.1}, {2, 2, 6}, 2);
}

/// Eigenpairs without those at some places (indices among all pairs, six rigid ones first).
solvers::eigen::EigenPairs without(const solvers::eigen::EigenPairs& all,
                                   const std::vector<std::size_t>& places) {
  solvers::eigen::EigenPairs out;
  std::vector<Eigen::Index> kept;
  for (std::size_t k = 0; k < all.values.size(); ++k) {
    if (std::find(places.begin(), places.end(), k) != places.end()) continue;
    kept.push_back(static_cast<Eigen::Index>(k));
    out.values.push_back(all.values[k]);
    out.residuals.push_back(all.residuals[k]);
    out.energy_residuals.push_back(all.energy_residuals[k]);
  }
  out.vectors = all.vectors(Eigen::all, kept);
  out.mass_vectors = all.mass_vectors(Eigen::all, kept);
  out.orthonormality = all.orthonormality;
  return out;
}

/// Loses modes in its first `times` solves, and counts what was asked of it.
struct Lossy {
  std::vector<std::size_t> places;
  int times = 1;
  int solves = 0, slices = 0;
  bool slice_too = false;  ///< loses the lowest of every slice as well
  std::vector<solvers::eigen::EigenRequest> requests = {};

  solvers::eigen::SearchMethods methods() {
    solvers::eigen::SearchMethods out;
    out.lowest = [this](const solvers::assembly::System& system,
                        const solvers::eigen::EigenRequest& request,
                        const solvers::eigen::ShiftedSystem& shifted, MPI_Comm comm) {
      requests.push_back(request);
      const auto all = solvers::eigen::lowest_pairs(system, request, shifted, comm);
      return ++solves <= times ? without(all, places) : all;
    };
    out.slice = [this](const solvers::assembly::System& system, double low, double high,
                       double tolerance, MPI_Comm comm) {
      ++slices;
      auto all = solvers::eigen::slice_spectrum(system, low, high, tolerance, comm);
      if (!slice_too || all.values.empty()) return all;
      all.values.erase(all.values.begin());
      all.vectors = all.vectors.rightCols(all.vectors.cols() - 1).eval();
      return all;
    };
    return out;
  }
};

constexpr int always = 1000;

solvers::modes::Modes solve(const test::TetMesh& mesh, const solvers::modes::Band& band,
                            const solvers::eigen::SearchMethods& methods = {}) {
  core::Trace trace;
  solvers::eigen::SolveOptions options;
  options.band = band;
  const std::vector<solvers::elements::Elastic> regions(mesh.region_names.size(), test::steel);
  return solvers::eigen::solve_modes(mesh, regions, options, MPI_COMM_SELF, trace, methods);
}

void expect_equal(const solvers::modes::Modes& found, const solvers::modes::Modes& truth,
                  double tolerance = 1e-9) {
  ASSERT_EQ(found.size(), truth.size());
  for (std::size_t k = 0; k < truth.size(); ++k) {
    EXPECT_NEAR(found.frequency(k) / truth.frequency(k), 1, tolerance) << k;
  }
  EXPECT_EQ(found.certificate.modes_in_band, truth.certificate.modes_in_band);
  EXPECT_EQ(found.certificate.complete, truth.certificate.complete);
  EXPECT_NEAR(found.certificate.complete_to_hz / truth.certificate.complete_to_hz, 1, 1e-6);
  EXPECT_LT(found.certificate.max_residual, 1e-8);
  EXPECT_LT(found.certificate.orthonormality, 1e-9);
  EXPECT_TRUE(found.certificate.count_verified);
}

const solvers::modes::Band whole_band{20, 80000, 300}, lowest_twelve{20, 120000, 12};

TEST(Search, AModeLostOnceIsFoundBySecondAttempt) {
  for (const auto& band : {whole_band, lowest_twelve}) {
    const auto truth = solve(block(), band);
    for (const std::size_t place : {6u, 9u, 14u}) {
      Lossy lossy{.places = {place}};
      expect_equal(solve(block(), band, lossy.methods()), truth);
      ASSERT_EQ(lossy.solves, 2) << place;
      EXPECT_EQ(lossy.slices, 0);
      EXPECT_NE(lossy.requests[0].seed, lossy.requests[1].seed);
      EXPECT_GT(lossy.requests[1].pairs, lossy.requests[0].pairs);
    }
  }
}

TEST(Search, AModeLostAlwaysIsFoundBySlicing) {
  for (const auto& band : {whole_band, lowest_twelve}) {
    const auto truth = solve(block(), band);
    for (const std::vector<std::size_t>& places :
         {std::vector<std::size_t>{6}, {9}, {14}, {7, 8}, {6, 13}, {6, 7, 8, 9}}) {
      Lossy lossy{.places = places, .times = always};
      expect_equal(solve(block(), band, lossy.methods()), truth);
      EXPECT_EQ(lossy.solves, 2);
      EXPECT_GE(lossy.slices, 1);
    }
  }
}

/// Whichever modes are lost, the search ends with the set that it should have, or says that it has
/// not.
TEST(Search, AnySetOfLostModesIsFound) {
  const auto truth = solve(block(), lowest_twelve);
  EXPECT_TRUE(rc::check([&truth] {
    const auto lost =
        *rc::gen::unique<std::vector<std::size_t>>(rc::gen::inRange<std::size_t>(6, 18));
    RC_PRE(!lost.empty() && lost.size() < 8);
    Lossy lossy{.places = lost, .times = always};
    const auto modes = solve(block(), lowest_twelve, lossy.methods());
    RC_ASSERT(modes.size() == truth.size());
    for (std::size_t k = 0; k < truth.size(); ++k) {
      RC_ASSERT(std::abs(modes.frequency(k) / truth.frequency(k) - 1) < 1e-9);
    }
  }));
}

/// What can be neither solved for nor sliced is stated, not thrown.
TEST(Search, AModeThatStaysMissingIsReported) {
  const auto truth = solve(block(), whole_band);
  ASSERT_TRUE(truth.certificate.complete);
  ASSERT_GT(truth.size(), 8u);
  Lossy lossy{.places = {10}, .times = always, .slice_too = true};
  const auto modes = solve(block(), whole_band, lossy.methods());
  EXPECT_GE(lossy.slices, 1);
  const auto& c = modes.certificate;
  EXPECT_FALSE(c.complete);
  EXPECT_TRUE(c.count_verified);
  EXPECT_EQ(c.modes_in_band, truth.certificate.modes_in_band);
  EXPECT_LT(c.modes_found, c.modes_in_band);
  EXPECT_EQ(static_cast<std::size_t>(c.modes_found), modes.size());
  // Complete up to what is missing, and not much less.
  EXPECT_LT(c.complete_to_hz, truth.frequency(4));
  // Of what is there, nothing is wrong.
  for (std::size_t k = 0; k < modes.size(); ++k) {
    const auto near = std::min_element(
        truth.eigenvalues.begin(), truth.eigenvalues.end(), [&](double a, double b) {
          return std::abs(a - modes.eigenvalues[k]) < std::abs(b - modes.eigenvalues[k]);
        });
    EXPECT_NEAR(modes.eigenvalues[k] / *near, 1, 1e-8);
  }
}

TEST(Search, HalfOfAPairIsMissedAndFound) {
  const solvers::modes::Band band{20, 40000, 300};
  const auto truth = solve(bar(), band);
  std::size_t pair = 0;
  while (pair + 1 < truth.size() && truth.frequency(pair + 1) / truth.frequency(pair) > 1.01) {
    ++pair;
  }
  ASSERT_LT(pair + 1, truth.size()) << "no pair in the band";
  for (const std::size_t half : {pair, pair + 1}) {
    Lossy lossy{.places = {6 + half}, .times = always};
    expect_equal(solve(bar(), band, lossy.methods()), truth);
    EXPECT_GE(lossy.slices, 1);
  }
}

/// Exact copies: the same value three times, one of them lost.
TEST(Search, OneOfThreeEqualBodiesIsMissedAndFound) {
  auto bodies = block();
  for (int n = 1; n < 3; ++n) {
    bodies = test::joined(bodies, test::moved(block(), [n](const Vec3& x) -> Vec3 {
                            return x + Vec3(0.03 * n, 0, 0);
                          }));
  }
  const solvers::modes::Band band{20, 60000, 300};
  const auto truth = solve(bodies, band);
  ASSERT_EQ(truth.certificate.rigid_modes, 18);
  ASSERT_GT(truth.size(), 3u);
  Lossy lossy{.places = {19}, .times = always};
  expect_equal(solve(bodies, band, lossy.methods()), truth);
  EXPECT_GE(lossy.slices, 1);
}

/// A rigid motion that is lost is no matter of completeness: it means that the solver is wrong.
TEST(Search, ALostRigidMotionIsAnError) {
  Lossy lossy{.places = {3}, .times = always};
  EXPECT_THROW(solve(block(), whole_band, lossy.methods()), core::SolverError);
}

TEST(Slicing, GivesWhatLowestPairsGives) {
  const auto mesh = block();
  const std::vector materials{test::steel};
  const auto system = solvers::assembly::assemble(
      mesh, materials, solvers::assembly::partition(mesh, 1), MPI_COMM_SELF);
  const double shift = -system.scales.from_frequency(2000);
  const auto shifted = solvers::eigen::factor_shifted(
      system, shift, solvers::eigen::plan_factors(system, MPI_COMM_SELF), MPI_COMM_SELF);
  const auto all = solvers::eigen::lowest_pairs(system, {40, 1e-12, 1}, shifted, MPI_COMM_SELF);
  for (const auto& [first, last] : {std::pair{6, 9}, {8, 30}, {20, 21}}) {
    const auto at = [&all](int k) { return all.values[static_cast<std::size_t>(k)]; };
    const double low = first == 6 ? 0.3 * at(6) : (at(first - 1) + at(first)) / 2;
    const double high = (at(last - 1) + at(last)) / 2;
    auto slice = solvers::eigen::slice_spectrum(system, low, high, 1e-12, MPI_COMM_SELF);
    ASSERT_EQ(slice.size(), last - first);
    solvers::eigen::measure(system, shifted, MPI_COMM_SELF, slice);
    std::sort(slice.values.begin(), slice.values.end());
    EXPECT_LT(slice.orthonormality, 1e-9);
    for (int k = first; k < last; ++k) {
      const auto i = static_cast<std::size_t>(k - first);
      EXPECT_NEAR(slice.values[i] / at(k), 1, 1e-9);
      EXPECT_LT(slice.residuals[i], 1e-8);
    }
  }
}

}  // namespace
}  // namespace carillon
