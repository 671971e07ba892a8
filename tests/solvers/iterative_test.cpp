// Multigrid cycles, and LOBPCG and conjugate gradients with them, against direct factors and
// assembled matrices.
#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <Eigen/Cholesky>
#include <cmath>

#include "core/error.hpp"
#include "core/random.hpp"
#include "solve.hpp"
#include "solvers/assembly/products.hpp"
#include "solvers/eigen/detail/conjugate_gradients.hpp"
#include "solvers/eigen/detail/iterative_inverse.hpp"
#include "solvers/eigen/detail/multigrid.hpp"
#include "solvers/eigen/detail/p_coarsening.hpp"
#include "solvers/eigen/detail/probe.hpp"
#include "solvers/eigen/search.hpp"
#include "test_meshes.hpp"

namespace carillon {
namespace {

using namespace solvers;
using test::box_mesh;

constexpr std::int64_t no_limit = 1ll << 40, nothing = 0;

Eigen::MatrixXd random_columns(Eigen::Index rows, Eigen::Index columns, std::uint64_t seed) {
  core::RandomStream random(seed, 0, "test");
  return Eigen::MatrixXd::NullaryExpr(rows, columns, [&] { return random.uniform(-1, 1); });
}

/// A body with its equations and a shift as the search would choose it.
struct Problem {
  test::TetMesh mesh;
  std::vector<solvers::elements::Elastic> regions;
  std::vector<std::int32_t> component;
  solvers::assembly::System system;
  double shift;

  explicit Problem(test::TetMesh body)
      : mesh(std::move(body)),
        regions(mesh.region_names.size(), test::steel),
        component(solvers::mesh::node_components(mesh)),
        system(solvers::assembly::assemble(mesh, regions, solvers::assembly::partition(mesh, 1),
                                           MPI_COMM_SELF)) {
    const auto bounded = [this] {
      test::TetMesh out = mesh;
      out.faces = solvers::mesh::boundary_faces(mesh);
      return out;
    }();
    shift = -0.01 * system.scales.from_frequency(
                        solvers::eigen::estimate_first_frequency(bounded, regions));
  }

  solvers::eigen::Inverse cycle(std::int64_t bytes) const {
    return iterative(bytes).preconditioner;
  }
  solvers::eigen::ShiftedSystem direct() const {
    return solvers::eigen::factor_shifted(
        system, shift, solvers::eigen::plan_factors(system, MPI_COMM_SELF), MPI_COMM_SELF);
  }
  solvers::eigen::ShiftedSystem iterative(std::int64_t bytes) const {
    return solvers::eigen::iterative_shifted(mesh, regions, system, component,
                                             {shift, 1e-12, bytes}, MPI_COMM_SELF);
  }
};

test::TetMesh block(int order) {
  const int cells = order == 1 ? 4 : order == 2 ? 2 : 1;
  return box_mesh({0.02, 0.031, 0.053}, {cells, cells + 1, 2 * cells}, order);
}

test::TetMesh two_blocks(int order) {
  return test::joined(block(order), test::moved(block(order), [](const Vec3& x) -> Vec3 {
                        return 0.7 * x + Vec3(0.1, 0, 0);
                      }));
}

/// The equations restricted to a lower order are those assembled at it, when elements are straight.
TEST(Coarsening, OfStraightElementsIsTheLowerOrder) {
  for (const auto& [fine, coarse] : {std::pair{2, 1}, {3, 2}, {3, 1}, {4, 2}}) {
    const Problem problem(block(fine));
    const auto level = solvers::eigen::coarsen(problem.mesh, problem.regions, problem.mesh,
                                               problem.system.partition, coarse, MPI_COMM_SELF);
    const auto truth = solvers::assembly::assemble(
        level.mesh, problem.regions, solvers::assembly::partition(level.mesh, 1), MPI_COMM_SELF);
    ASSERT_EQ(level.system.stiffness.size(), truth.stiffness.size());
    const auto worst = [](const std::vector<double>& a, const std::vector<double>& b) {
      double difference = 0, largest = 0;
      for (std::size_t k = 0; k < a.size(); ++k) {
        difference = std::max(difference, std::abs(a[k] - b[k]));
        largest = std::max(largest, std::abs(b[k]));
      }
      return difference / largest;
    };
    EXPECT_LT(worst(level.system.stiffness, truth.stiffness), 1e-12) << fine << coarse;
    EXPECT_LT(worst(level.system.mass, truth.mass), 1e-12) << fine << coarse;
  }
}

/// On curved elements too, energies are those of the field that is carried over.
TEST(Coarsening, KeepsEnergiesOnCurvedElements) {
  const Problem problem(test::ball_mesh(0.05, 2, 3));
  const solvers::assembly::Products fine(problem.system, MPI_COMM_SELF);
  for (const int order : {1, 2}) {
    const auto level = solvers::eigen::coarsen(problem.mesh, problem.regions, problem.mesh,
                                               problem.system.partition, order, MPI_COMM_SELF);
    const solvers::assembly::Products coarse(level.system, MPI_COMM_SELF);
    const Eigen::MatrixXd u = random_columns(level.system.unknowns(), 1, 7);
    Eigen::MatrixXd carried(problem.system.unknowns(), 1), ku(u.rows(), 1),
        k_carried(carried.rows(), 1), mu = ku, m_carried = k_carried;
    solvers::eigen::VecHandle from, to;
    solvers::libraries::check(VecCreateMPIWithArray(
        MPI_COMM_SELF, 3, static_cast<PetscInt>(u.rows()), PETSC_DETERMINE, u.data(), from.put()));
    solvers::libraries::check(VecCreateMPIWithArray(MPI_COMM_SELF, 3,
                                                    static_cast<PetscInt>(carried.rows()),
                                                    PETSC_DETERMINE, carried.data(), to.put()));
    solvers::libraries::check(MatMult(level.prolongation.get(), from.get(), to.get()));
    coarse.shifted(0, u, ku);
    fine.shifted(0, carried, k_carried);
    coarse.mass(u, mu);
    fine.mass(carried, m_carried);
    EXPECT_NEAR(u.cwiseProduct(ku).sum() / carried.cwiseProduct(k_carried).sum(), 1, 1e-12);
    EXPECT_NEAR(u.cwiseProduct(mu).sum() / carried.cwiseProduct(m_carried).sum(), 1, 1e-12);
  }
}

/// (u, B v) = (B u, v) and (u, B u) > 0, with a factor and with algebraic multigrid at the bottom.
TEST(Multigrid, CyclesAreSymmetricAndPositive) {
  for (int order = 1; order <= 4; ++order) {
    const Problem problem(two_blocks(order));
    for (const auto bytes : {no_limit, nothing}) {
      const auto cycle = problem.cycle(bytes);
      const auto n = problem.system.unknowns();
      EXPECT_TRUE(rc::check([&] {
        const auto seed = *rc::gen::arbitrary<std::uint64_t>();
        const Eigen::MatrixXd u = random_columns(n, 2, seed);
        Eigen::MatrixXd b(n, 2);
        cycle(u, b);
        const double one = u.col(0).dot(b.col(1)), other = u.col(1).dot(b.col(0));
        const double size = std::sqrt(u.col(0).dot(b.col(0)) * u.col(1).dot(b.col(1)));
        RC_ASSERT(std::abs(one - other) < 1e-9 * size);
      }));
    }
  }
}

TEST(Multigrid, SolvesWhatTheFactorSolves) {
  struct Case {
    std::string name;
    test::TetMesh mesh;
    int maximum;  ///< iterations
  };
  std::vector<Case> cases;
  for (int order = 1; order <= 4; ++order) {
    cases.push_back({"two blocks", two_blocks(order), 60});
    cases.push_back({"plate", box_mesh({0.1, 0.1, 0.01}, {12 / order, 12 / order, 1}, order), 90});
  }
  cases.push_back({"ball", test::ball_mesh(0.05, 2, 3), 40});
  for (const auto& c : cases) {
    const Problem problem(c.mesh);
    const auto n = problem.system.unknowns();
    const solvers::assembly::Products products(problem.system, MPI_COMM_SELF);
    const solvers::eigen::Inverse product = [&](const Eigen::Ref<const Eigen::MatrixXd>& x,
                                                Eigen::Ref<Eigen::MatrixXd> out) {
      products.shifted(problem.shift, x, out);
    };
    Eigen::MatrixXd right(n, 5), direct(n, 5), iterative(n, 5);
    products.mass(random_columns(n, 5, 3), right);
    problem.direct().inverse(right, direct);
    for (const auto bytes : {no_limit, nothing}) {
      SCOPED_TRACE(c.name + " order " + std::to_string(c.mesh.order));
      const int iterations = solvers::eigen::conjugate_gradients(product, problem.cycle(bytes), {},
                                                                 right, iterative, MPI_COMM_SELF);
      EXPECT_LT((iterative - direct).norm() / direct.norm(), 1e-8);
      // Algebraic multigrid at the bottom may be weak on flat elements; a factor may not.
      if (bytes > 0) {
        EXPECT_LE(iterations, c.maximum);
      }
    }
  }
}

TEST(ConjugateGradients, SolveColumnsThatConvergeApart) {
  const Eigen::VectorXd diagonal = Eigen::VectorXd::LinSpaced(50, 1, 1000);
  const solvers::eigen::Inverse product = [&](const Eigen::Ref<const Eigen::MatrixXd>& x,
                                              Eigen::Ref<Eigen::MatrixXd> out) {
    out = diagonal.asDiagonal() * x;
  };
  const solvers::eigen::Inverse none = [](const Eigen::Ref<const Eigen::MatrixXd>& x,
                                          Eigen::Ref<Eigen::MatrixXd> out) { out = x; };
  // Zero, an eigenvector, a few of them, all of them.
  Eigen::MatrixXd right = Eigen::MatrixXd::Zero(50, 4), solution(50, 4);
  right(3, 1) = 2;
  right.col(2).head(5).setOnes();
  right.col(3).setOnes();
  const int iterations =
      solvers::eigen::conjugate_gradients(product, none, {}, right, solution, MPI_COMM_SELF);
  EXPECT_LE(iterations, 60);
  const Eigen::MatrixXd truth = diagonal.cwiseInverse().asDiagonal() * right;
  EXPECT_LT((solution - truth).norm(), 1e-10);
  EXPECT_EQ(solution.col(0).norm(), 0);
}

TEST(ConjugateGradients, ThatDoNotConvergeSayWhatWouldHelp) {
  const Problem problem(block(2));
  const solvers::assembly::Products products(problem.system, MPI_COMM_SELF);
  const solvers::eigen::Inverse product = [&](const Eigen::Ref<const Eigen::MatrixXd>& x,
                                              Eigen::Ref<Eigen::MatrixXd> out) {
    products.shifted(problem.shift, x, out);
  };
  const Eigen::MatrixXd right = random_columns(problem.system.unknowns(), 3, 1);
  Eigen::MatrixXd solution(right.rows(), 3);
  try {
    solvers::eigen::conjugate_gradients(product, problem.cycle(nothing), {1e-12, 3}, right,
                                        solution, MPI_COMM_SELF);
    FAIL() << "three iterations were enough";
  } catch (const core::SolverError& e) {
    EXPECT_NE(e.message().find("3 iterations"), std::string::npos) << e.message();
    EXPECT_NE(e.message().find("direct solver"), std::string::npos) << e.message();
  }
}

TEST(ConjugateGradients, RefuseWhatIsNotDefinite) {
  const solvers::eigen::Inverse indefinite = [](const Eigen::Ref<const Eigen::MatrixXd>& x,
                                                Eigen::Ref<Eigen::MatrixXd> out) {
    out = x;
    out.row(0) *= -5;
  };
  const solvers::eigen::Inverse none = [](const Eigen::Ref<const Eigen::MatrixXd>& x,
                                          Eigen::Ref<Eigen::MatrixXd> out) { out = x; };
  Eigen::MatrixXd right = Eigen::MatrixXd::Ones(4, 1), solution(4, 1);
  EXPECT_THROW(
      solvers::eigen::conjugate_gradients(indefinite, none, {}, right, solution, MPI_COMM_SELF),
      core::SolverError);
  EXPECT_THROW(
      solvers::eigen::conjugate_gradients(none, indefinite, {}, right, solution, MPI_COMM_SELF),
      core::SolverError);
}

solvers::modes::Modes solve(const test::TetMesh& mesh, const solvers::modes::Band& band,
                            solvers::modes::LinearSolver linear_solver,
                            const solvers::eigen::SearchMethods& methods = {}) {
  core::Trace trace;
  solvers::eigen::SolveOptions options;
  options.band = band;
  options.linear_solver = linear_solver;
  options.estimate_errors = false;
  const std::vector<solvers::elements::Elastic> regions(mesh.region_names.size(), test::steel);
  return solvers::eigen::solve_modes(mesh, regions, options, MPI_COMM_SELF, trace, methods);
}

TEST(Iterative, ModesAreThoseOfTheDirectSolver) {
  const solvers::modes::Band bands[] = {{20, 90000, 300}, {20, 150000, 12}, {40000, 90000, 300}};
  for (const auto& band : bands) {
    for (const auto& mesh : {two_blocks(2), block(3)}) {
      const auto direct = solve(mesh, band, solvers::modes::LinearSolver::direct);
      const auto iterative = solve(mesh, band, solvers::modes::LinearSolver::iterative);
      ASSERT_GT(direct.size(), 3u);
      ASSERT_EQ(iterative.size(), direct.size());
      for (std::size_t k = 0; k < direct.size(); ++k) {
        EXPECT_NEAR(iterative.frequency(k) / direct.frequency(k), 1, 1e-9) << k;
      }
      const auto &d = direct.certificate, &i = iterative.certificate;
      EXPECT_TRUE(d.count_verified);
      EXPECT_EQ(d.linear_solver, solvers::modes::LinearSolver::direct);
      EXPECT_FALSE(i.count_verified);
      EXPECT_EQ(i.linear_solver, solvers::modes::LinearSolver::iterative);
      EXPECT_EQ(i.complete, d.complete);
      EXPECT_LT(i.max_residual, 1e-8);
      EXPECT_LT(i.orthonormality, 1e-9);
      EXPECT_EQ(i.rigid_modes, d.rigid_modes);
      if (d.complete) {
        EXPECT_EQ(i.modes_in_band, d.modes_in_band);
        EXPECT_EQ(i.complete_to_hz, d.complete_to_hz);
      } else {
        // Those beyond max_modes were not looked for.
        EXPECT_GT(i.modes_in_band, i.modes_found);
        EXPECT_LE(i.modes_in_band, d.modes_in_band);
        EXPECT_GE(i.complete_to_hz, iterative.frequency(iterative.size() - 1));
        EXPECT_LE(i.complete_to_hz, d.complete_to_hz * (1 + 1e-6));
      }
    }
  }
}

TEST(Iterative, NoModeInTheBandIsAnEmptyResult) {
  const auto modes = solve(block(2), {20, 5000, 300}, solvers::modes::LinearSolver::iterative);
  EXPECT_EQ(modes.size(), 0u);
  EXPECT_EQ(modes.certificate.modes_in_band, 0);
  EXPECT_TRUE(modes.certificate.complete);
  EXPECT_FALSE(modes.certificate.count_verified);
}

TEST(Probe, NoticesAnyModeThatASetLacks) {
  const Problem problem(block(2));
  const auto shifted = problem.direct();
  const auto all =
      solvers::eigen::lowest_pairs(problem.system, {26, 1e-12, 1}, shifted, MPI_COMM_SELF);
  const double highest = all.values.back();
  const auto beside = [&](const solvers::eigen::EigenPairs& pairs) {
    return solvers::eigen::lowest_beside(pairs, problem.system, shifted, 5, MPI_COMM_SELF);
  };
  EXPECT_GT(beside(all), highest);
  for (Eigen::Index lost = 0; lost < all.size() - 3; ++lost) {
    solvers::eigen::EigenPairs pairs;
    std::vector<Eigen::Index> kept;
    for (Eigen::Index k = 0; k < all.size(); ++k) {
      if (k != lost) kept.push_back(k);
    }
    pairs.vectors = all.vectors(Eigen::all, kept);
    pairs.mass_vectors = all.mass_vectors(Eigen::all, kept);
    const double seen = beside(pairs), truth = all.values[static_cast<std::size_t>(lost)];
    EXPECT_LT(seen, highest) << lost;
    EXPECT_GT(seen, truth - 1e-9 * highest) << lost;
  }
}

/// Without a count, a solver that loses a mode is noticed by the probe.
TEST(Iterative, AModeThatIsLostIsNoticed) {
  const solvers::modes::Band band{20, 90000, 300};
  const auto truth = solve(block(2), band, solvers::modes::LinearSolver::iterative);
  ASSERT_TRUE(truth.certificate.complete);
  for (const int times : {1, 1000}) {
    int solves = 0;
    solvers::eigen::SearchMethods methods;
    methods.lowest = [&](const solvers::assembly::System& system,
                         const solvers::eigen::EigenRequest& request,
                         const solvers::eigen::ShiftedSystem& shifted, MPI_Comm comm) {
      auto pairs = solvers::eigen::lowest_pairs(system, request, shifted, comm);
      if (++solves > times) return pairs;
      constexpr Eigen::Index lost = 8;
      const auto left = pairs.size() - lost - 1;
      pairs.vectors.middleCols(lost, left) = pairs.vectors.rightCols(left).eval();
      pairs.vectors.conservativeResize(Eigen::NoChange, pairs.size() - 1);
      pairs.values.erase(pairs.values.begin() + lost);
      solvers::eigen::measure(system, shifted, comm, pairs);
      return pairs;
    };
    const auto modes = solve(block(2), band, solvers::modes::LinearSolver::iterative, methods);
    EXPECT_GE(solves, 2);
    if (times == 1) {
      EXPECT_EQ(modes.size(), truth.size());
      EXPECT_TRUE(modes.certificate.complete);
    } else {
      EXPECT_EQ(modes.size() + 1, truth.size());
      EXPECT_FALSE(modes.certificate.complete);
      EXPECT_GT(modes.certificate.modes_in_band, modes.certificate.modes_found);
      EXPECT_LT(modes.certificate.complete_to_hz, truth.frequency(2));
    }
    EXPECT_FALSE(modes.certificate.count_verified);
  }
}

}  // namespace
}  // namespace carillon
