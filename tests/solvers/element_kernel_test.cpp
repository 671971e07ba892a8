#include <fmt/core.h>
#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <cmath>
#include <random>

#include "solvers/elements/element.hpp"
#include "solvers/elements/lagrange.hpp"
#include "solvers/elements/quadrature.hpp"

namespace carillon {
namespace {

using namespace solvers;

double factorial(int n) {
  return n < 2 ? 1 : n * factorial(n - 1);
}

/// Nodes of an element on four corners; `bend` moves the others by that share of its size.
solvers::elements::Coordinates element_on(const Eigen::Matrix<double, 3, 4>& corners, int order,
                                          double bend, unsigned seed) {
  const auto& lattice = solvers::elements::tetrahedron_lattice(order);
  solvers::elements::Coordinates nodes(3, static_cast<Eigen::Index>(lattice.size()));
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> move(-bend, bend);
  for (std::size_t n = 0; n < lattice.size(); ++n) {
    Eigen::Vector3d x = Eigen::Vector3d::Zero();
    for (std::size_t v = 0; v < 4; ++v) {
      x += lattice[n][v] * corners.col(static_cast<Eigen::Index>(v)) / order;
    }
    if (n >= 4) x += Eigen::Vector3d(move(random), move(random), move(random));
    nodes.col(static_cast<Eigen::Index>(n)) = x;
  }
  return nodes;
}

Eigen::Matrix<double, 3, 4> some_corners() {
  Eigen::Matrix<double, 3, 4> corners;
  corners << 0.1, 1.2, 0.3, 0.2,  //
      0.0, 0.1, 0.9, 0.3,         //
      0.2, 0.1, 0.0, 1.1;
  return corners;
}

double volume_by_fine_rule(const solvers::elements::Coordinates& nodes, int order) {
  double volume = 0;
  const auto& rule = solvers::elements::tetrahedron_rule(10);
  for (std::size_t q = 0; q < rule.size(); ++q) {
    Eigen::Matrix<double, Eigen::Dynamic, 4> slope;
    solvers::elements::tetrahedron_shape_functions(order, rule.barycentric[q], &slope);
    const Eigen::Matrix3d jacobian = nodes * (slope.rightCols<3>().colwise() - slope.col(0));
    volume += rule.weights[q] * jacobian.determinant();
  }
  return volume;
}

/// x, y, z node by node of a displacement field at the nodes.
template <class Field>
Eigen::VectorXd nodal(const solvers::elements::Coordinates& nodes, Field&& field) {
  Eigen::VectorXd u(3 * nodes.cols());
  for (Eigen::Index n = 0; n < nodes.cols(); ++n) {
    u.segment<3>(3 * n) = field(Eigen::Vector3d(nodes.col(n)));
  }
  return u;
}

struct Case {
  int order;
  bool curved;
};

class Kernel : public testing::TestWithParam<Case> {
 protected:
  solvers::elements::Coordinates nodes() const {
    const auto [order, curved] = GetParam();
    return element_on(some_corners(), order, curved ? 0.03 : 0, 7);
  }
  solvers::elements::ElasticConstants material =
      solvers::elements::isotropic_constants(2.5, 0.3, 1.7);
};
INSTANTIATE_TEST_SUITE_P(Orders, Kernel,
                         testing::Values(Case{1, false}, Case{2, false}, Case{3, false},
                                         Case{4, false}, Case{2, true}, Case{3, true},
                                         Case{4, true}),
                         [](const auto& test) {
                           return fmt::format("P{}{}", test.param.order,
                                              test.param.curved ? "Curved" : "Straight");
                         });

TEST_P(Kernel, RigidMotionsHaveNoEnergyAndStiffnessIsSymmetric) {
  solvers::elements::ElementKernel kernel(GetParam().order);
  const auto x = nodes();
  ASSERT_GT(kernel.place(x), 0);
  Eigen::MatrixXd k;
  kernel.stiffness(material, k);
  EXPECT_EQ((k - k.transpose()).cwiseAbs().maxCoeff(), 0);
  for (int axis = 0; axis < 3; ++axis) {
    const Eigen::Vector3d e = Eigen::Vector3d::Unit(axis);
    const Eigen::VectorXd shift = nodal(x, [&](const Eigen::Vector3d&) { return e; });
    const Eigen::VectorXd turn =
        nodal(x, [&](const Eigen::Vector3d& p) { return e.cross(p).eval(); });
    EXPECT_LT((k * shift).cwiseAbs().maxCoeff(), 1e-13 * k.cwiseAbs().maxCoeff());
    EXPECT_LT((k * turn).cwiseAbs().maxCoeff(), 1e-13 * k.cwiseAbs().maxCoeff());
  }
  // And nothing else has none: six zero eigenvalues, the next far away.
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(k);
  EXPECT_LT(solver.eigenvalues()[5], 1e-13 * solver.eigenvalues().maxCoeff());
  EXPECT_GT(solver.eigenvalues()[6], 1e-5 * solver.eigenvalues().maxCoeff());
}

/// Patch test: an isoparametric element holds every linear field, so its strain energy is
/// volume x (lambda tr^2 + 2 mu eps : eps) exactly, curved or not.
TEST_P(Kernel, LinearDisplacementHasItsExactEnergy) {
  const auto x = nodes();
  const double volume = volume_by_fine_rule(x, GetParam().order);
  EXPECT_TRUE(rc::check([&] {
    solvers::elements::ElementKernel kernel(GetParam().order);
    RC_ASSERT(kernel.place(x) > 0);
    Eigen::Matrix3d g;
    for (int i = 0; i < 9; ++i) g(i / 3, i % 3) = *rc::gen::inRange(-100, 101) * 0.01;
    const Eigen::VectorXd u = nodal(x, [&](const Eigen::Vector3d& p) { return (g * p).eval(); });
    Eigen::MatrixXd k;
    kernel.stiffness(material, k);
    const Eigen::Matrix3d strain = (g + g.transpose()) / 2;
    const double exact = volume * (material.lambda * strain.trace() * strain.trace() +
                                   2 * material.mu * strain.squaredNorm());
    RC_ASSERT(std::abs(u.dot(k * u) - exact) < 1e-12 * (1 + exact));
  }));
}

TEST_P(Kernel, MassIsThatOfTheVolumeAndPositive) {
  solvers::elements::ElementKernel kernel(GetParam().order);
  const auto x = nodes();
  kernel.place(x);
  Eigen::MatrixXd m;
  kernel.mass(material.density, m);
  EXPECT_NEAR(m.sum(), material.density * volume_by_fine_rule(x, GetParam().order), 1e-14);
  EXPECT_GT(Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(m).eigenvalues()[0], 0);
}

TEST_P(Kernel, EnergiesFromStrainsAreThoseOfTheMatrices) {
  solvers::elements::ElementKernel kernel(GetParam().order);
  const auto x = nodes();
  kernel.place(x);
  Eigen::MatrixXd k, m;
  kernel.stiffness(material, k);
  kernel.mass(material.density, m);
  const Eigen::MatrixXd u = Eigen::MatrixXd::Random(x.cols(), 3 * 4);
  Eigen::ArrayXd strain = Eigen::ArrayXd::Zero(4), kinetic = strain;
  kernel.add_energies(material, u, strain, kinetic);
  for (Eigen::Index f = 0; f < 4; ++f) {
    Eigen::VectorXd v(3 * x.cols());
    double mass_energy = 0;
    for (Eigen::Index c = 0; c < 3; ++c) {
      mass_energy += u.col(3 * f + c).dot(m * u.col(3 * f + c));
      for (Eigen::Index n = 0; n < x.cols(); ++n) v[3 * n + c] = u(n, 3 * f + c);
    }
    EXPECT_NEAR(strain[f] / v.dot(k * v), 1, 1e-12);
    EXPECT_NEAR(kinetic[f] / mass_energy, 1, 1e-12);
  }
}

/// On the reference tetrahedron the integral of x^i y^j z^k is i! j! k! / (i + j + k + 3)!.
TEST(Mass, OfPolynomialFieldsHasItsClosedForm) {
  Eigen::Matrix<double, 3, 4> corners;
  corners << 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1;
  for (int order = 1; order <= 4; ++order) {
    solvers::elements::ElementKernel kernel(order);
    const auto x = element_on(corners, order, 0, 0);
    kernel.place(x);
    Eigen::MatrixXd m;
    kernel.mass(1, m);
    for (int i = 0; i <= order; ++i)
      for (int j = 0; i + j <= order; ++j) {
        const int k = order - i - j;
        Eigen::VectorXd u(x.cols());
        for (Eigen::Index n = 0; n < x.cols(); ++n) {
          u[n] = std::pow(x(0, n), i) * std::pow(x(1, n), j) * std::pow(x(2, n), k);
        }
        const double exact =
            factorial(2 * i) * factorial(2 * j) * factorial(2 * k) / factorial(2 * order + 3);
        EXPECT_NEAR(u.dot(m * u) / exact, 1, 1e-12) << order << i << j;
      }
  }
}

/// Four-node stiffness by the textbook's constant gradients, written out independently.
TEST(Stiffness, OfFourNodesIsTheTextbookMatrix) {
  const auto corners = some_corners();
  solvers::elements::ElementKernel kernel(1);
  kernel.place(corners);
  const double youngs = 2.5, nu = 0.3;
  Eigen::MatrixXd k;
  kernel.stiffness(solvers::elements::isotropic_constants(youngs, nu, 1), k);
  Eigen::Matrix4d affine;
  affine << Eigen::RowVector4d::Ones(), corners;
  const Eigen::Matrix4d inverse = affine.inverse();  // row a: 1, x, y, z coefficients of N_a
  const double volume = affine.determinant() / 6;
  Eigen::Matrix<double, 6, 12> b = Eigen::Matrix<double, 6, 12>::Zero();
  for (int a = 0; a < 4; ++a) {
    const double dx = inverse(a, 1), dy = inverse(a, 2), dz = inverse(a, 3);
    b.middleCols<3>(3 * a) << dx, 0, 0, 0, dy, 0, 0, 0, dz, dy, dx, 0, 0, dz, dy, dz, 0, dx;
  }
  Eigen::Matrix<double, 6, 6> d = Eigen::Matrix<double, 6, 6>::Zero();
  d.topLeftCorner<3, 3>().setConstant(nu);
  d.topLeftCorner<3, 3>().diagonal().setConstant(1 - nu);
  d.bottomRightCorner<3, 3>().diagonal().setConstant((1 - 2 * nu) / 2);
  d *= youngs / ((1 + nu) * (1 - 2 * nu));
  const Eigen::MatrixXd expected = volume * b.transpose() * d * b;
  EXPECT_LT((k - expected).cwiseAbs().maxCoeff(), 1e-13 * expected.cwiseAbs().maxCoeff());
}

TEST(Place, SeesAnElementTurnedInsideOut) {
  auto corners = some_corners();
  corners.col(2).swap(corners.col(3));
  for (int order = 1; order <= 4; ++order) {
    solvers::elements::ElementKernel kernel(order);
    EXPECT_LT(kernel.place(element_on(corners, order, 0, 0)), 0);
  }
  // A midside node pulled past the quarter point folds the element at its corner.
  solvers::elements::ElementKernel kernel(2);
  auto nodes = element_on(some_corners(), 2, 0, 0);
  nodes.col(4) = 0.8 * nodes.col(0) + 0.2 * nodes.col(1);
  EXPECT_LT(kernel.place(nodes), 0);
}

}  // namespace
}  // namespace carillon
