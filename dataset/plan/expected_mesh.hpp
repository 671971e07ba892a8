#pragma once

#include "dataset/plan/plan.hpp"
#include "solvers/pitch/pitch_model.hpp"

namespace carillon::dataset::plan {

/// An object as far as it is known before it is meshed.
struct ExpectedObject {
  solvers::mesh::ShapeExtent extent;
  solvers::pitch::MeshSize mesh;  ///< as the mesher will make it, within a factor of about 1.5
};

/// From the family's parameters or what the plan found of the file's triangles, and the order and
/// size of the elements. Depends on these alone, not on a cache. A file that could not be read, or
/// bounds nothing, is taken for an object of middling size: its task will say what is wrong with
/// it.
ExpectedObject expected_object(const Shape& shape);

}  // namespace carillon::dataset::plan
