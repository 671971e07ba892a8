#include "solvers/elements/anisotropy.hpp"

#include <Eigen/LU>
#include <cstddef>
#include <utility>

namespace carillon::solvers::elements {
namespace {

/// Axes of each of Voigt's six places.
constexpr std::array<std::pair<int, int>, 6> places = {
    {{0, 0}, {1, 1}, {2, 2}, {1, 2}, {0, 2}, {0, 1}}};

}  // namespace

Voigt orthotropic_stiffness(const EngineeringConstants& constants) {
  const auto& e = constants.youngs_moduli;
  const auto& [nu23, nu13, nu12] = constants.poisson_ratios;
  Voigt compliance = Voigt::Zero();
  for (Eigen::Index i = 0; i < 3; ++i) {
    compliance(i, i) = 1 / e[static_cast<std::size_t>(i)];
    compliance(3 + i, 3 + i) = 1 / constants.shear_moduli[static_cast<std::size_t>(i)];
  }
  compliance(0, 1) = compliance(1, 0) = -nu12 / e[0];
  compliance(0, 2) = compliance(2, 0) = -nu13 / e[0];
  compliance(1, 2) = compliance(2, 1) = -nu23 / e[1];
  const Voigt stiffness = compliance.inverse();
  return (stiffness + stiffness.transpose()) / 2;
}

Voigt hexagonal_stiffness(double c11, double c12, double c13, double c33, double c44) {
  Voigt c = Voigt::Zero();
  c.topLeftCorner<3, 3>() << c11, c12, c13, c12, c11, c13, c13, c13, c33;
  c.diagonal().tail<3>() << c44, c44, (c11 - c12) / 2;
  return c;
}

Voigt cubic_stiffness(double c11, double c12, double c44) {
  Voigt c = hexagonal_stiffness(c11, c12, c12, c11, c44);
  c(5, 5) = c44;
  return c;
}

Voigt isotropic_stiffness(double youngs_modulus, double poisson_ratio) {
  const double mu = youngs_modulus / (2 * (1 + poisson_ratio));
  const double lambda = 2 * mu * poisson_ratio / (1 - 2 * poisson_ratio);
  return cubic_stiffness(lambda + 2 * mu, lambda, mu);
}

Elastic anisotropic(const Voigt& stiffness, double density) {
  const Voigt compliance = stiffness.inverse();
  const auto sums = [](const Voigt& m) {
    const double pairs = m(0, 1) + m(0, 2) + m(1, 2);
    return std::array{m(0, 0) + m(1, 1) + m(2, 2), pairs, m(3, 3) + m(4, 4) + m(5, 5)};
  };
  const auto [c_long, c_pairs, c_shear] = sums(stiffness);
  const auto [s_long, s_pairs, s_shear] = sums(compliance);
  const double bulk = ((c_long + 2 * c_pairs) / 9 + 1 / (s_long + 2 * s_pairs)) / 2;
  const double shear =
      ((c_long - c_pairs + 3 * c_shear) / 15 + 15 / (4 * s_long - 4 * s_pairs + 3 * s_shear)) / 2;
  Elastic solid;
  solid.youngs_modulus = 9 * bulk * shear / (3 * bulk + shear);
  solid.poisson_ratio = (3 * bulk - 2 * shear) / (2 * (3 * bulk + shear));
  solid.density = density;
  solid.anisotropy = stiffness / solid.youngs_modulus;
  return solid;
}

Voigt rotated(const Voigt& stiffness, const Eigen::Matrix3d& axes) {
  // Strain in the solid's axes from strain in the new ones: e' = R^T e R, shears doubled.
  Voigt to_own;
  for (std::size_t row = 0; row < 6; ++row) {
    const auto [i, j] = places[row];
    for (std::size_t column = 0; column < 6; ++column) {
      const auto [k, l] = places[column];
      double entry = axes(k, i) * axes(l, j);
      if (k != l) entry = (entry + axes(l, i) * axes(k, j)) / 2;
      to_own(static_cast<Eigen::Index>(row), static_cast<Eigen::Index>(column)) =
          (i == j ? 1 : 2) * entry;
    }
  }
  const Voigt turned = to_own.transpose() * stiffness * to_own;
  return (turned + turned.transpose()) / 2;
}

Elastic rotated(const Elastic& solid, const Eigen::Matrix3d& axes) {
  Elastic turned = solid;
  if (solid.anisotropy) turned.anisotropy = rotated(*solid.anisotropy, axes);
  return turned;
}

}  // namespace carillon::solvers::elements
