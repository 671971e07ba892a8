#include "solvers/elements/elastic.hpp"

#include <fmt/core.h>

#include <Eigen/Eigenvalues>
#include <cmath>

#include "core/error.hpp"

namespace carillon::solvers::elements {

bool same_law(const Elastic& a, const Elastic& b) {
  constexpr double rounding = 1e-12;
  if (a.anisotropy.has_value() != b.anisotropy.has_value()) return false;
  if (a.anisotropy)
    return (*a.anisotropy - *b.anisotropy).norm() <= rounding * b.anisotropy->norm();
  return std::abs(a.poisson_ratio - b.poisson_ratio) <= rounding * std::abs(b.poisson_ratio);
}

std::vector<double> identity_of(const Elastic& m) {
  std::vector<double> numbers = {m.youngs_modulus, m.poisson_ratio, m.density};
  if (m.anisotropy)
    numbers.insert(numbers.end(), m.anisotropy->data(),
                   m.anisotropy->data() + m.anisotropy->size());
  return numbers;
}

std::optional<core::Fault> elastic_fault(const Elastic& m) {
  if (m.anisotropy) {
    // Below rounding of the largest nothing is known.
    constexpr double minimum = 1e-9;
    const Eigen::SelfAdjointEigenSolver<Voigt> solver(*m.anisotropy, Eigen::EigenvaluesOnly);
    const auto& values = solver.eigenvalues();
    if (!m.anisotropy->allFinite() || !(values[0] > minimum * values[5])) {
      const double ratio = values[0] / values[5];
      return core::Fault{
          "stiffness",
          "the stiffness must be positive definite: every strain costs energy" +
              (std::isfinite(ratio)
                   ? fmt::format("; its smallest eigenvalue over the largest is {:.3g}", ratio)
                   : std::string("; it is not finite or zero")),
          "of engineering constants: moduli are positive, nu12^2 < E1 / E2, nu13^2 < E1 / E3, "
          "nu23^2 < E2 / E3, and the three are not large at once; of cubic ones: C44 > 0, "
          "C11 > |C12|, C11 + 2 C12 > 0"};
    }
  }
  if (!(m.youngs_modulus > 0) || !std::isfinite(m.youngs_modulus)) {
    return core::Fault{"youngs_modulus",
                       fmt::format("Young's modulus must be positive, not {} Pa", m.youngs_modulus),
                       ""};
  }
  if (!(m.poisson_ratio > -1 && m.poisson_ratio < 0.5)) {
    return core::Fault{
        "poisson_ratio",
        fmt::format("Poisson's ratio must lie between -1 and 0.5, both excluded, not {}",
                    m.poisson_ratio),
        m.poisson_ratio == 0.5
            ? "an incompressible solid has no finite bulk modulus; 0.49 is rubber"
            : ""};
  }
  if (!(m.density > 0) || !std::isfinite(m.density)) {
    return core::Fault{"density", fmt::format("density must be positive, not {} kg/m^3", m.density),
                       ""};
  }
  return {};
}

void check_elastic(const Elastic& m) {
  if (const auto fault = elastic_fault(m)) throw core::InputError(fault->message, fault->hint);
}

}  // namespace carillon::solvers::elements
