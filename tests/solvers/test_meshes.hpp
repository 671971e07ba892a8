#pragma once

#include <array>
#include <functional>
#include <string>

#include "solvers/mesh/tet_mesh.hpp"

namespace carillon::test {

using solvers::mesh::TetMesh;

/// Straight elements of a higher order on the corners of a first-order mesh; regions are kept,
/// boundary faces are filled in.
TetMesh with_order(const TetMesh& linear, int order);

/// Box [0, a] x [0, b] x [0, c] in cells of six tetrahedra each.
/// @param region  region of the cell whose centre is given (default: one region, "body")
TetMesh box_mesh(const Vec3& sides, const std::array<int, 3>& cells, int order,
                 const std::function<int(const Vec3&)>& region = {});

/// Ball around the origin: the icosahedron cut into 20 cells^3 tetrahedra, struck up so that its
/// boundary is the sphere (nodes of the order included) while the middle stays nearly straight. No
/// element has two faces on the boundary, which would flatten it.
TetMesh ball_mesh(double radius, int cells, int order);

/// Hollow ball around the origin: 20 faces^2 curved prisms to a layer, three tetrahedra each, both
/// boundaries spheres.
/// @param faces   pieces along an edge of the icosahedron
/// @param layers  through the wall
TetMesh shell_mesh(double outer, double inner, int faces, int layers, int order);

/// The mesh with the nodes of `finer`, the same elements (number and corners) at the next order,
/// as its finer_nodes.
TetMesh with_finer_nodes(TetMesh mesh, const TetMesh& finer);

/// Both bodies in one mesh, the second's regions renumbered to those of the first.
TetMesh joined(const TetMesh& first, const TetMesh& second);

/// Nodes moved by a map; faces are recomputed and elements turned over when it mirrors.
TetMesh moved(const TetMesh& mesh, const std::function<Vec3(const Vec3&)>& map);

/// Corners and tetrahedra of a text file: `nodes tets`, then nodes, then elements.
TetMesh read_tetrahedra(const std::string& path);

/// Folder of the reference data, or "" (the test skips).
std::string data_folder();

}  // namespace carillon::test
