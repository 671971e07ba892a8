#include "solvers/elements/elastic.hpp"

#include <fmt/core.h>

#include <cmath>

#include "core/error.hpp"

namespace carillon::solvers::elements {

std::optional<core::Fault> elastic_fault(const Elastic& m) {
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
