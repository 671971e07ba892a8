#pragma once

#include "scene/solved_object.hpp"

namespace carillon::scene {

/// solve_object() for a generated body of revolution by the axisymmetric solver, on rank 0: no
/// tetrahedra are made (Object::mesh keeps a region's name alone) and nothing is cached, as a solve
/// takes about a second. `element_size` bounds the cells of the section.
/// @throws InputError  a file, or a family that is not turned about an axis
/// @note Collective on comm.
SolvedObject solve_turned(const ObjectRequest& request, MPI_Comm comm);

}  // namespace carillon::scene
