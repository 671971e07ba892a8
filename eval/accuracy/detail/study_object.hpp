#pragma once

#include <string>

#include "scene/object.hpp"

namespace carillon::eval::accuracy {

/// What to mesh for an object of a study: its file, or its shape with each parameter in the middle
/// of its range, scaled to its `length`.
/// @param node  where the object stands, for messages
/// @throws ConfigError  it has several, parameters that contradict each other, or a size outside
///                      1 mm to 10 m without `any_size`
solvers::mesh::MeshRequest only_mesh(const core::ConfigNode& node, const scene::Object& object);

/// Its one material.
/// @throws ConfigError  it has several
std::string only_material(const core::ConfigNode& node, const scene::Object& object);

}  // namespace carillon::eval::accuracy
