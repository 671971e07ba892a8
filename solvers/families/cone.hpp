#pragma once

#include "solvers/families/families.hpp"
#include "solvers/families/outline.hpp"

namespace carillon::solvers::families {

/// Half a section of a cone.
/// @throws InputError  its parameters do not fit together
ProfilePolygon cone_profile(const mesh::GeneratedShape& shape);

}  // namespace carillon::solvers::families
