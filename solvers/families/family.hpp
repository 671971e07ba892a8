#pragma once

#include <numbers>
#include <string>
#include <vector>

#include "solvers/families/families.hpp"

namespace carillon::solvers::families {

// What each file of families adds to the registry.
std::vector<Family> box_families();
std::vector<Family> round_families();
std::vector<Family> vessel_families();
std::vector<Family> hollow_families();
std::vector<Family> ball_families();
Family torus_family();
Family cone_family();
Family wrench_family();
Family turned_family();

// Meshes of families that have none of their own, as Gmsh's library makes them, which few programs
// load.
mesh::MeshResult mesh_sphere(const mesh::GeneratedShape& shape, const mesh::MeshOptions& options);
mesh::MeshResult mesh_pebble(const mesh::GeneratedShape& shape, const mesh::MeshOptions& options);
mesh::MeshResult mesh_cone(const mesh::GeneratedShape& shape, const mesh::MeshOptions& options);
mesh::MeshResult mesh_turned(const mesh::GeneratedShape& shape, const mesh::MeshOptions& options);
mesh::MeshResult mesh_wrench(const mesh::GeneratedShape& shape, const mesh::MeshOptions& options);

/// Value of a parameter of a checked shape.
double parameter(const mesh::GeneratedShape& shape, const std::string& name);

/// Of a body that fills a fraction of its box, whose sides are given [m].
mesh::ShapeExtent box_extent(const Vec3& sides, double fraction = 1);

/// An ellipsoid's volume beside that of its box.
inline constexpr double ellipsoid_fraction = std::numbers::pi / 6;

/// Every parameter of the family is there, positive (or 0 where it may be) and finite, and no
/// other.
/// @throws InputError  names the parameter, or the nearest one that exists
void check_parameters(const mesh::GeneratedShape& shape);

/// @throws InputError  `rule` with the family's name in front, when `holds` is false
void require(bool holds, const mesh::GeneratedShape& shape, const std::string& rule);

/// Cells of a side that a plane of symmetry halves: an even number, or one, which has no plane.
constexpr int even_cells(int cells) {
  return cells == 1 ? 1 : cells + cells % 2;
}

/// A mesh with its quality.
mesh::MeshResult finish(mesh::TetMesh mesh, std::int64_t straightened = 0);

}  // namespace carillon::solvers::families
