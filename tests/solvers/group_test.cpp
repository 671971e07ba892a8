// Groups of ranks that solve one body: the answer of one rank, and failures that reach all.
#include <gtest/gtest.h>
#include <mpi.h>
#include <sys/resource.h>

#include <cmath>
#include <fstream>
#include <memory>
#include <new>
#include <numeric>
#include <optional>

#include "core/data_limit.hpp"
#include "core/error.hpp"
#include "core/sanitizers.hpp"
#include "mpi/comm.hpp"
#include "solve.hpp"
#include "solvers/assembly/fields.hpp"
#include "solvers/eigen/extract.hpp"
#include "solvers/eigen/factor.hpp"
#include "solvers/eigen/search.hpp"
#include "test_meshes.hpp"

namespace carillon {
namespace {

using namespace solvers;
using test::box_mesh;

int world_size() {
  int size = 1;
  MPI_Comm_size(MPI_COMM_WORLD, &size);
  return size;
}

bool on_last_rank() {
  int rank = 0;
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  return rank == world_size() - 1;
}

bool on_all_ranks(bool here) {
  int all = here ? 1 : 0;
  MPI_Allreduce(MPI_IN_PLACE, &all, 1, MPI_INT, MPI_MIN, MPI_COMM_WORLD);
  return all == 1;
}

test::TetMesh block() {
  return box_mesh({0.02, 0.031, 0.053}, {2, 2, 4}, 3);
}

solvers::modes::Modes solve(const test::TetMesh& mesh, MPI_Comm comm,
                            solvers::modes::LinearSolver linear_solver,
                            const solvers::eigen::SearchMethods& methods = {}) {
  core::Trace trace;
  solvers::eigen::SolveOptions options;
  options.band = {20, 120000, 20};
  options.linear_solver = linear_solver;
  options.estimate_errors = false;
  const std::vector<solvers::elements::Elastic> regions(mesh.region_names.size(), test::steel);
  return solvers::eigen::solve_modes(mesh, regions, options, comm, trace, methods);
}

void expect_equal(const solvers::modes::Modes& group, const solvers::modes::Modes& alone,
                  double tolerance) {
  ASSERT_EQ(group.size(), alone.size());
  for (std::size_t k = 0; k < alone.size(); ++k) {
    EXPECT_NEAR(group.frequency(k) / alone.frequency(k), 1, tolerance) << k;
  }
  EXPECT_LT(group.certificate.max_residual, 1e-8);
  EXPECT_EQ(group.certificate.rigid_modes, alone.certificate.rigid_modes);
  EXPECT_EQ(group.certificate.complete, alone.certificate.complete);
}

TEST(Group, DirectModesAreThoseOfOneRank) {
  const auto alone = solve(block(), MPI_COMM_SELF, solvers::modes::LinearSolver::direct);
  const auto group = solve(block(), MPI_COMM_WORLD, solvers::modes::LinearSolver::direct);
  expect_equal(group, alone, 1e-9);
  EXPECT_TRUE(group.certificate.count_verified);
  EXPECT_EQ(group.certificate.modes_in_band, alone.certificate.modes_in_band);
}

/// Two bodies: each has rigid motions of its own.
TEST(Group, IterativeModesAreThoseOfOneRank) {
  const auto one = box_mesh({0.02, 0.031, 0.053}, {2, 2, 3}, 3);
  const auto mesh = test::joined(
      one, test::moved(one, [](const Vec3& x) -> Vec3 { return 0.8 * x + Vec3(0.1, 0, 0); }));
  const auto alone = solve(mesh, MPI_COMM_SELF, solvers::modes::LinearSolver::direct);
  const auto group = solve(mesh, MPI_COMM_WORLD, solvers::modes::LinearSolver::iterative);
  expect_equal(group, alone, 1e-9);
  EXPECT_FALSE(group.certificate.count_verified);
  EXPECT_EQ(group.certificate.linear_solver, solvers::modes::LinearSolver::iterative);
}

/// Algebraic multigrid over several ranks, as order 1 has no level below.
TEST(Group, AlgebraicMultigridSolvesOnRanks) {
  const auto mesh = box_mesh({0.02, 0.031, 0.053}, {7, 8, 9}, 1);
  expect_equal(solve(mesh, MPI_COMM_WORLD, solvers::modes::LinearSolver::iterative),
               solve(mesh, MPI_COMM_SELF, solvers::modes::LinearSolver::direct), 1e-9);
}

/// Three bodies that lie loose have eighteen rigid modes; three that share faces are one.
TEST(Group, CountsTheRigidModesOfComponents) {
  const auto one = box_mesh({0.02, 0.02, 0.03}, {2, 2, 3}, 2);
  auto loose = one;
  for (int n = 1; n < 3; ++n) {
    loose = test::joined(
        loose, test::moved(one, [n](const Vec3& x) -> Vec3 { return x + Vec3(0.05 * n, 0, 0); }));
  }
  const auto apart = solve(loose, MPI_COMM_WORLD, solvers::modes::LinearSolver::direct);
  EXPECT_EQ(apart.certificate.components, 3);
  EXPECT_EQ(apart.certificate.rigid_modes, 18);
  EXPECT_TRUE(apart.certificate.count_verified);
  const auto touching = solve(
      box_mesh({0.06, 0.02, 0.03}, {6, 2, 3}, 2, [](const Vec3& x) { return int(x[0] / 0.02); }),
      MPI_COMM_WORLD, solvers::modes::LinearSolver::direct);
  EXPECT_EQ(touching.certificate.components, 1);
  EXPECT_EQ(touching.certificate.rigid_modes, 6);
}

/// A mode that is lost on a group is sliced for by the group.
TEST(Group, SlicesForModesThatAreLost) {
  const auto alone = solve(block(), MPI_COMM_SELF, solvers::modes::LinearSolver::direct);
  int slices = 0;
  solvers::eigen::SearchMethods methods;
  methods.lowest = [](const solvers::assembly::System& system,
                      const solvers::eigen::EigenRequest& request,
                      const solvers::eigen::ShiftedSystem& shifted, MPI_Comm comm) {
    auto pairs = solvers::eigen::lowest_pairs(system, request, shifted, comm);
    pairs.vectors.col(9) = pairs.vectors.rightCols(1).eval();
    pairs.values[9] = pairs.values.back();
    pairs.values.pop_back();
    pairs.vectors.conservativeResize(Eigen::NoChange, pairs.vectors.cols() - 1);
    std::vector<Eigen::Index> order;
    for (Eigen::Index k = 0; k < pairs.vectors.cols(); ++k) {
      if (k != 9) order.push_back(k);
    }
    order.push_back(9);
    pairs.vectors = pairs.vectors(Eigen::all, order).eval();
    std::rotate(pairs.values.begin() + 9, pairs.values.begin() + 10, pairs.values.end());
    solvers::eigen::measure(system, shifted, comm, pairs);
    return pairs;
  };
  methods.slice = [&slices](const solvers::assembly::System& system, double low, double high,
                            double tolerance, MPI_Comm comm) {
    ++slices;
    return solvers::eigen::slice_spectrum(system, low, high, tolerance, comm);
  };
  expect_equal(solve(block(), MPI_COMM_WORLD, solvers::modes::LinearSolver::direct, methods), alone,
               1e-9);
  EXPECT_GE(slices, 1);
}

template <class Error>
std::string error_of(const std::function<void()>& work) {
  try {
    work();
  } catch (const Error& e) {
    return e.message();
  }
  return "";
}

/// One rank fails in the solver: all hear of it, none waits, and the group goes on.
TEST(Group, AFailureOfOneRankReachesAll) {
  solvers::eigen::SearchMethods methods;
  methods.lowest = [](const solvers::assembly::System& system,
                      const solvers::eigen::EigenRequest& request,
                      const solvers::eigen::ShiftedSystem& shifted, MPI_Comm comm) {
    auto pairs = solvers::eigen::lowest_pairs(system, request, shifted, comm);
    if (on_last_rank()) throw core::SolverError("rank fell over");
    return pairs;
  };
  const auto message = error_of<core::SolverError>(
      [&] { solve(block(), MPI_COMM_WORLD, solvers::modes::LinearSolver::direct, methods); });
  EXPECT_TRUE(on_all_ranks(message == "rank fell over")) << message;
  EXPECT_GT(solve(block(), MPI_COMM_WORLD, solvers::modes::LinearSolver::direct).size(), 0u);
}

/// The first rank's clock passes the limit when the eigensolver begins: all stop in its first
/// steps, inside SLEPc too, and the group goes on.
TEST(Group, ATimeLimitReachesAllInTheMiddleOfASolve) {
  solvers::eigen::SolveOptions options;
  options.band = {20, 120000, 20};
  options.estimate_errors = false;
  const auto mesh = block();
  const std::vector<solvers::elements::Elastic> regions(mesh.region_names.size(), test::steel);
  for (const auto solver :
       {solvers::modes::EigenSolver::block_lanczos, solvers::modes::EigenSolver::krylov_schur}) {
    for (const auto linear :
         {solvers::modes::LinearSolver::direct, solvers::modes::LinearSolver::iterative}) {
      options.solver = solver;
      options.linear_solver = linear;
      options.time = {1.5, "the solve", "limits.solve_time"};
      bool began = false, ended = false;
      solvers::eigen::SearchMethods methods;
      methods.lowest = [&](const solvers::assembly::System& system,
                           const solvers::eigen::EigenRequest& request,
                           const solvers::eigen::ShiftedSystem& shifted, MPI_Comm comm) {
        began = true;
        int rank = 0;
        MPI_Comm_rank(comm, &rank);
        while (rank == 0 && !options.time.passed()) {
        }
        auto pairs = solvers::eigen::lowest_pairs(system, request, shifted, comm);
        ended = true;
        return pairs;
      };
      core::Trace trace;
      const auto message = error_of<core::TimeError>([&] {
        solvers::eigen::solve_modes(mesh, regions, options, MPI_COMM_WORLD, trace, methods);
      });
      EXPECT_TRUE(on_all_ranks(message == "the solve takes longer than the limit of 1.5 s"))
          << message;
      EXPECT_TRUE(on_all_ranks(began && !ended));
    }
  }
  EXPECT_GT(solve(mesh, MPI_COMM_WORLD, solvers::modes::LinearSolver::direct).size(), 0u);
}

TEST(Group, WhatNobodyWaitsForEndsInTheMiddleOfASolve) {
  solvers::eigen::SolveOptions options;
  options.band = {20, 120000, 20};
  options.estimate_errors = false;
  const auto mesh = block();
  const std::vector<solvers::elements::Elastic> regions(mesh.region_names.size(), test::steel);
  bool began = false, ended = false;
  options.time.work = "the solve";
  options.time.given_up = [&] { return began; };
  solvers::eigen::SearchMethods methods;
  methods.lowest = [&](const solvers::assembly::System& system,
                       const solvers::eigen::EigenRequest& request,
                       const solvers::eigen::ShiftedSystem& shifted, MPI_Comm comm) {
    began = true;
    auto pairs = solvers::eigen::lowest_pairs(system, request, shifted, comm);
    ended = true;
    return pairs;
  };
  core::Trace trace;
  const auto message = error_of<core::TimeError>(
      [&] { solvers::eigen::solve_modes(mesh, regions, options, MPI_COMM_WORLD, trace, methods); });
  EXPECT_TRUE(on_all_ranks(message == "the solve was interrupted")) << message;
  EXPECT_TRUE(on_all_ranks(began && !ended));
}

/// One rank runs out of memory in earnest: its address space is limited to little more than it has.
TEST(Group, OneRankOutOfMemoryReachesAll) {
  if (core::address_sanitizer) GTEST_SKIP() << "AddressSanitizer knows no limits of memory";
  const auto mesh = box_mesh({0.1, 0.1, 0.1}, {10, 10, 10}, 3);
  rlimit before{};
  ASSERT_EQ(getrlimit(RLIMIT_AS, &before), 0);
  if (on_last_rank()) {
    std::ifstream statm("/proc/self/statm");
    rlim_t pages = 0;
    ASSERT_TRUE(statm >> pages);
    rlimit tight = before;
    tight.rlim_cur = pages * 4096 + (24u << 20);
    ASSERT_EQ(setrlimit(RLIMIT_AS, &tight), 0);
  }
  const auto message = error_of<core::MemoryError>(
      [&] { solve(mesh, MPI_COMM_WORLD, solvers::modes::LinearSolver::direct); });
  if (on_last_rank()) {
    ASSERT_EQ(setrlimit(RLIMIT_AS, &before), 0);
  }
  EXPECT_TRUE(on_all_ranks(message.find("out of memory") != std::string::npos)) << message;
  EXPECT_GT(solve(block(), MPI_COMM_WORLD, solvers::modes::LinearSolver::direct).size(), 0u);
}

/// Leaves rank 0 alone without memory for more than the smallest things.
class NoMemoryOnTheFirst {
 public:
  NoMemoryOnTheFirst() {
    int rank = 0;
    MPI_Comm_rank(MPI_COMM_WORLD, &rank);
    if (rank != 0) return;
    taken_.reserve(1 << 16);
    limit_.emplace(data() + (1 << 20));
    try {  // what was freed, but not given back
      for (;;) taken_.push_back(std::make_unique<char[]>(256 << 10));
    } catch (const std::bad_alloc&) {
    }
  }

 private:
  static std::int64_t data() {
    std::ifstream statm("/proc/self/statm");
    std::int64_t pages = 0;
    for (int field = 0; field < 6; ++field) statm >> pages;
    return pages * 4096;
  }
  std::vector<std::unique_ptr<char[]>> taken_;
  std::optional<core::DataLimit> limit_;
};

struct Assembled {
  test::TetMesh mesh = box_mesh({0.1, 0.1, 0.1}, {5, 5, 5}, 3);
  std::vector<solvers::elements::Elastic> regions{test::steel};
  solvers::assembly::System system = solvers::assembly::assemble(
      mesh, regions, solvers::assembly::partition(mesh, world_size()), MPI_COMM_WORLD);
};

void expect_all_hear(const std::string& message) {
  EXPECT_TRUE(on_all_ranks(message == "out of memory")) << message;
}

/// Between the guarded stages of a solve: shapes are gathered on every rank.
TEST(Group, TheFirstRankOutOfMemoryWhereModesAreExtractedReachesAll) {
  if (core::address_sanitizer) GTEST_SKIP() << "AddressSanitizer knows no limits of memory";
  const Assembled body;
  solvers::eigen::EigenPairs pairs;
  pairs.vectors = Eigen::MatrixXd::Random(body.system.owned_unknowns(), 32);
  std::vector<std::size_t> chosen(32);
  std::iota(chosen.begin(), chosen.end(), 0U);
  std::vector<std::int32_t> surface_nodes;
  solvers::eigen::surface_of(body.mesh, surface_nodes);
  for (int again = 0; again < 2; ++again) {
    std::string message;
    {
      const NoMemoryOnTheFirst none;
      message = error_of<core::MemoryError>([&] {
        solvers::eigen::extract_fields(body.mesh, body.regions, body.system, pairs, chosen,
                                       surface_nodes, MPI_COMM_WORLD);
      });
    }
    expect_all_hear(message);
  }
  EXPECT_EQ(solvers::eigen::extract_fields(body.mesh, body.regions, body.system, pairs, chosen,
                                           surface_nodes, MPI_COMM_WORLD)
                .eigenvalues.size(),
            32u);
}

TEST(Group, TheFirstRankOutOfMemoryWhereFieldsAreGatheredReachesAll) {
  if (core::address_sanitizer) GTEST_SKIP() << "AddressSanitizer knows no limits of memory";
  const Assembled body;
  const Eigen::MatrixXd fields = Eigen::MatrixXd::Random(body.system.owned_unknowns(), 32);
  std::string message;
  {
    const NoMemoryOnTheFirst none;
    message = error_of<core::MemoryError>(
        [&] { solvers::assembly::gather_fields(body.system, fields, MPI_COMM_WORLD); });
  }
  expect_all_hear(message);
}

/// Whole columns are gathered on rank 0 alone.
TEST(Group, TheFirstRankOutOfMemoryWhereAFactorIsAppliedReachesAll) {
  if (core::address_sanitizer) GTEST_SKIP() << "AddressSanitizer knows no limits of memory";
  const Assembled body;
  const auto plan = solvers::eigen::plan_factors(body.system, MPI_COMM_WORLD);
  const auto inverse = solvers::eigen::factored_inverse(body.system, -1e-3, plan, MPI_COMM_WORLD);
  const Eigen::MatrixXd right = Eigen::MatrixXd::Random(body.system.owned_unknowns(), 64);
  Eigen::MatrixXd solution(right.rows(), right.cols());
  std::string message;
  {
    const NoMemoryOnTheFirst none;
    message = error_of<core::MemoryError>([&] { inverse(right, solution); });
  }
  if (world_size() > 1) expect_all_hear(message);
  EXPECT_NO_THROW(inverse(right, solution));
}

/// One rank fails outside every stage while the others solve: they hear of it in their next stage.
TEST(Group, AnErrorOutsideOfStagesMeetsTheOthersInTheirs) {
  for (int again = 0; again < 2; ++again) {
    const auto task = [&] {
      if (on_last_rank()) throw core::InputError("fell over");
      solve(block(), MPI_COMM_WORLD, solvers::modes::LinearSolver::direct);
    };
    const auto message =
        error_of<core::InputError>([&] { mpi::agree_at_end(MPI_COMM_WORLD, mpi::error_of(task)); });
    EXPECT_TRUE(on_all_ranks(message == "fell over")) << message;
  }
}

}  // namespace
}  // namespace carillon
