#pragma once

#include <array>
#include <cstddef>

namespace carillon::solvers::mesh {

/// Corners of a tetrahedron's faces, counter-clockwise from outside when det(v1-v0, v2-v0, v3-v0)
/// is positive.
constexpr std::array<std::array<std::size_t, 3>, 4> outward_faces = {
    {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}}};

}  // namespace carillon::solvers::mesh
