#pragma once

#include <string>
#include <vector>

#include "solvers/mesh/shape_source.hpp"

namespace carillon::solvers::mesh {

/// A unit that a file may have been meant in, as a question; "" for a body of a usual size: up to
/// 2 m and a tonne.
/// @param file     whose size is said (`length`, `unit`) or let pass is not asked about
/// @param longest  side [m]
/// @param mass     [kg]; 0 where it is not known
std::string unit_question(const MeshFile& file, double longest, double mass);

/// What a person should know before they use the mesh of a file: a repair that changed the volume
/// by more than a hundredth, inner surfaces that look outward, a size that asks for a unit,
/// elements that follow the surface by less than a fiftieth.
/// @param mass  of the body [kg]
std::vector<std::string> mesh_warnings(const MeshFile& file, const MeshResult& mesh, double mass);

}  // namespace carillon::solvers::mesh
