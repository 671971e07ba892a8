// Run at 1, 2 and 3 ranks: a group's basis gives every rank what a rank alone would find.
#include <gtest/gtest.h>
#include <mpi.h>

#include <cmath>

#include "solve.hpp"
#include "solvers/basis/solve_materials.hpp"
#include "test_meshes.hpp"

namespace carillon {
namespace {

using namespace solvers;

TEST(PoissonBasisOnRanks, IsTheSameAsOnOne) {
  const auto mesh = test::box_mesh({0.1, 0.08, 0.01}, {6, 5, 1}, 3);
  std::vector<solvers::basis::ModeRequest> requests;
  for (const double ratio : {0.15, 0.22, 0.35, 0.41}) {
    requests.push_back({{{7e10, ratio, 2700}}, {20, 20000, 300}});
  }
  solvers::eigen::SolveOptions options;
  options.estimate_errors = false;
  core::Trace trace, own_trace;
  const auto sets =
      solvers::basis::solve_materials(mesh, requests, options, MPI_COMM_WORLD, {}, trace);
  const auto own =
      solvers::basis::solve_materials(mesh, requests, options, MPI_COMM_SELF, {}, own_trace);
  EXPECT_EQ(trace.stages["solve"].calls, 3);
  for (std::size_t i = 0; i < sets.size(); ++i) {
    const auto &a = sets[i], &b = own[i];
    EXPECT_EQ(a.certificate.snapshots, 3);
    EXPECT_EQ(a.certificate.modes_in_band, b.certificate.modes_in_band);
    EXPECT_NEAR(a.certificate.basis_error, b.certificate.basis_error, 1e-4);
    EXPECT_LT(a.certificate.orthonormality, 1e-10);
    ASSERT_EQ(a.size(), b.size());
    for (std::size_t k = 0; k < a.size(); ++k) {
      EXPECT_NEAR(a.eigenvalues[k], b.eigenvalues[k], 1e-8 * b.eigenvalues[k]);
    }
  }
}

}  // namespace
}  // namespace carillon
