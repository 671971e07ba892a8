#pragma once

#include <span>
#include <string>
#include <string_view>

#include "solvers/elements/elastic.hpp"
#include "solvers/mesh/shape_source.hpp"

namespace carillon::scene {

/// What the modes of an object are found with.
enum class ObjectSolver {
  automatic,    ///< the axisymmetric solver where decide_solver() finds that it can
  tetrahedra,   ///< any object: eigen::solve_modes()
  axisymmetric  ///< generated bodies of revolution: axisymmetric::solve_axisymmetric()
};

/// "automatic", "tetrahedra" or "axisymmetric".
std::string_view name_of(ObjectSolver solver);
/// @param name  as name_of() gives it
/// @throws InputError  no such name
ObjectSolver parse_object_solver(std::string_view name);

/// What was asked for of an object's solver.
struct SolverRequest {
  ObjectSolver solver = ObjectSolver::automatic;
  std::string reason = "asked for";  ///< why, where it is not automatic
};

/// The solver of an object, and why.
struct SolverDecision {
  ObjectSolver solver = ObjectSolver::tetrahedra;  ///< never automatic
  std::string reason;
};

/// What is asked for; of automatic, the axisymmetric solver for generated bodies of revolution of
/// isotropic materials, and tetrahedra for all else.
/// @param materials  of all its regions, in every variant
/// @throws InputError  the axisymmetric solver is asked for, and cannot take the object
SolverDecision decide_solver(const SolverRequest& asked, const solvers::mesh::MeshRequest& request,
                             std::span<const solvers::elements::Elastic> materials);

}  // namespace carillon::scene
