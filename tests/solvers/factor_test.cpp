// Factors and products, at 1, 2 and 3 ranks, against dense algebra on the whole matrices.
#include "solvers/eigen/factor.hpp"

#include <gtest/gtest.h>
#include <mpi.h>

#include <Eigen/Eigenvalues>
#include <cmath>

#include "core/error.hpp"
#include "solve.hpp"
#include "solvers/assembly/products.hpp"
#include "solvers/eigen/eigen_solve.hpp"
#include "solvers/eigen/transformation.hpp"
#include "test_meshes.hpp"

namespace carillon {
namespace {

using namespace solvers;
using test::box_mesh;

int ranks() {
  int size = 1;
  MPI_Comm_size(MPI_COMM_WORLD, &size);
  return size;
}

solvers::assembly::System assembled(const test::TetMesh& mesh, int parts, MPI_Comm comm) {
  return solvers::assembly::assemble(mesh, std::vector<solvers::elements::Elastic>{test::steel},
                                     solvers::assembly::partition(mesh, parts), comm);
}

/// K and M of a whole body, numbered by mesh node.
struct Whole {
  Eigen::MatrixXd k, m;
};

Whole dense(const test::TetMesh& mesh) {
  const auto system = assembled(mesh, 1, MPI_COMM_SELF);
  const auto n = static_cast<Eigen::Index>(system.unknowns());
  Whole out{Eigen::MatrixXd::Zero(n, n), Eigen::MatrixXd::Zero(n, n)};
  for (Eigen::Index row = 0; row < system.graph.rows(); ++row) {
    const auto begin = system.graph.first[static_cast<std::size_t>(row)];
    const auto width = system.graph.first[static_cast<std::size_t>(row) + 1] - begin;
    for (std::int64_t k = 0; k < width; ++k) {
      const Eigen::Index column = system.graph.column[static_cast<std::size_t>(begin + k)];
      for (Eigen::Index i = 0; i < 3; ++i) {
        out.m(3 * row + i, 3 * column + i) = system.mass[static_cast<std::size_t>(begin + k)];
        for (Eigen::Index j = 0; j < 3; ++j) {
          out.k(3 * row + i, 3 * column + j) =
              system.stiffness[static_cast<std::size_t>(9 * begin + (i * width + k) * 3 + j)];
        }
      }
    }
  }
  return out;
}

/// Rows of a whole matrix (by mesh node) that this rank owns.
Eigen::MatrixXd own_rows(const solvers::assembly::System& system, const Eigen::MatrixXd& whole) {
  Eigen::MatrixXd out(system.owned_unknowns(), whole.cols());
  for (std::int32_t row = 0; row < system.graph.rows(); ++row) {
    const auto node = system.partition.node[static_cast<std::size_t>(system.graph.begin + row)];
    out.middleRows<3>(3 * row) = whole.middleRows<3>(3 * Eigen::Index{node});
  }
  return out;
}

class Factors : public testing::Test {
 protected:
  const test::TetMesh mesh = box_mesh({0.02, 0.031, 0.053}, {2, 2, 3}, 2);
  const Whole whole = dense(mesh);
  const solvers::assembly::System system = assembled(mesh, ranks(), MPI_COMM_WORLD);
  // More columns than one block of products, and some over.
  const Eigen::MatrixXd right = Eigen::MatrixXd::Random(whole.k.rows(), 11);
};

TEST_F(Factors, ProductsAreThoseOfTheMatrices) {
  const double shift = -0.37;
  const solvers::assembly::Products products(system, MPI_COMM_WORLD);
  Eigen::MatrixXd out(system.owned_unknowns(), right.cols());
  products.mass(own_rows(system, right), out);
  EXPECT_LT((out - own_rows(system, whole.m * right)).cwiseAbs().maxCoeff(), 1e-14);
  const Eigen::MatrixXd shifted = whole.k - shift * whole.m;
  const double size = shifted.cwiseAbs().maxCoeff();
  products.shifted(shift, own_rows(system, right), out);
  EXPECT_LT((out - own_rows(system, shifted * right)).cwiseAbs().maxCoeff(), 1e-13 * size);

  // The same as PETSc knows them.
  const auto plan = solvers::eigen::plan_factors(system, MPI_COMM_WORLD);
  const auto transformation =
      solvers::eigen::factored_transformation(system, shift, plan, MPI_COMM_WORLD);
  KSP ksp = nullptr;
  Mat matrix = nullptr;
  solvers::libraries::check(STGetKSP(transformation.get(), &ksp));
  solvers::libraries::check(KSPGetOperators(ksp, &matrix, nullptr));
  solvers::eigen::VecHandle x, y;
  solvers::libraries::check(MatCreateVecs(matrix, x.put(), y.put()));
  double* values = nullptr;
  solvers::libraries::check(VecGetArray(x.get(), &values));
  Eigen::Map<Eigen::VectorXd>(values, out.rows()) = own_rows(system, right.col(0));
  solvers::libraries::check(VecRestoreArray(x.get(), &values));
  solvers::libraries::check(MatMult(matrix, x.get(), y.get()));
  solvers::libraries::check(VecGetArray(y.get(), &values));
  EXPECT_LT((Eigen::Map<Eigen::VectorXd>(values, out.rows()) - out.col(0)).cwiseAbs().maxCoeff(),
            1e-14 * size);
  solvers::libraries::check(VecRestoreArray(y.get(), &values));
}

/// By the factor as PETSc applies it, to one vector and to many columns.
TEST_F(Factors, TransformAsSlepcAsks) {
  const double shift = -0.37;
  const auto plan = solvers::eigen::plan_factors(system, MPI_COMM_WORLD);
  int solves = 0;
  const auto transformation = solvers::eigen::factored_transformation(
      system, shift, plan, MPI_COMM_WORLD, [&solves] { ++solves; });
  const Eigen::MatrixXd exact = (whole.k - shift * whole.m).llt().solve(whole.m * right);
  Eigen::MatrixXd product(system.owned_unknowns(), right.cols()), out = product;
  solvers::assembly::Products(system, MPI_COMM_WORLD).mass(own_rows(system, right), product);
  solvers::eigen::inverse_of(transformation)(product, out);
  EXPECT_LT((out - own_rows(system, exact)).norm(), 1e-11 * exact.norm());
  EXPECT_EQ(solves, 1);

  solvers::eigen::VecHandle x, y;
  Mat mass = nullptr;
  solvers::libraries::check(STGetMatrix(transformation.get(), 1, &mass));
  solvers::libraries::check(MatCreateVecs(mass, x.put(), y.put()));
  double* values = nullptr;
  solvers::libraries::check(VecGetArray(x.get(), &values));
  Eigen::Map<Eigen::VectorXd>(values, out.rows()) = own_rows(system, right.col(1));
  solvers::libraries::check(VecRestoreArray(x.get(), &values));
  solvers::libraries::check(STApply(transformation.get(), x.get(), y.get()));
  solvers::libraries::check(VecGetArray(y.get(), &values));
  EXPECT_LT((Eigen::Map<Eigen::VectorXd>(values, out.rows()) - out.col(1)).norm(),
            1e-11 * exact.norm());
  solvers::libraries::check(VecRestoreArray(y.get(), &values));
  EXPECT_EQ(solves, 2);
}

TEST_F(Factors, SolveBlocksOfColumns) {
  const double shift = -0.02;
  const auto plan = solvers::eigen::plan_factors(system, MPI_COMM_WORLD);
  const auto inverse = solvers::eigen::factored_inverse(system, shift, plan, MPI_COMM_WORLD);
  const Eigen::MatrixXd exact = (whole.k - shift * whole.m).llt().solve(right);
  for (const Eigen::Index columns : {1, 3, 11}) {
    Eigen::MatrixXd out(system.owned_unknowns(), columns);
    inverse(own_rows(system, right.leftCols(columns)), out);
    const Eigen::MatrixXd difference = out - own_rows(system, exact.leftCols(columns));
    EXPECT_LT(difference.cwiseAbs().maxCoeff(), 1e-9 * exact.cwiseAbs().maxCoeff());
  }
}

TEST_F(Factors, OfAnotherShiftComeFromTheSamePlan) {
  const auto plan = solvers::eigen::plan_factors(system, MPI_COMM_WORLD);
  Eigen::MatrixXd out(system.owned_unknowns(), 2);
  for (const double shift : {-1.0, -30.0}) {
    solvers::eigen::factored_inverse(system, shift, plan, MPI_COMM_WORLD)(
        own_rows(system, right.leftCols(2)), out);
    const Eigen::MatrixXd exact = (whole.k - shift * whole.m).llt().solve(right.leftCols(2));
    EXPECT_LT((out - own_rows(system, exact)).norm(), 1e-10 * exact.norm());
  }
}

/// Every count between two eigenvalues is their number.
TEST_F(Factors, CountEigenvaluesByInertia) {
  const auto plan = solvers::eigen::plan_factors(system, MPI_COMM_WORLD);
  const Eigen::VectorXd values = Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd>(
                                     whole.k, whole.m, Eigen::EigenvaluesOnly)
                                     .eigenvalues();
  for (const Eigen::Index k : {6, 7, 12, 60, 200}) {
    const double between = k == 6 ? values[6] / 2 : (values[k - 1] + values[k]) / 2;
    EXPECT_EQ(solvers::eigen::count_below(system, between, plan, MPI_COMM_WORLD), k);
  }
  EXPECT_EQ(
      solvers::eigen::count_below(system, 1.01 * values[values.size() - 1], plan, MPI_COMM_WORLD),
      values.size());
}

/// The entries of a factor are bounded by those of its matrix and of a full triangle, and a larger
/// body takes more; the count's memory is less than what its factor would fill.
TEST(FactorSize, IsKnownBefore) {
  solvers::eigen::FactorSize last;
  for (const int cells : {3, 6}) {
    const auto mesh = box_mesh({0.02, 0.02, 0.02}, {cells, cells, cells}, 2);
    const auto system = assembled(mesh, ranks(), MPI_COMM_WORLD);
    const auto plan = solvers::eigen::plan_factors(system, MPI_COMM_WORLD);
    auto triangle = static_cast<std::int64_t>(system.stiffness.size()) / 2;
    MPI_Allreduce(MPI_IN_PLACE, &triangle, 1, MPI_INT64_T, MPI_SUM, MPI_COMM_WORLD);
    const auto n = system.unknowns();
    const auto solve = solvers::eigen::predict_factor(system, solvers::eigen::FactorPurpose::solve,
                                                      plan, MPI_COMM_WORLD);
    const auto count = solvers::eigen::predict_factor(system, solvers::eigen::FactorPurpose::count,
                                                      plan, MPI_COMM_WORLD);
    for (const auto& size : {solve, count}) {
      EXPECT_GT(size.entries, triangle);
      EXPECT_LT(size.entries, n * (n + 1) / 2);
    }
    EXPECT_GT(solve.bytes, 8 * solve.entries);
    EXPECT_LT(solve.bytes, 8 * (3 * solve.entries + 8 * triangle) + (100 << 20));
    EXPECT_GT(solve.entries, last.entries);
    EXPECT_GT(solve.bytes, last.bytes);
    last = solve;
  }
}

/// Entries of one rank's factor, counted by elimination on the dense matrix.
TEST(FactorSize, IsThatOfTheEliminationOnOneRank) {
  const auto mesh = box_mesh({0.02, 0.02, 0.04}, {2, 2, 6}, 1);
  const auto system = assembled(mesh, 1, MPI_COMM_SELF);
  const auto plan = solvers::eigen::plan_factors(system, MPI_COMM_SELF);
  const auto whole = dense(mesh);
  Eigen::VectorXi order(whole.k.rows());
  Eigen::Index place = 0;
  for (const auto node : plan.node_order) {
    for (int i = 0; i < 3; ++i) order[place++] = 3 * node + i;
  }
  Eigen::MatrixXi full = (whole.k.array() != 0 || whole.m.array() != 0).cast<int>();
  // Neighbours couple in all components, whether their entry happens to vanish or not.
  for (Eigen::Index a = 0; a < full.rows(); a += 3) {
    for (Eigen::Index b = 0; b < full.cols(); b += 3) {
      if (full.block<3, 3>(a, b).sum() > 0) full.block<3, 3>(a, b).setOnes();
    }
  }
  std::int64_t entries = 0;
  Eigen::MatrixXi l = full(order, order);
  for (Eigen::Index k = 0; k < l.rows(); ++k) {
    for (Eigen::Index i = k; i < l.rows(); ++i) entries += l(i, k);
    for (Eigen::Index i = k + 1; i < l.rows(); ++i) {
      if (l(i, k) == 0) continue;
      for (Eigen::Index j = k + 1; j <= i; ++j) l(i, j) |= l(j, k);
    }
  }
  const auto size = solvers::eigen::predict_factor(system, solvers::eigen::FactorPurpose::solve,
                                                   plan, MPI_COMM_SELF);
  // Supernodes are stored as full rectangles and may be merged.
  EXPECT_GE(size.entries, entries);
  EXPECT_LT(static_cast<double>(size.entries), 2.5 * static_cast<double>(entries));
}

TEST_F(Factors, RefuseAMatrixThatIsNotPositiveDefinite) {
  const auto plan = solvers::eigen::plan_factors(system, MPI_COMM_WORLD);
  EXPECT_THROW(solvers::eigen::factored_inverse(system, 1e3, plan, MPI_COMM_WORLD),
               core::SolverError);
}

}  // namespace
}  // namespace carillon
