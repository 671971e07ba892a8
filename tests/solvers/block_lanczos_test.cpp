// Block Lanczos on operators whose eigenvalues are known, at 1 and 2 ranks.
#include "solvers/eigen/detail/block_lanczos.hpp"

#include <gtest/gtest.h>
#include <mpi.h>
#include <rapidcheck.h>

#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace carillon {
namespace {

using namespace solvers;
using Block = solvers::eigen::LanczosProblem::Block;
using ConstBlock = solvers::eigen::LanczosProblem::ConstBlock;

/// Rows [first, first + count) of an operator are this rank's.
struct Share {
  Share(Eigen::Index total, MPI_Comm comm) {
    int rank = 0, ranks = 1;
    MPI_Comm_rank(comm, &rank);
    MPI_Comm_size(comm, &ranks);
    first = total * rank / ranks;
    count = total * (rank + 1) / ranks - first;
  }
  Eigen::Index first = 0, count = 0;
};

double start_value(Eigen::Index row, int number) {
  return std::sin(1.0 + 12.9898 * static_cast<double>(row) + 78.233 * number +
                  0.37 * static_cast<double>(row % 17) * number);
}

/// Op = D in the inner product of a diagonal mass matrix, unit vectors are eigenvectors.
struct Diagonal {
  explicit Diagonal(const std::vector<double>& eigenvalues, MPI_Comm comm = MPI_COMM_WORLD)
      : share(static_cast<Eigen::Index>(eigenvalues.size()), comm),
        values(Eigen::Map<const Eigen::VectorXd>(eigenvalues.data() + share.first, share.count)) {
    masses.resize(share.count);
    for (Eigen::Index k = 0; k < share.count; ++k) {
      masses[k] = 1 + static_cast<double>((share.first + k) % 5);
    }
    problem.owned = share.count;
    problem.total = static_cast<Eigen::Index>(eigenvalues.size());
    problem.comm = comm;
    problem.mass = [this](const ConstBlock& x, Block out) { out = masses.asDiagonal() * x; };
    problem.apply = [this](const ConstBlock& mass_x, Block out) {
      out = values.cwiseQuotient(masses).asDiagonal() * mass_x;
    };
    problem.start = [this](int number, Eigen::Ref<Eigen::VectorXd> out) {
      for (Eigen::Index k = 0; k < share.count; ++k) out[k] = start_value(share.first + k, number);
    };
  }
  Diagonal(const Diagonal&) = delete;
  Diagonal& operator=(const Diagonal&) = delete;

  Share share;
  Eigen::VectorXd values, masses;
  solvers::eigen::LanczosProblem problem;
};

/// Values are the largest of `expected`; vectors are M-orthonormal eigenvectors.
testing::AssertionResult solves(const Diagonal& system, std::vector<double> expected,
                                const solvers::eigen::LanczosOptions& options,
                                const solvers::eigen::LanczosResult& result) {
  std::sort(expected.begin(), expected.end(), std::greater<>());
  if (result.values.size() < options.pairs) {
    return testing::AssertionFailure() << "only " << result.values.size() << " found";
  }
  for (Eigen::Index k = 0; k < result.values.size(); ++k) {
    const double exact = expected[static_cast<std::size_t>(k)];
    if (std::abs(result.values[k] - exact) > 1e-11 * expected.front() + 1e-10 * exact) {
      return testing::AssertionFailure()
             << "value " << k << " is " << result.values[k] << ", not " << exact;
    }
  }
  Eigen::MatrixXd gram = result.vectors.transpose() * system.masses.asDiagonal() * result.vectors;
  const Eigen::MatrixXd residual =
      system.values.asDiagonal() * result.vectors - result.vectors * result.values.asDiagonal();
  Eigen::MatrixXd squares = residual.colwise().squaredNorm();
  MPI_Allreduce(MPI_IN_PLACE, gram.data(), static_cast<int>(gram.size()), MPI_DOUBLE, MPI_SUM,
                system.problem.comm);
  MPI_Allreduce(MPI_IN_PLACE, squares.data(), static_cast<int>(squares.size()), MPI_DOUBLE, MPI_SUM,
                system.problem.comm);
  gram.diagonal().array() -= 1;
  if (gram.cwiseAbs().maxCoeff() > 1e-12) {
    return testing::AssertionFailure() << "not orthonormal by " << gram.cwiseAbs().maxCoeff();
  }
  for (Eigen::Index k = 0; k < squares.size(); ++k) {
    if (std::sqrt(squares(0, k)) > 1e-11 * (result.values[k] + 0.1 * expected.front())) {
      return testing::AssertionFailure() << "residual " << k << ": " << std::sqrt(squares(0, k));
    }
  }
  return testing::AssertionSuccess();
}

/// As shift-invert makes them: 1 / k.
std::vector<double> hyperbola(int count) {
  std::vector<double> out;
  for (int k = 1; k <= count; ++k) out.push_back(1.0 / k);
  return out;
}

TEST(BlockLanczos, FindsTheLargestInDescendingOrder) {
  const auto values = hyperbola(900);
  const Diagonal diagonal(values);
  for (const int pairs : {1, 7, 8, 9, 60}) {
    const solvers::eigen::LanczosOptions options{.pairs = pairs};
    EXPECT_TRUE(solves(diagonal, values, options,
                       solvers::eigen::block_lanczos(diagonal.problem, options)));
  }
}

TEST(BlockLanczos, RestartsInALittleRoom) {
  const auto values = hyperbola(700);
  const Diagonal diagonal(values);
  for (const int block : {1, 3, 8}) {
    const solvers::eigen::LanczosOptions options{
        .pairs = 40, .block = block, .basis = 40 + 3 * block};
    const auto result = solvers::eigen::block_lanczos(diagonal.problem, options);
    EXPECT_GT(result.restarts, 2);
    EXPECT_TRUE(solves(diagonal, values, options, result));
  }
}

TEST(BlockLanczos, SaysWhenRestartsDidNotSuffice) {
  const Diagonal diagonal(hyperbola(700));
  solvers::eigen::LanczosOptions options{.pairs = 60, .basis = 80};
  options.max_restarts = 1;
  const auto result = solvers::eigen::block_lanczos(diagonal.problem, options);
  EXPECT_EQ(result.restarts, 1);
  EXPECT_LT(result.values.size(), 60);
  EXPECT_EQ(result.vectors.cols(), result.values.size());
}

/// Each value as often as the block is wide: none may be missed by design of the block.
TEST(BlockLanczos, FindsEveryCopyOfRepeatedValues) {
  for (const int copies : {2, 3, 8}) {
    std::vector<double> values;
    for (const double v : hyperbola(100)) values.insert(values.end(), std::size_t(copies), v);
    const Diagonal diagonal(values);
    for (const int basis : {0, 10 * copies + 20}) {
      const solvers::eigen::LanczosOptions options{.pairs = 10 * copies, .basis = basis};
      EXPECT_TRUE(solves(diagonal, values, options,
                         solvers::eigen::block_lanczos(diagonal.problem, options)))
          << copies << " copies";
    }
  }
}

/// Rigid motions lie far above vibrations where the shift is far below the first mode. The
/// operator's rounding on them must not keep the vibrations from converging.
TEST(BlockLanczos, EndsAtTheRoundingOfTheLargest) {
  auto values = hyperbola(900);
  values.insert(values.begin(), 18, 1e5);
  const Diagonal diagonal(values);
  auto problem = diagonal.problem;
  int applied = 0;
  problem.apply = [&](const ConstBlock& mass_x, Block out) {
    diagonal.problem.apply(mass_x, out);
    for (Eigen::Index k = 0; k < out.size(); ++k) {
      out.data()[k] += 6e-18 * 1e5 * std::sin(1e3 * ++applied);
    }
  };
  solvers::eigen::LanczosOptions options;
  options.pairs = 42;
  const auto result = solvers::eigen::block_lanczos(problem, options);
  EXPECT_TRUE(solves(diagonal, values, options, result));
  EXPECT_LT(result.restarts, 20);
}

/// An operator of rank 11: after two blocks of 8 nothing new is left to find.
TEST(BlockLanczos, GoesOnWithFreshVectorsWhenABlockIsLost) {
  auto values = std::vector<double>(300, 0.0);
  for (int k = 0; k < 11; ++k) values[static_cast<std::size_t>(17 * k)] = 11 - k;
  const Diagonal diagonal(values);
  const solvers::eigen::LanczosOptions options{.pairs = 11};
  auto result = solvers::eigen::block_lanczos(diagonal.problem, options);
  ASSERT_GE(result.values.size(), 11);
  result.values.conservativeResize(11);
  result.vectors.conservativeResize(Eigen::NoChange, 11);
  EXPECT_TRUE(solves(diagonal, values, options, result));
}

TEST(BlockLanczos, TakesStartVectorsThatAreAlike) {
  const auto values = hyperbola(200);
  Diagonal diagonal(values);
  diagonal.problem.start = [&](int number, Eigen::Ref<Eigen::VectorXd> out) {
    for (Eigen::Index k = 0; k < out.size(); ++k) {
      out[k] = start_value(diagonal.share.first + k, number < 8 ? number / 4 : number);
    }
  };
  const solvers::eigen::LanczosOptions options{.pairs = 12};
  EXPECT_TRUE(
      solves(diagonal, values, options, solvers::eigen::block_lanczos(diagonal.problem, options)));
}

TEST(BlockLanczos, TakesProblemsSmallerThanItsBasis) {
  for (const int total : {1, 2, 5, 8, 13, 30}) {
    const auto values = hyperbola(total);
    const Diagonal diagonal(values);
    for (const int pairs : {1, total}) {
      const solvers::eigen::LanczosOptions options{.pairs = pairs};
      EXPECT_TRUE(solves(diagonal, values, options,
                         solvers::eigen::block_lanczos(diagonal.problem, options)))
          << pairs << " of " << total;
    }
  }
}

TEST(BlockLanczos, AgreesOnAnySpectrum) {
  EXPECT_TRUE(rc::check([] {
    // Distances between values from nothing to a decade, some repeated.
    const auto steps = *rc::gen::container<std::vector<int>>(60, rc::gen::inRange(0, 12));
    std::vector<double> values;
    double value = 1;
    for (const int step : steps) {
      value *= step < 4 ? 1 : std::pow(10, -0.02 * step);
      values.push_back(value);
    }
    for (int k = 0; k < 200; ++k) values.push_back(value / (2 + k));
    const int pairs = *rc::gen::inRange(1, 40);
    const solvers::eigen::LanczosOptions options{.pairs = pairs,
                                                 .block = *rc::gen::inRange(1, 10),
                                                 .basis = *rc::gen::element(0, pairs + 25)};
    const Diagonal diagonal(values, MPI_COMM_SELF);  // each rank tries cases of its own
    const auto result = solvers::eigen::block_lanczos(diagonal.problem, options);
    // Copies beyond the block's width are found in time but not for certain.
    std::vector<double> sorted = values;
    std::sort(sorted.begin(), sorted.end(), std::greater<>());
    int maximum = 1;
    for (std::size_t k = 1, copies = 1; k < sorted.size(); ++k) {
      copies = sorted[k] == sorted[k - 1] ? copies + 1 : 1;
      maximum = std::max(maximum, static_cast<int>(copies));
    }
    if (maximum <= options.block) RC_ASSERT(bool(solves(diagonal, values, options, result)));
  }));
}

/// Springs between neighbours of a grid: lambda = sum over axes of 2 - 2 cos(pi k / n), threefold
/// and sixfold for a cube. Shift-inverted with a sparse factor, each rank for itself.
TEST(BlockLanczos, FindsTheModesOfAGridOfSprings) {
  constexpr int side = 9, total = side * side * side;
  constexpr double shift = -0.01;
  std::vector<Eigen::Triplet<double>> entries;
  const auto at = [](int x, int y, int z) { return (x * side + y) * side + z; };
  const auto join = [&entries](int a, int b) {
    for (const auto& [i, j, v] : {std::tuple{a, a, 1.0}, {b, b, 1.0}, {a, b, -1.0}, {b, a, -1.0}}) {
      entries.emplace_back(i, j, v);
    }
  };
  std::vector<double> exact;
  for (int x = 0; x < side; ++x) {
    for (int y = 0; y < side; ++y) {
      for (int z = 0; z < side; ++z) {
        if (x + 1 < side) join(at(x, y, z), at(x + 1, y, z));
        if (y + 1 < side) join(at(x, y, z), at(x, y + 1, z));
        if (z + 1 < side) join(at(x, y, z), at(x, y, z + 1));
        double lambda = 0;
        for (const int k : {x, y, z}) lambda += 2 - 2 * std::cos(std::numbers::pi * k / side);
        exact.push_back(lambda);
      }
    }
  }
  std::sort(exact.begin(), exact.end());
  Eigen::SparseMatrix<double> matrix(total, total);
  matrix.setFromTriplets(entries.begin(), entries.end());
  for (int k = 0; k < total; ++k) matrix.coeffRef(k, k) -= shift;
  const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> factor(matrix);
  solvers::eigen::LanczosProblem problem;
  problem.owned = problem.total = total;
  problem.comm = MPI_COMM_SELF;
  problem.mass = [](const ConstBlock& x, Block out) { out = x; };
  problem.apply = [&factor](const ConstBlock& x, Block out) { out = factor.solve(x); };
  problem.start = [](int number, Eigen::Ref<Eigen::VectorXd> out) {
    for (Eigen::Index k = 0; k < out.size(); ++k) out[k] = start_value(k, number);
  };
  const auto result = solvers::eigen::block_lanczos(problem, {.pairs = 64});
  ASSERT_GE(result.values.size(), 64);
  for (Eigen::Index k = 0; k < 64; ++k) {
    EXPECT_NEAR(1 / result.values[k] + shift, exact[static_cast<std::size_t>(k)], 1e-11);
  }
}

}  // namespace
}  // namespace carillon
