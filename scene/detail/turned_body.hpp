#pragma once

#include "scene/body.hpp"

namespace carillon::scene {

/// solve_body() for a generated body of revolution by the Fourier solver, on rank 0: no tetrahedra
/// are made (Body::mesh keeps a region's name alone) and nothing is cached, as a solve takes about
/// a second. `element_size` bounds the cells of the section.
/// @throws InputError  a file, a family that is not turned about an axis, or an option of
/// tetrahedra
/// @note Collective on the context's world.
Body solve_turned(const BodyOptions& options, const mpi::Context& context);

}  // namespace carillon::scene
