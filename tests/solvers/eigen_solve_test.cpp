// Eigenpairs of bodies by both solvers, at 1 and 2 ranks.
#include "solvers/eigen/eigen_solve.hpp"

#include <gtest/gtest.h>
#include <mpi.h>
#include <petsc/private/petscimpl.h>

#include <Eigen/SVD>
#include <algorithm>
#include <cmath>

#include "core/error.hpp"
#include "solve.hpp"
#include "solvers/eigen/detail/iterative_inverse.hpp"
#include "test_meshes.hpp"

namespace carillon {
namespace {

using namespace solvers;
using test::box_mesh;

/// A body ready to be solved by a group.
struct Body {
  Body(const test::TetMesh& mesh, MPI_Comm group) : comm(group) {
    int ranks = 1;
    MPI_Comm_size(comm, &ranks);
    system = solvers::assembly::assemble(mesh, std::vector<solvers::elements::Elastic>{test::steel},
                                         solvers::assembly::partition(mesh, ranks), comm);
    // Near a tenth of the first frequency.
    shifted = solvers::eigen::factor_shifted(system, -0.02,
                                             solvers::eigen::plan_factors(system, comm), comm);
  }
  solvers::eigen::EigenPairs lowest(const solvers::eigen::EigenRequest& request) const {
    return solvers::eigen::lowest_pairs(system, request, shifted, comm);
  }
  /// With multigrid in place of the factor.
  solvers::eigen::EigenPairs lowest_by_multigrid(
      const test::TetMesh& mesh, const solvers::eigen::EigenRequest& request) const {
    const auto component = solvers::mesh::node_components(mesh);
    const std::vector regions(mesh.region_names.size(), test::steel);
    const auto iterative = solvers::eigen::iterative_shifted(
        mesh, regions, system, component, {shifted.shift, 1e-12, 1ll << 40}, comm);
    return solvers::eigen::lowest_pairs(system, request, iterative, comm);
  }
  MPI_Comm comm;
  solvers::assembly::System system;
  solvers::eigen::ShiftedSystem shifted;
};

double largest_difference(const solvers::eigen::EigenPairs& a, const solvers::eigen::EigenPairs& b,
                          int pairs, std::size_t rigid = 6) {
  double largest = 0;
  for (std::size_t k = rigid; k < static_cast<std::size_t>(pairs); ++k) {
    largest = std::max(largest, std::abs(a.values.at(k) / b.values.at(k) - 1));
  }
  return largest;
}

/// Cosine of the largest angle between the spaces of pairs [first, first + count) of both.
double smallest_cosine(const solvers::eigen::EigenPairs& a, const solvers::eigen::EigenPairs& b,
                       Eigen::Index first, Eigen::Index count) {
  Eigen::MatrixXd product =
      a.vectors.middleCols(first, count).transpose() * b.mass_vectors.middleCols(first, count);
  MPI_Allreduce(MPI_IN_PLACE, product.data(), static_cast<int>(product.size()), MPI_DOUBLE, MPI_SUM,
                MPI_COMM_WORLD);
  return Eigen::JacobiSVD<Eigen::MatrixXd>(product).singularValues().minCoeff();
}

void expect_good(const solvers::eigen::EigenPairs& pairs, int wanted) {
  ASSERT_GE(pairs.size(), wanted);
  EXPECT_TRUE(std::is_sorted(pairs.values.begin(), pairs.values.end()));
  for (std::size_t k = 6; k < static_cast<std::size_t>(wanted); ++k) {
    EXPECT_LT(pairs.residuals[k], 1e-8);
  }
  for (std::size_t k = 0; k < 6; ++k) EXPECT_LT(std::abs(pairs.values[k]), 1e-9);
  EXPECT_GT(pairs.values[6], 1e-3);
  EXPECT_LT(pairs.orthonormality, 1e-11);
}

/// A cube: single, twofold and threefold values.
TEST(EigenSolvers, FindTheSameModes) {
  const auto mesh = box_mesh({0.03, 0.03, 0.03}, {4, 4, 4}, 2);
  const Body body(mesh, MPI_COMM_WORLD);
  constexpr int wanted = 50;
  const auto block = body.lowest({wanted, 1e-12, 1, solvers::modes::EigenSolver::block_lanczos});
  const auto stock = body.lowest({wanted, 1e-12, 1, solvers::modes::EigenSolver::krylov_schur});
  expect_good(block, wanted);
  const auto multigrid = body.lowest_by_multigrid(mesh, {wanted, 1e-10, 1});
  EXPECT_EQ(multigrid.solver, solvers::modes::EigenSolver::lobpcg);
  expect_good(stock, wanted);
  expect_good(multigrid, wanted);
  EXPECT_LT(largest_difference(block, stock, wanted), 1e-9);
  EXPECT_LT(largest_difference(block, multigrid, wanted), 1e-9);
  int spaces = 0;
  for (Eigen::Index first = 0; first < wanted;) {
    Eigen::Index count = 1;
    const auto value = [&](Eigen::Index k) { return block.values[static_cast<std::size_t>(k)]; };
    while (first + count < wanted &&
           value(first + count) - value(first) < 1e-6 * std::abs(value(first + count)) + 1e-9) {
      ++count;
    }
    if (first + count < wanted) {  // the last may be cut
      EXPECT_GT(smallest_cosine(block, stock, first, count), 1 - 1e-9) << first << ", " << count;
      EXPECT_GT(smallest_cosine(block, multigrid, first, count), 1 - 1e-9)
          << first << ", " << count;
      spaces += count > 1;
    }
    first += count;
  }
  EXPECT_GT(spaces, 5) << "a cube has repeated modes";
}

/// An option of PETSc's data base for a while, as PETSC_OPTIONS would set it.
class Option {
 public:
  Option(const char* name, const char* value) : name_(name) {
    solvers::libraries::check(PetscOptionsSetValue(nullptr, name, value));
  }
  ~Option() { PetscOptionsClearValue(nullptr, name_); }
  Option(const Option&) = delete;
  Option& operator=(const Option&) = delete;

 private:
  const char* name_;
};

/// Types of SLEPc's and packages of PETSc's take the place of the project's own.
TEST(EigenSolvers, AreChosenByOptionsOfPetsc) {
  const auto mesh = box_mesh({0.02, 0.031, 0.053}, {2, 3, 5}, 2);
  constexpr int wanted = 30;
  const solvers::eigen::EigenRequest request{wanted, 1e-12, 1};
  const auto own = Body(mesh, MPI_COMM_WORLD).lowest(request);
  EXPECT_EQ(own.solver, solvers::modes::EigenSolver::block_lanczos);
  {
    const Option option("-eps_type", "krylovschur");
    const auto other = Body(mesh, MPI_COMM_WORLD).lowest(request);
    EXPECT_EQ(other.solver, solvers::modes::EigenSolver::krylov_schur);
    EXPECT_LT(largest_difference(own, other, wanted), 1e-9);
  }
  {
    const Option option("-eps_type", "subspace");
    const auto other = Body(mesh, MPI_COMM_WORLD).lowest(request);
    EXPECT_EQ(other.solver, solvers::modes::EigenSolver::slepc);
    EXPECT_LT(largest_difference(own, other, wanted), 1e-9);
  }
  {
    // Matrices are assembled for a package that knows nothing of shells.
    const Option option("-st_pc_factor_mat_solver_type", "mumps");
    const Body body(mesh, MPI_COMM_WORLD);
    Mat stiffness = nullptr;
    MatType type = nullptr;
    solvers::libraries::check(STGetMatrix(body.shifted.transformation.get(), 0, &stiffness));
    solvers::libraries::check(MatGetType(stiffness, &type));
    EXPECT_STRNE(type, MATSHELL);
    EXPECT_LT(largest_difference(own, body.lowest(request), wanted), 1e-9);
  }
  {
    const Option option("-eps_type", "krylovschur");
    const Body body(mesh, MPI_COMM_WORLD);
    const auto other = body.lowest_by_multigrid(mesh, {wanted, 1e-10, 1});
    EXPECT_EQ(other.solver, solvers::modes::EigenSolver::krylov_schur);
    EXPECT_LT(largest_difference(own, other, wanted), 1e-8);
  }
  {
    const Option few("-eps_max_it", "1"), small("-eps_mpd", "46");
    EXPECT_THROW(Body(mesh, MPI_COMM_WORLD).lowest(request), core::SolverError);
  }
  // What is made of modes relies on the transformation that was chosen for them.
  for (const auto& [name, value] :
       {std::pair("-st_type", "shift"), std::pair("-st_shift", "-0.5"),
        std::pair("-st_matmode", "shell"), std::pair("-eps_target", "1"),
        std::pair("-eps_smallest_real", "")}) {
    const Option option(name, value);
    EXPECT_THROW(Body(mesh, MPI_COMM_WORLD).lowest(request), core::InputError) << name;
  }
}

/// Solves after the first go on with the factor that is there.
TEST(EigenSolvers, FactorOnce) {
  const Body body(box_mesh({0.02, 0.031, 0.053}, {2, 3, 5}, 2), MPI_COMM_WORLD);
  const auto factor = [&body] {
    KSP ksp = nullptr;
    PC pc = nullptr;
    Mat matrix = nullptr;
    PetscObjectState state = 0;
    solvers::libraries::check(STGetKSP(body.shifted.transformation.get(), &ksp));
    solvers::libraries::check(KSPGetPC(ksp, &pc));
    solvers::libraries::check(PCFactorGetMatrix(pc, &matrix));
    solvers::libraries::check(PetscObjectStateGet(reinterpret_cast<PetscObject>(matrix), &state));
    return std::pair(matrix, state);
  };
  const auto first = factor();
  for (const auto solver :
       {solvers::modes::EigenSolver::block_lanczos, solvers::modes::EigenSolver::krylov_schur}) {
    body.lowest({20, 1e-12, 1, solver});
    EXPECT_EQ(factor(), first);
  }
}

/// What goes wrong in a function that PETSc calls arrives as what it was.
TEST(EigenSolvers, HandOnWhatTheirOperatorThrows) {
  const auto mesh = box_mesh({0.02, 0.031, 0.053}, {2, 3, 5}, 2);
  Body body(mesh, MPI_COMM_WORLD);
  int solves = 0;
  body.shifted = solvers::eigen::factor_shifted(
      body.system, -0.02, solvers::eigen::plan_factors(body.system, body.comm), body.comm,
      [&solves] {
        if (++solves % 3 == 0) throw core::MemoryError("no more");
      });
  for (const auto solver :
       {solvers::modes::EigenSolver::block_lanczos, solvers::modes::EigenSolver::krylov_schur}) {
    try {
      body.lowest({20, 1e-12, 1, solver});
      ADD_FAILURE() << "nothing was thrown";
    } catch (const core::MemoryError& error) {
      EXPECT_STREQ(error.what(), "no more");
    }
  }
}

TEST(EigenSolvers, DoNotDependOnTheSizeOfTheBasis) {
  const Body body(box_mesh({0.02, 0.031, 0.053}, {3, 4, 6}, 2), MPI_COMM_WORLD);
  constexpr int wanted = 40;
  const auto wide =
      body.lowest({wanted, 1e-12, 1, solvers::modes::EigenSolver::block_lanczos, 200});
  const auto narrow =
      body.lowest({wanted, 1e-12, 1, solvers::modes::EigenSolver::block_lanczos, 60});
  expect_good(wide, wanted);
  expect_good(narrow, wanted);
  EXPECT_LT(largest_difference(wide, narrow, wanted), 1e-10);
}

TEST(EigenSolvers, DoNotDependOnTheStart) {
  const Body body(box_mesh({0.02, 0.031, 0.053}, {3, 4, 6}, 2), MPI_COMM_WORLD);
  constexpr int wanted = 30;
  EXPECT_LT(
      largest_difference(body.lowest({wanted, 1e-12, 1}), body.lowest({wanted, 1e-12, 2}), wanted),
      1e-10);
}

TEST(EigenSolvers, GiveAGroupTheValuesOfOneRank) {
  const auto mesh = box_mesh({0.1, 0.1, 0.01}, {8, 8, 1}, 2);
  constexpr int wanted = 40;
  const Body alone(mesh, MPI_COMM_SELF), group(mesh, MPI_COMM_WORLD);
  for (const auto solver :
       {solvers::modes::EigenSolver::block_lanczos, solvers::modes::EigenSolver::krylov_schur}) {
    const solvers::eigen::EigenRequest request{wanted, 1e-12, 1, solver};
    EXPECT_LT(largest_difference(alone.lowest(request), group.lowest(request), wanted), 1e-10);
  }
  const solvers::eigen::EigenRequest request{wanted, 1e-10, 1};
  EXPECT_LT(largest_difference(alone.lowest_by_multigrid(mesh, request),
                               group.lowest_by_multigrid(mesh, request), wanted),
            1e-10);
}

/// Eight equal bodies: every value eightfold, the rigid one forty-eightfold.
TEST(EigenSolvers, FindEveryCopyOfEqualBodies) {
  const auto one = box_mesh({0.02, 0.031, 0.053}, {2, 2, 3}, 2);
  auto mesh = one;
  for (int k = 1; k < 8; ++k) {
    mesh = test::joined(
        mesh, test::moved(one, [k](const Vec3& x) -> Vec3 { return x + Vec3(0.1 * k, 0, 0); }));
  }
  mesh.regions.assign(mesh.regions.size(), 0);
  mesh.region_names.resize(1);
  const Body body(mesh, MPI_COMM_WORLD);
  const int wanted = 8 * 14;
  const auto pairs = body.lowest({wanted, 1e-12, 1});
  ASSERT_GE(pairs.size(), wanted);
  EXPECT_LT(
      largest_difference(pairs, body.lowest_by_multigrid(mesh, {wanted, 1e-10, 1}), wanted, 8 * 6),
      1e-9);
  const Body single(one, MPI_COMM_SELF);
  const auto of_one = single.lowest({14, 1e-12, 1});
  for (std::size_t k = 0; k < 14; ++k) {
    // Eigenvalues in units of the longest side, which differ.
    const double expected = single.system.scales.to_frequency(of_one.values[k]);
    for (std::size_t copy = 0; copy < 8; ++copy) {
      EXPECT_NEAR(body.system.scales.to_frequency(pairs.values[8 * k + copy]), expected,
                  k < 6 ? 50 : 1e-7 * expected);
    }
  }
}

/// Of one rank: on a group MUMPS adds in the order in which messages come.
TEST(EigenSolvers, AreTheSameBitsWhenSolvedAgain) {
  const Body body(box_mesh({0.02, 0.031, 0.053}, {3, 4, 6}, 2), MPI_COMM_SELF);
  EXPECT_EQ(body.lowest({20, 1e-12, 1}).values, body.lowest({20, 1e-12, 1}).values);
}

}  // namespace
}  // namespace carillon
