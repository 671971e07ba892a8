#pragma once

#include <cstdint>
#include <functional>

#include "solvers/mesh/shape_source.hpp"

namespace carillon::solvers::mesh {

/// Number of tetrahedra that a family would make with cells of a size [m]; falls with the size.
using CountAtSize = std::function<std::int64_t(double)>;

/// How far a size that is left to the mesher may be coarsened or refined for an order.
struct SizeBudget {
  double cells_per_radian;  ///< size x bending wave number that the order resolves
  std::int64_t min, max;    ///< tetrahedra
};
SizeBudget size_budget(int order);

/// The cell that is wanted [m], before numbers of elements bound it: see cell_size().
double wanted_cell(const MeshOptions& options, double thickness);

/// Side of the cells [m] of a body with one thinnest direction.
///
/// With element_size given: the cells whose diagonal is that long. Otherwise the size resolves
/// bending waves in a wall of this thickness up to 20 kHz (wave speed 5 km/s, that of steel, glass
/// or aluminium), bounded on both sides by numbers of elements: at the lower bound the first modes
/// of a plate or bar are within about 20 cents at order 2 and 5 at order 3 (of a thin deep bowl 100
/// and 15), at the upper one a solve takes a few seconds.
/// @throws SolverError  more than options.max_elements; names the element_size that would fit
double cell_size(const MeshOptions& options, double thickness, double longest_side,
                 const CountAtSize& count);

/// Layers through a thickness: one through a wall, more where cells would stand on edge (or be
/// larger than a given element_size).
int layers_through(double thickness, double cell, const MeshOptions& options);

/// Cells along a length, at least one.
int cells_along(double length, double cell);

/// Throws the error of an element bound: what is needed, what is allowed, the size that would fit.
[[noreturn]] void fail_element_bound(std::int64_t needed, const MeshOptions& options,
                                     double fitting_size);

/// Largest angle that one element of a curved wall covers [rad].
constexpr double max_element_angle = 0.5235987755982988;  // 30 degrees

/// Longest chord along a radius of curvature: at most 30 degrees, and no more sagitta than a third
/// of the wall, so that the corners alone still make sound elements.
double max_chord(double radius, double wall);

}  // namespace carillon::solvers::mesh
