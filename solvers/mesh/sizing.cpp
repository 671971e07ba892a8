#include "solvers/mesh/sizing.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "core/error.hpp"

namespace carillon::solvers::mesh {
namespace {

/// Sizes next to each other around the one where `count` passes `goal`: the first makes more, the
/// second at most as many.
std::pair<double, double> sizes_around(std::int64_t goal, double low, double high,
                                       const CountAtSize& count) {
  for (int i = 0; i < 60 && high / low > 1.0005; ++i) {
    const double middle = std::sqrt(low * high);
    (count(middle) > goal ? low : high) = middle;
  }
  return {low, high};
}

double bending_wave_number_20khz(double thickness) {
  constexpr double omega = 2 * std::numbers::pi * 20000, wave_speed = 5000;
  return std::sqrt(std::sqrt(12.0) * omega / (wave_speed * thickness));
}

/// Three digits, rounded up so that the figure still fits.
double round_up(double value) {
  const double digit = std::pow(10, std::floor(std::log10(value)) - 2);
  return std::ceil(value / digit * (1 + 1e-9)) * digit;
}

/// Cell whose longest edge, its diagonal through the layer, is `edge`.
double cell_with_edge(double edge, double thickness) {
  if (thickness >= edge / std::numbers::sqrt3) return edge / std::numbers::sqrt3;
  return std::sqrt((edge * edge - thickness * thickness) / 2);
}

}  // namespace

SizeBudget size_budget(int order) {
  switch (order) {
    case 1:
      return {0.35, 4000, 20000};
    case 2:
      return {0.7, 2400, 5000};
    case 3:
      return {1.4, 900, 1700};
    default:
      return {2.4, 300, 700};
  }
}

double wanted_cell(const MeshOptions& options, double thickness) {
  if (options.element_size > 0) return cell_with_edge(options.element_size, thickness);
  return size_budget(options.order).cells_per_radian / bending_wave_number_20khz(thickness);
}

double cell_size(const MeshOptions& options, double thickness, double longest_side,
                 const CountAtSize& count) {
  const double tiny = 1e-4 * longest_side, huge = 2 * longest_side;
  double cell = wanted_cell(options, thickness);
  if (!(options.element_size > 0)) {
    const SizeBudget budget = size_budget(options.order);
    if (cell > huge) cell = huge;
    if (cell < tiny || count(cell) > budget.max)
      cell = sizes_around(budget.max, tiny, huge, count).second;
    else if (count(cell) < budget.min)
      cell = sizes_around(budget.min, tiny, cell, count).first;
  }
  // A size far below the body's would overflow the count of a grid.
  const double safe = std::max(cell, tiny);
  const std::int64_t needed = count(safe);
  if (needed > options.max_elements || cell < tiny) {
    const double fitting = sizes_around(options.max_elements, tiny, huge, count).second;
    const bool fits = count(fitting) <= options.max_elements;
    const double through = std::min(thickness, fitting);
    fail_element_bound(needed, options,
                       fits ? std::sqrt(2 * fitting * fitting + through * through) : 0);
  }
  return cell;
}

int layers_through(double thickness, double cell, const MeshOptions& options) {
  if (options.element_size > 0) return cells_along(thickness, cell);
  return std::max(1, static_cast<int>(std::lround(thickness / (1.3 * cell))));
}

int cells_along(double length, double cell) {
  return std::max(1, static_cast<int>(std::ceil(length / cell * (1 - 1e-9))));
}

void fail_element_bound(std::int64_t needed, const MeshOptions& options, double fitting_size) {
  const std::string message = fmt::format("the mesh needs about {} elements and max_elements is {}",
                                          needed, options.max_elements);
  if (fitting_size > 0)
    throw core::LimitError(message,
                           fmt::format("element_size {:.3g} m would fit", round_up(fitting_size)));
  throw core::LimitError(message, "no element_size of this shape needs so few");
}

double max_chord(double radius, double wall) {
  return std::min(max_element_angle * radius, std::sqrt(8 * radius * 0.35 * wall));
}

}  // namespace carillon::solvers::mesh
