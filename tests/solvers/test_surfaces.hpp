#pragma once

#include <array>
#include <random>
#include <vector>

#include "solvers/mesh/surface_mesh.hpp"

namespace carillon::test {

using solvers::mesh::SurfaceMesh;

/// Box [0, sides], each face in n x n squares of two triangles.
SurfaceMesh box_surface(const Vec3& sides, int n);
/// Sphere around the origin: the octahedron's faces cut into n^2, then struck up.
SurfaceMesh sphere_surface(double radius, int n);
/// A closed polygon of (radius, height), counter-clockwise seen with the axis to the left, turned
/// about the z axis. Points on the axis become one vertex.
SurfaceMesh turned_surface(const std::vector<std::array<double, 2>>& profile, int segments);
SurfaceMesh torus_surface(double radius, double tube, int segments);
/// Tube of a mean radius, wall and length.
SurfaceMesh tube_surface(double radius, double wall, double length, int segments);
/// Half of a spherical shell, mouth upward.
SurfaceMesh bowl_surface(double radius, double wall, int segments);

SurfaceMesh moved(SurfaceMesh mesh, const Vec3& by);
SurfaceMesh together(const SurfaceMesh& a, const SurfaceMesh& b);
SurfaceMesh turned_over(SurfaceMesh mesh);

enum class Damage { dropped, flipped, doubled, seams };

/// A fraction of the faces (at least one) dropped, flipped or doubled (every second twin the other
/// way round), or given corners of their own.
SurfaceMesh damaged(SurfaceMesh mesh, Damage damage, double fraction, std::mt19937_64& random);

}  // namespace carillon::test
