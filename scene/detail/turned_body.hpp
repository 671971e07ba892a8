#pragma once

#include "scene/body.hpp"

namespace carillon::scene {

/// solve_body() for a generated body of revolution by the axisymmetric solver, on rank 0: no
/// tetrahedra are made (Body::mesh keeps a region's name alone) and nothing is cached, as a solve
/// takes about a second. `element_size` bounds the cells of the section.
/// @throws InputError  a file, or a family that is not turned about an axis
/// @note Collective on comm.
Body solve_turned(const BodyRequest& request, MPI_Comm comm);

}  // namespace carillon::scene
