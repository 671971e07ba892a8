// What is claimed of eigenvalues that are not computed, against dense matrices whose eigenvalues
// are.
#include "solvers/basis/detail/poisson_bounds.hpp"

#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <cmath>
#include <random>

#include "solvers/dense/eigenpairs.hpp"
#include "solvers/elements/element.hpp"
#include "solvers/elements/lagrange.hpp"

namespace carillon {
namespace {

using namespace solvers;
using Eigen::MatrixXd;
using Eigen::VectorXd;

MatrixXd random_matrix(Eigen::Index rows, Eigen::Index cols, std::mt19937& random) {
  std::normal_distribution<double> normal;
  return MatrixXd::NullaryExpr(rows, cols, [&] { return normal(random); });
}

MatrixXd random_rotation(Eigen::Index n, std::mt19937& random) {
  return MatrixXd(Eigen::HouseholderQR<MatrixXd>(random_matrix(n, n, random)).householderQ());
}

std::mt19937 any_random() {
  return std::mt19937(*rc::gen::arbitrary<std::uint32_t>());
}

double ratio_between(double low, double high) {
  return low + (high - low) * *rc::gen::inRange(0, 10001) / 10000.0;
}

/// One tetrahedron's stiffness at unit modulus.
MatrixXd stiffness(double poisson_ratio) {
  solvers::elements::ElementKernel kernel(2);
  solvers::elements::Coordinates nodes(3, kernel.nodes());
  const auto& lattice = solvers::elements::tetrahedron_lattice(2);
  for (Eigen::Index n = 0; n < kernel.nodes(); ++n) {
    const auto& at = lattice[static_cast<std::size_t>(n)];
    nodes.col(n) << at[1] / 2.0, at[2] / 2.0, at[3] / 1.7;
  }
  EXPECT_GT(kernel.place(nodes), 0);
  MatrixXd k;
  kernel.stiffness(solvers::elements::isotropic_constants(1, poisson_ratio, 1), k);
  return k;
}

TEST(PoissonBounds, StiffnessNowhereFallsBelowItsRatio) {
  EXPECT_TRUE(rc::check([] {
    const double from = ratio_between(-0.95, 0.495), to = ratio_between(-0.95, 0.495);
    const double ratio = solvers::basis::stiffness_ratio(from, to);
    const MatrixXd difference = stiffness(to) - ratio * stiffness(from);
    const auto values = solvers::dense::symmetric_eigenvalues(difference);
    RC_ASSERT(values[0] >= -1e-13 * stiffness(to).norm());
    // And no larger factor would do: some strain is pure shear, some nearly pure volume.
    RC_ASSERT(ratio <= 1);
  }));
}

TEST(PoissonBounds, TheRatioIsSharpForShear) {
  // Pure shear carries no volume change: its energy is in proportion to 1 / (1 + nu).
  const auto shear = [](double ratio) {
    solvers::elements::ElementKernel kernel(1);
    solvers::elements::Coordinates nodes(3, 4);
    nodes << 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1;
    kernel.place(nodes);
    MatrixXd k;
    kernel.stiffness(solvers::elements::isotropic_constants(1, ratio, 1), k);
    VectorXd u = VectorXd::Zero(12);
    for (Eigen::Index n = 0; n < 4; ++n) u[3 * n] = nodes(1, n);
    return u.dot(k * u);
  };
  EXPECT_NEAR(shear(0.4) / shear(0.1), solvers::basis::stiffness_ratio(0.1, 0.4), 1e-14);
}

TEST(PoissonBounds, NeighboursCombineToWhatLiesBetween) {
  EXPECT_TRUE(rc::check([] {
    const std::vector<double> ratios = {0.1, 0.3, 0.44};
    const double to = ratio_between(-0.5, 0.495);
    const auto weights = solvers::basis::stiffness_weights(ratios, to);
    MatrixXd difference = stiffness(to);
    const double scale = difference.norm();
    for (std::size_t i = 0; i < ratios.size(); ++i) {
      RC_ASSERT(weights[i] >= 0);
      difference -= weights[i] * stiffness(ratios[i]);
    }
    RC_ASSERT(solvers::dense::symmetric_eigenvalues(difference)[0] > -1e-12 * scale);
    if (to >= 0.1 && to < 0.44) RC_ASSERT(difference.norm() < 1e-12 * scale);
  }));
}

TEST(PoissonBounds, ComplementOfASumIsNeverSofterThanItsBound) {
  EXPECT_TRUE(rc::check([] {
    auto random = any_random();
    const Eigen::Index n = 24;
    const int trials = *rc::gen::inRange(0, 12);
    MatrixXd k = MatrixXd::Zero(n, n);
    std::vector<solvers::basis::KnownSpectrum> known;
    for (const double weight : {0.3, 0.6}) {
      VectorXd spectrum = (VectorXd::Random(n).array() + 1.01) * 10;
      std::sort(spectrum.begin(), spectrum.end());
      const auto axes = random_rotation(n, random);
      k += weight * axes * spectrum.asDiagonal() * axes.transpose();
      const int count = *rc::gen::inRange(0, 16);
      known.push_back({weight, spectrum.head(count), spectrum[count], axes.leftCols(count)});
    }
    const MatrixXd all = random_rotation(n, random);
    const MatrixXd rest = all.rightCols(n - trials);
    const double truth = solvers::dense::symmetric_eigenvalues(rest.transpose() * k * rest)[0];
    RC_ASSERT(solvers::basis::complement_bound(known, all.leftCols(trials)) <= truth * (1 + 1e-10));
  }));
}

TEST(PoissonBounds, ComplementIsNeverSofterThanItsBound) {
  EXPECT_TRUE(rc::check([] {
    auto random = any_random();
    const Eigen::Index n = 30;
    const int known = *rc::gen::inRange(0, 20), trials = *rc::gen::inRange(0, 20);
    VectorXd spectrum = (VectorXd::Random(n).array() + 1.01) * 10;
    std::sort(spectrum.begin(), spectrum.end());
    const auto axes = random_rotation(n, random);
    const MatrixXd k = axes * spectrum.asDiagonal() * axes.transpose();
    // Trial vectors near the lowest eigenvectors, more or less.
    const double away = std::pow(10.0, -*rc::gen::inRange(0, 4));
    const MatrixXd y = MatrixXd(Eigen::HouseholderQR<MatrixXd>(
                                    axes.leftCols(trials) + away * random_matrix(n, trials, random))
                                    .householderQ());
    const MatrixXd rest = y.rightCols(n - trials);
    const double truth = solvers::dense::symmetric_eigenvalues(rest.transpose() * k * rest)[0];
    const double complete_below = known < n ? spectrum[known] : spectrum[n - 1];
    const double bound = solvers::basis::complement_bound(
        std::vector<solvers::basis::KnownSpectrum>{
            {1, spectrum.head(known), complete_below, axes.leftCols(known)}},
        y.leftCols(trials));
    RC_ASSERT(bound <= truth * (1 + 1e-10));
    if (trials >= known && away < 1e-3) RC_ASSERT(bound > 0.99 * complete_below);
  }));
}

TEST(PoissonBounds, EigenvaluesLieBetweenTheBoundsAndTheRitzValues) {
  EXPECT_TRUE(rc::check([] {
    auto random = any_random();
    const Eigen::Index n = 40, trials = 12;
    VectorXd spectrum = (VectorXd::Random(n).array() + 1.01) * 10;
    std::sort(spectrum.begin(), spectrum.end());
    const auto axes = random_rotation(n, random);
    const MatrixXd k = axes * spectrum.asDiagonal() * axes.transpose();
    const double away = std::pow(10.0, -*rc::gen::inRange(1, 5));
    const MatrixXd q = Eigen::HouseholderQR<MatrixXd>(axes.leftCols(trials) +
                                                      away * random_matrix(n, trials, random))
                           .householderQ();
    MatrixXd turned = q.leftCols(trials).transpose() * k * q.leftCols(trials);
    const auto ritz = solvers::dense::symmetric_eigenpairs(turned);
    const MatrixXd y = q.leftCols(trials) * turned;
    const MatrixXd rest = q.rightCols(n - trials);
    const double ceiling = solvers::dense::symmetric_eigenvalues(rest.transpose() * k * rest)[0];
    const MatrixXd residuals = k * y - y * ritz.asDiagonal();
    const MatrixXd gram = residuals.transpose() * k.inverse() * residuals;
    const auto bounds = solvers::basis::bound_ritz_values(ritz, gram, ceiling, 1e-4);
    for (Eigen::Index i = 0; i < trials; ++i) {
      RC_ASSERT(spectrum[i] <= ritz[i] * (1 + 1e-10));
      RC_ASSERT(bounds.lower[i] <= spectrum[i] * (1 + 1e-10));
    }
    RC_ASSERT(bounds.counted_below <= ceiling);
    const auto below = [&](const auto& values, double at) { return (values.array() < at).count(); };
    // But for values within the tightness of where the count ends.
    const double at = bounds.counted_below * (1 - 2e-4);
    RC_ASSERT(below(spectrum, at) >= below(ritz, at));
    RC_ASSERT(below(spectrum, at) <= below(ritz, bounds.counted_below));
    if (away < 1e-3) RC_ASSERT(bounds.counted_below > 0.5 * ceiling);
  }));
}

TEST(PoissonBounds, ANarrowTrialSpaceIsSeenToLackModes) {
  // The third eigenvector is left out: no count may go beyond it, whatever the residuals.
  const VectorXd spectrum = (VectorXd(5) << 1, 2, 3, 4, 5).finished();
  const MatrixXd axes = MatrixXd::Identity(5, 5);
  MatrixXd trials(5, 3);
  trials << axes.col(0), axes.col(1), axes.col(3);
  const double bound = solvers::basis::complement_bound(
      std::vector<solvers::basis::KnownSpectrum>{{1, spectrum.head(4), 5, axes.leftCols(4)}},
      trials);
  EXPECT_NEAR(bound, 3, 1e-14);
  const auto bounds = solvers::basis::bound_ritz_values((VectorXd(3) << 1, 2, 4).finished(),
                                                        MatrixXd::Zero(3, 3), bound, 1e-4);
  EXPECT_LE(bounds.counted_below, 3);
  EXPECT_GT(bounds.counted_below, 2);
}

}  // namespace
}  // namespace carillon
