#pragma once

#include <string>
#include <vector>

#include "solvers/families.hpp"

namespace carillon::solvers {

// What each file of families adds to the registry.
std::vector<Family> box_families();
std::vector<Family> round_families();
std::vector<Family> vessel_families();
std::vector<Family> hollow_families();
std::vector<Family> ball_families();
Family wrench_family();
Family turned_family();

// Meshes of families that have none of their own, as Gmsh's library makes them, which few programs
// load.
MeshResult mesh_sphere(const GeneratedShape& shape, const MeshOptions& options);
MeshResult mesh_pebble(const GeneratedShape& shape, const MeshOptions& options);
MeshResult mesh_turned(const GeneratedShape& shape, const MeshOptions& options);
MeshResult mesh_wrench(const GeneratedShape& shape, const MeshOptions& options);

/// Value of a parameter of a checked shape.
double parameter(const GeneratedShape& shape, const std::string& name);

/// Every parameter of the family is there, positive and finite, and no other.
/// @throws InputError  names the parameter, or the nearest one that exists
void check_parameters(const GeneratedShape& shape);

/// @throws InputError  `rule` with the family's name in front, when `holds` is false
void require(bool holds, const GeneratedShape& shape, const std::string& rule);

/// A mesh with its quality.
MeshResult finish(TetMesh mesh, std::int64_t straightened = 0);

}  // namespace carillon::solvers
