#pragma once

#include "solvers/families/outline.hpp"
#include "solvers/mesh/curve_mesh.hpp"

namespace carillon::solvers::families {

/// Triangles of the surface that a checked profile makes when turned about z: edges of about
/// `cell` [m], shorter where the surface bends or a thin wall would not hold their sagitta.
mesh::SurfaceMesh revolve(const ProfilePolygon& profile, double cell);

/// Nearest point of the turned surface, exact in the half-plane of the point: never to a side of
/// the wall that looks the other way.
mesh::SurfaceProjection project_to_turned(const ProfilePolygon& profile);

/// Volume [m^3] and area [m^2] by Pappus' rules, edge by edge.
double turned_volume(const ProfilePolygon& profile);
double turned_area(const ProfilePolygon& profile);

}  // namespace carillon::solvers::families
