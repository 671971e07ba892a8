// LOBPCG and what it starts from, against dense and direct solvers, at 1 and 2 ranks.
#include "solvers/eigen/detail/lobpcg.hpp"

#include <gtest/gtest.h>
#include <mpi.h>

#include <Eigen/Eigenvalues>
#include <cmath>

#include "core/error.hpp"
#include "solve.hpp"
#include "solvers/eigen/detail/iterative_inverse.hpp"
#include "solvers/eigen/detail/near_modes.hpp"
#include "solvers/eigen/detail/reduced.hpp"
#include "solvers/eigen/detail/rigid.hpp"
#include "solvers/eigen/detail/start_vectors.hpp"
#include "solvers/eigen/eigen_solve.hpp"
#include "test_meshes.hpp"

namespace carillon {
namespace {

using namespace solvers;
using test::box_mesh;

constexpr double shift = -0.02;
constexpr std::int64_t no_limit = 1ll << 40;

/// A body with its equations, spread over a group.
struct Body {
  Body(test::TetMesh body, MPI_Comm group) : mesh(std::move(body)), comm(group) {
    int ranks = 1;
    MPI_Comm_size(comm, &ranks);
    regions.assign(mesh.region_names.size(), test::steel);
    component = solvers::mesh::node_components(mesh);
    system =
        solvers::assembly::assemble(mesh, regions, solvers::assembly::partition(mesh, ranks), comm);
  }
  solvers::eigen::ShiftedSystem direct() const {
    return solvers::eigen::factor_shifted(system, shift, solvers::eigen::plan_factors(system, comm),
                                          comm);
  }
  solvers::eigen::ShiftedSystem iterative(std::int64_t bytes = no_limit) const {
    return solvers::eigen::iterative_shifted(mesh, regions, system, component,
                                             {shift, 1e-12, bytes}, comm);
  }

  test::TetMesh mesh;
  MPI_Comm comm;
  std::vector<solvers::elements::Elastic> regions;
  std::vector<std::int32_t> component;
  solvers::assembly::System system;
};

/// The problem of a body whose rigid motions are known.
struct Deflated {
  explicit Deflated(const Body& body, const solvers::eigen::ShiftedSystem& shifted)
      : products(body.system, body.comm),
        rigid(solvers::eigen::rigid_basis(
            body.system, solvers::eigen::RigidMotions(body.mesh, body.system, body.component),
            body.comm)),
        mass_rigid(rigid.rows(), rigid.cols()),
        problem{&products,
                body.system.owned_unknowns(),
                body.system.unknowns(),
                shift,
                shifted.preconditioner,
                rigid,
                mass_rigid,
                body.comm} {
    products.mass(rigid, mass_rigid);
  }
  solvers::assembly::Products products;
  Eigen::MatrixXd rigid, mass_rigid;
  solvers::eigen::LobpcgProblem problem;
};

/// Values from the seventh on against those of another set.
void expect_values(const Eigen::VectorXd& found, const std::vector<double>& truth, int count,
                   double tolerance) {
  ASSERT_GE(found.size(), count);
  for (int k = 0; k < count; ++k) {
    EXPECT_NEAR(found[k] / truth.at(static_cast<std::size_t>(6 + k)), 1, tolerance) << k;
  }
}

/// From random vectors, more of them than have a place at a time; a cube has repeated modes.
TEST(Lobpcg, FindsTheLowestFromRandomVectors) {
  const Body body(box_mesh({0.03, 0.03, 0.03}, {4, 4, 4}, 2), MPI_COMM_WORLD);
  const auto direct = body.direct();
  const Deflated deflated(body, direct);
  constexpr int wanted = 60;
  const auto start = solvers::eigen::start_vectors(body.system, 1, wanted + 4);
  const auto found = solvers::eigen::lobpcg(deflated.problem, {wanted, 1e-10, 200}, start);
  EXPECT_GE(found.converged, wanted);
  const auto truth =
      solvers::eigen::lowest_pairs(body.system, {wanted + 6, 1e-12, 1}, direct, body.comm);
  expect_values(found.values, truth.values, wanted, 1e-12);
  Eigen::MatrixXd mass(found.vectors.rows(), found.vectors.cols());
  deflated.products.mass(found.vectors, mass);
  Eigen::MatrixXd gram = found.vectors.transpose() * mass,
                  along = deflated.rigid.transpose() * mass;
  solvers::eigen::sum_alike(gram, body.comm);
  solvers::eigen::sum_alike(along, body.comm);
  gram.diagonal().array() -= 1;
  EXPECT_LT(gram.cwiseAbs().maxCoeff(), 1e-11);
  EXPECT_LT(along.cwiseAbs().maxCoeff(), 1e-11);
}

/// The tolerance is of the residual, and the error of a value is about its square.
TEST(Lobpcg, AValueIsRightToTheSquareOfTheTolerance) {
  const Body body(box_mesh({0.02, 0.031, 0.053}, {3, 4, 6}, 2), MPI_COMM_WORLD);
  const auto direct = body.direct();
  const Deflated deflated(body, direct);
  constexpr int wanted = 10;
  const auto truth =
      solvers::eigen::lowest_pairs(body.system, {wanted + 6, 1e-12, 1}, direct, body.comm);
  const auto start = solvers::eigen::start_vectors(body.system, 1, wanted + 4);
  int before = 0;
  for (const double tolerance : {1e-2, 1e-3, 1e-4}) {
    const auto found = solvers::eigen::lobpcg(deflated.problem, {wanted, tolerance, 200}, start);
    EXPECT_GE(found.converged, wanted);
    EXPECT_GT(found.iterations, before);
    before = found.iterations;
    // The part of a residual that another mode nearby explains weighs more.
    expect_values(found.values, truth.values, wanted, 10 * tolerance * tolerance);
    for (int k = 0; k < wanted; ++k) {
      EXPECT_GT(found.values[k], truth.values[static_cast<std::size_t>(6 + k)] * (1 - 1e-11)) << k;
    }
  }
}

/// Vectors from the level below save a part of the way, and modes that are there all of it.
TEST(Lobpcg, GoesOnFromWhatIsKnown) {
  const Body body(test::ball_mesh(0.05, 2, 3), MPI_COMM_WORLD);
  const auto iterative = body.iterative();
  const Deflated deflated(body, iterative);
  constexpr int wanted = 20;
  const solvers::eigen::LobpcgOptions options{wanted, 1e-9, 200};
  const auto far = solvers::eigen::lobpcg(
      deflated.problem, options, solvers::eigen::start_vectors(body.system, 1, wanted + 4));
  const auto near =
      solvers::eigen::lobpcg(deflated.problem, options, iterative.near_modes(wanted + 4, 1));
  const auto there = solvers::eigen::lobpcg(deflated.problem, options, near.vectors);
  EXPECT_LT(near.iterations, far.iterations);
  EXPECT_EQ(there.iterations, 0);
  for (int k = 0; k < wanted; ++k) EXPECT_NEAR(near.values[k] / far.values[k], 1, 1e-12) << k;
}

/// A second solve for more modes pays for the new ones alone.
TEST(LowestPairs, GoOnFromThoseOfASolveBefore) {
  const Body body(box_mesh({0.02, 0.031, 0.053}, {3, 4, 6}, 2), MPI_COMM_WORLD);
  auto iterative = body.iterative();
  Eigen::Index columns = 0;
  iterative.preconditioner = [&columns, cycle = iterative.preconditioner](
                                 const Eigen::Ref<const Eigen::MatrixXd>& right,
                                 // Written through:
                                 // NOLINTNEXTLINE(performance-unnecessary-value-param)
                                 Eigen::Ref<Eigen::MatrixXd> solution) {
    columns += right.cols();
    cycle(right, solution);
  };
  const auto first =
      solvers::eigen::lowest_pairs(body.system, {26, 1e-10, 1}, iterative, body.comm);
  solvers::eigen::EigenRequest request{36, 1e-10, 1};
  columns = 0;
  const auto anew = solvers::eigen::lowest_pairs(body.system, request, iterative, body.comm);
  const auto cost_anew = columns;
  request.start = first.vectors.rightCols(20);
  columns = 0;
  const auto more = solvers::eigen::lowest_pairs(body.system, request, iterative, body.comm);
  EXPECT_LT(columns, 0.7 * static_cast<double>(cost_anew));
  for (std::size_t k = 6; k < 36; ++k) EXPECT_NEAR(more.values[k] / anew.values[k], 1, 1e-11) << k;
}

/// Modes of the order below, which on straight elements is that order's own space, carried up.
TEST(NearModes, AreThoseOfTheOrderBelow) {
  const auto box = [](int order) { return box_mesh({0.02, 0.031, 0.053}, {2, 3, 4}, order); };
  const Body body(box(3), MPI_COMM_WORLD), below(box(2), MPI_COMM_WORLD);
  constexpr int count = 12;
  const auto near = body.iterative().near_modes(count, 1);
  ASSERT_EQ(near.cols(), count);
  const auto truth =
      solvers::eigen::lowest_pairs(below.system, {count + 6, 1e-12, 1}, below.direct(), below.comm);
  const solvers::assembly::Products products(body.system, body.comm);
  Eigen::MatrixXd stiffness(near.rows(), count), mass(near.rows(), count);
  products.shifted(0, near, stiffness);
  products.mass(near, mass);
  Eigen::MatrixXd k = near.transpose() * stiffness, m = near.transpose() * mass;
  solvers::eigen::sum_alike(k, body.comm);
  solvers::eigen::sum_alike(m, body.comm);
  const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd> ritz(k, m);
  for (Eigen::Index i = 0; i < count; ++i) {
    const double ratio = ritz.eigenvalues()[i] / truth.values[static_cast<std::size_t>(6 + i)];
    EXPECT_GT(ratio, 1 - 1e-9) << i;
    EXPECT_LT(ratio, 1 + 1e-3) << i;
  }
}

/// More modes than have a place at a time, on a level that has fewer.
TEST(NearModes, AreAsManyAsAreAskedFor) {
  const Body body(box_mesh({0.02, 0.031, 0.053}, {1, 1, 2}, 2), MPI_COMM_WORLD);
  const auto iterative = body.iterative();
  ASSERT_GT(body.system.unknowns(), 80 + 6);
  EXPECT_EQ(iterative.near_modes(80, 1).cols(), 80);
  const auto all = solvers::eigen::lowest_pairs(body.system, {86, 1e-10, 1}, iterative, body.comm);
  const auto truth =
      solvers::eigen::lowest_pairs(body.system, {86, 1e-12, 1}, body.direct(), body.comm);
  for (std::size_t k = 6; k < 86; ++k) EXPECT_NEAR(all.values[k] / truth.values[k], 1, 1e-9) << k;
}

/// More vectors than there are dimensions beside the rigid ones, than have a place at a time too:
/// all modes, and an end.
TEST(Lobpcg, EndsWhereTheSpaceEnds) {
  const Body body(box_mesh({0.02, 0.031, 0.053}, {1, 1, 1}, 1), MPI_COMM_SELF);
  const auto direct = body.direct();
  const Deflated deflated(body, direct);
  const auto all = static_cast<int>(body.system.unknowns()) - 6;
  const auto truth =
      solvers::eigen::lowest_pairs(body.system, {all + 6, 1e-12, 1}, direct, body.comm);
  for (const int more : {0, 5, 40}) {
    const auto found =
        solvers::eigen::lobpcg(deflated.problem, {all, 1e-9, 200},
                               solvers::eigen::start_vectors(body.system, 1, all + more));
    EXPECT_EQ(found.values.size(), all);
    expect_values(found.values, truth.values, all, 1e-9);
  }
  // Where nothing is left beside what is known, nothing is found.
  const solvers::eigen::LobpcgProblem full = {&deflated.products,     body.system.owned_unknowns(),
                                              body.system.unknowns(), shift,
                                              direct.preconditioner,  truth.vectors,
                                              truth.mass_vectors,     body.comm};
  const auto none = solvers::eigen::lobpcg(full, {1, 1e-9, 200},
                                           solvers::eigen::start_vectors(body.system, 1, 3));
  EXPECT_EQ(none.values.size(), 0);
  EXPECT_EQ(none.converged, 0);
}

/// A mode that shows only when others have been set aside, since its start vector waited for a
/// place, is among the lowest all the same.
TEST(Lobpcg, LatecomersConvergeToo) {
  const Body body(box_mesh({0.02, 0.031, 0.053}, {3, 4, 6}, 2), MPI_COMM_WORLD);
  const auto direct = body.direct();
  const Deflated deflated(body, direct);
  constexpr int wanted = 40;
  const auto truth =
      solvers::eigen::lowest_pairs(body.system, {wanted + 10, 1e-12, 1}, direct, body.comm);
  // All but the third and the fourth, which come last and roughly.
  Eigen::MatrixXd start = truth.vectors.middleCols(6, wanted + 4);
  const auto rough = solvers::eigen::start_vectors(body.system, 7, 2);
  const double size = 0.1 * start.col(2).norm() / rough.col(0).norm();
  const Eigen::MatrixXd late = start.middleCols(2, 2) + size * rough;
  start.middleCols(2, wanted) = start.rightCols(wanted).eval();
  start.middleCols(wanted + 2, 2) = late;
  const auto found = solvers::eigen::lobpcg(deflated.problem, {wanted, 1e-10, 200}, start);
  EXPECT_GE(found.converged, wanted);
  expect_values(found.values, truth.values, wanted, 1e-11);
}

TEST(Lobpcg, SaysHowManyConverged) {
  const Body body(box_mesh({0.02, 0.031, 0.053}, {3, 4, 6}, 2), MPI_COMM_WORLD);
  const auto direct = body.direct();
  const Deflated deflated(body, direct);
  const auto found = solvers::eigen::lobpcg(deflated.problem, {10, 1e-10, 2},
                                            solvers::eigen::start_vectors(body.system, 1, 14));
  EXPECT_EQ(found.iterations, 2);
  EXPECT_LT(found.converged, 10);
  EXPECT_EQ(found.values.size(), 14);
}

TEST(Lobpcg, RefusesAPreconditionerThatIsNotDefinite) {
  const Body body(box_mesh({0.02, 0.031, 0.053}, {2, 2, 2}, 2), MPI_COMM_WORLD);
  auto shifted = body.direct();
  shifted.preconditioner = [](const Eigen::Ref<const Eigen::MatrixXd>& right,
                              Eigen::Ref<Eigen::MatrixXd> solution) { solution = -right; };
  const Deflated deflated(body, shifted);
  EXPECT_THROW(solvers::eigen::lobpcg(deflated.problem, {5, 1e-10, 20},
                                      solvers::eigen::start_vectors(body.system, 1, 9)),
               core::SolverError);
}

/// A tolerance below what rounding allows ends where rounding holds the residual up.
TEST(Lobpcg, EndsWhereRoundingHoldsItUp) {
  const Body body(box_mesh({0.1, 0.1, 0.001}, {12, 12, 1}, 2), MPI_COMM_WORLD);
  const auto direct = body.direct();
  const Deflated deflated(body, direct);
  constexpr int wanted = 8;
  const auto found =
      solvers::eigen::lobpcg(deflated.problem, {wanted, 1e-18, 200},
                             solvers::eigen::start_vectors(body.system, 1, wanted + 4));
  EXPECT_GE(found.converged, wanted);
  EXPECT_LT(found.iterations, 60);
  const auto truth =
      solvers::eigen::lowest_pairs(body.system, {wanted + 6, 1e-12, 1}, direct, body.comm);
  // A value is the rounding of K away from that of another solver.
  expect_values(found.values, truth.values, wanted, 1e-7);
}

/// Columns are multiplied eight at a time: any number of them gives what each gives by itself.
TEST(Products, OfManyColumnsAreThoseOfEach) {
  const Body body(box_mesh({0.02, 0.031, 0.053}, {2, 3, 2}, 2), MPI_COMM_WORLD);
  const solvers::assembly::Products products(body.system, body.comm);
  for (Eigen::Index columns = 1; columns <= 17; ++columns) {
    const auto x = solvers::eigen::start_vectors(body.system, 3, columns);
    Eigen::MatrixXd stiffness(x.rows(), columns), mass(x.rows(), columns), alone(x.rows(), 1);
    products.shifted(-0.3, x, stiffness);
    products.mass(x, mass);
    for (Eigen::Index k = 0; k < columns; ++k) {
      products.shifted(-0.3, x.col(k), alone);
      EXPECT_EQ(alone, stiffness.col(k)) << columns << ", " << k;
      products.mass(x.col(k), alone);
      EXPECT_EQ(alone, mass.col(k)) << columns << ", " << k;
    }
  }
}

}  // namespace
}  // namespace carillon
