// What is decided from sizes, before anything is factored.
#include "solvers/eigen/detail/memory_gate.hpp"

#include <gtest/gtest.h>

#include "core/error.hpp"
#include "solve.hpp"
#include "test_meshes.hpp"

namespace carillon {
namespace {

using namespace solvers;

constexpr std::int64_t gib = 1ll << 30;

/// 2 GiB of matrices, 1 GiB of vectors, factors as given; the one that solves keeps 8 of 10 bytes.
solvers::eigen::MemoryNeeds needs(std::int64_t solve, std::int64_t count) {
  return {2 * gib, gib, 0, 0, {solve / 10, solve}, {count / 10, count}, gib};
}

TEST(MemoryGate, WhatFitsIsSolvedDirectlyAndCounted) {
  for (const auto asked :
       {solvers::modes::LinearSolver::automatic, solvers::modes::LinearSolver::direct}) {
    const auto decision = solvers::eigen::decide(needs(5 * gib, 4 * gib), asked, 16 * gib);
    EXPECT_EQ(decision.linear_solver, solvers::modes::LinearSolver::direct);
    EXPECT_TRUE(decision.counts);
    EXPECT_TRUE(decision.both_fit);
  }
}

TEST(MemoryGate, FactorsThatFitOneByOneAreNotHeldTogether) {
  const auto decision = solvers::eigen::decide(needs(10 * gib, 9 * gib),
                                               solvers::modes::LinearSolver::automatic, 16 * gib);
  EXPECT_EQ(decision.linear_solver, solvers::modes::LinearSolver::direct);
  EXPECT_TRUE(decision.counts);
  EXPECT_FALSE(decision.both_fit);
}

TEST(MemoryGate, ACountThatDoesNotFitIsLeftOut) {
  const auto decision = solvers::eigen::decide(needs(10 * gib, 15 * gib),
                                               solvers::modes::LinearSolver::automatic, 16 * gib);
  EXPECT_EQ(decision.linear_solver, solvers::modes::LinearSolver::direct);
  EXPECT_FALSE(decision.counts);
}

TEST(MemoryGate, ALargerFactorIsIterated) {
  const auto decision = solvers::eigen::decide(needs(14 * gib, 5 * gib),
                                               solvers::modes::LinearSolver::automatic, 16 * gib);
  EXPECT_EQ(decision.linear_solver, solvers::modes::LinearSolver::iterative);
  EXPECT_FALSE(decision.counts);
  EXPECT_GT(decision.coarse_factor, 10 * gib);
  EXPECT_LT(decision.coarse_factor, 13 * gib);
  // And to the byte: 3 GiB beside it.
  EXPECT_EQ(
      solvers::eigen::decide(needs(13 * gib, 0), solvers::modes::LinearSolver::automatic, 16 * gib)
          .linear_solver,
      solvers::modes::LinearSolver::direct);
  EXPECT_EQ(solvers::eigen::decide(needs(13 * gib + 1, 0), solvers::modes::LinearSolver::automatic,
                                   16 * gib)
                .linear_solver,
            solvers::modes::LinearSolver::iterative);
}

TEST(MemoryGate, IterativeWhenAskedThoughAFactorWouldFit) {
  const auto decision =
      solvers::eigen::decide(needs(gib, gib), solvers::modes::LinearSolver::iterative, 16 * gib);
  EXPECT_EQ(decision.linear_solver, solvers::modes::LinearSolver::iterative);
  EXPECT_FALSE(decision.counts);
}

std::string refusal(const solvers::eigen::MemoryNeeds& what, solvers::modes::LinearSolver asked,
                    std::int64_t limit) {
  try {
    solvers::eigen::decide(what, asked, limit);
  } catch (const core::SolverError& e) {
    return e.message() + " | " + e.hint();
  }
  return "";
}

TEST(MemoryGate, DirectThatDoesNotFitNamesTheNumbersAndTheWaysOut) {
  const auto text = refusal(needs(14 * gib, gib), solvers::modes::LinearSolver::direct, 16 * gib);
  for (const char* part : {"14.0 GiB", "2.0 GiB", "1.0 GiB", "16.0 GiB", "coarser mesh",
                           "iterative", "memory limit"}) {
    EXPECT_NE(text.find(part), std::string::npos) << part << " in: " << text;
  }
}

TEST(MemoryGate, MatricesAloneMayBeTooMuch) {
  for (const auto asked :
       {solvers::modes::LinearSolver::automatic, solvers::modes::LinearSolver::iterative}) {
    const auto text = refusal(needs(14 * gib, gib), asked, 3 * gib);
    // A coarser level beside them.
    EXPECT_NE(text.find("2.5 GiB of matrices"), std::string::npos) << text;
  }
}

TEST(MemoryGate, ManyModesNeedRoomForTheirVectors) {
  auto what = needs(10 * gib, gib);
  const auto decision =
      solvers::eigen::decide(what, solvers::modes::LinearSolver::automatic, 16 * gib);
  solvers::eigen::refuse_large_basis(what, decision, 16 * gib);
  what.vectors = 7 * gib;
  EXPECT_THROW(solvers::eigen::refuse_large_basis(what, decision, 16 * gib), core::SolverError);
  // An iterative solver has a basis of its own.
  const auto iterative = solvers::eigen::decide(needs(10 * gib, gib),
                                                solvers::modes::LinearSolver::iterative, 16 * gib);
  solvers::eigen::refuse_large_basis(what, iterative, 16 * gib);
  what.iterative_vectors = 14 * gib;
  EXPECT_THROW(solvers::eigen::refuse_large_basis(what, iterative, 16 * gib), core::SolverError);
}

/// Errors are estimated beside the factor and the pairs, when the basis is gone.
TEST(MemoryGate, EstimatesAreWeighed) {
  auto what = needs(10 * gib, gib);
  what.pairs = gib / 2;
  what.estimate = 5 * gib;
  const auto direct =
      solvers::eigen::decide(what, solvers::modes::LinearSolver::automatic, 16 * gib);
  EXPECT_EQ(direct.linear_solver, solvers::modes::LinearSolver::direct);
  EXPECT_EQ(solvers::eigen::left_for_estimates(what, direct, 16 * gib), 11 * gib / 2);
  what.estimate = 6 * gib;  // 2 + 8 + 0.5 beside it
  const auto iterative =
      solvers::eigen::decide(what, solvers::modes::LinearSolver::automatic, 16 * gib);
  EXPECT_EQ(iterative.linear_solver, solvers::modes::LinearSolver::iterative);
  EXPECT_EQ(solvers::eigen::left_for_estimates(what, iterative, 16 * gib), what.estimate);
  what.estimate = 14 * gib;
  EXPECT_THROW(solvers::eigen::decide(what, solvers::modes::LinearSolver::automatic, 16 * gib),
               core::SolverError);
}

TEST(MemoryGate, SlicesNeedTwoFactorsWorth) {
  EXPECT_TRUE(solvers::eigen::slices_fit(needs(6 * gib, gib), 16 * gib));
  EXPECT_FALSE(solvers::eigen::slices_fit(needs(6 * gib + 1, gib), 16 * gib));
}

/// The gate stands before a real solve: the same body under different limits.
TEST(MemoryGate, TheLimitDecidesHowABodyIsSolved) {
  const auto mesh = test::box_mesh({0.02, 0.031, 0.053}, {3, 4, 6}, 2);
  const std::vector regions{test::steel};
  const auto system = solvers::assembly::assemble(
      mesh, regions, solvers::assembly::partition(mesh, 1), MPI_COMM_SELF);
  solvers::eigen::SolveOptions options;
  options.band = {20, 1e9, 8};
  options.estimate_errors = false;
  options.memory_limit = 1 << 20;
  const auto plan = solvers::eigen::plan_factors(system, MPI_COMM_SELF);
  const auto what = solvers::eigen::memory_needs(mesh, system, options, plan, 18, MPI_COMM_SELF);
  EXPECT_GT(what.solve.entries, system.unknowns() * 20);
  EXPECT_GE(what.solve.bytes, 8 * what.solve.entries);
  EXPECT_GT(what.count.bytes, 0);
  EXPECT_EQ(what.system,
            static_cast<std::int64_t>(8 * system.stiffness.size() + 12 * system.mass.size()));
  const auto solved_under = [&](std::int64_t limit, solvers::modes::LinearSolver asked) {
    core::Trace trace;
    options.memory_limit = limit;
    options.linear_solver = asked;
    return solvers::eigen::solve_modes(mesh, regions, options, MPI_COMM_SELF, trace);
  };
  const auto ample = what.system + what.vectors + what.solve.bytes + what.count.bytes;
  const auto tight = what.system + what.vectors + what.solve.bytes - 1;
  const auto direct = solved_under(ample, solvers::modes::LinearSolver::automatic);
  EXPECT_EQ(direct.certificate.linear_solver, solvers::modes::LinearSolver::direct);
  EXPECT_TRUE(direct.certificate.count_verified);
  const auto iterative = solved_under(tight, solvers::modes::LinearSolver::automatic);
  EXPECT_EQ(iterative.certificate.linear_solver, solvers::modes::LinearSolver::iterative);
  EXPECT_FALSE(iterative.certificate.count_verified);
  ASSERT_EQ(iterative.size(), direct.size());
  for (std::size_t k = 0; k < direct.size(); ++k) {
    EXPECT_NEAR(iterative.frequency(k) / direct.frequency(k), 1, 1e-9);
  }
  EXPECT_THROW(solved_under(tight, solvers::modes::LinearSolver::direct), core::SolverError);
  // Just enough for each factor by itself: they follow each other, and the count stands.
  const auto one = solved_under(tight + 1, solvers::modes::LinearSolver::automatic);
  EXPECT_EQ(one.certificate.linear_solver, solvers::modes::LinearSolver::direct);
  EXPECT_EQ(one.eigenvalues, direct.eigenvalues);
}

}  // namespace
}  // namespace carillon
