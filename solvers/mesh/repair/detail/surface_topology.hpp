#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "solvers/mesh/surface_mesh.hpp"

namespace carillon::solvers::mesh::repair {

/// One side of a triangle; `forward` when the triangle walks it from low to high.
struct EdgeUse {
  std::int32_t low, high;
  std::int32_t triangle;
  bool forward;
};

/// Sides of all triangles sorted by edge, then by triangle. Sides of no length (a repeated vertex)
/// are left out.
std::vector<EdgeUse> edge_uses(const std::vector<Triangle>& triangles);

/// Calls visit(span of the uses of one edge) for every edge, in order.
template <class Visit>
void for_each_edge(const std::vector<EdgeUse>& uses, Visit visit) {
  for (std::size_t begin = 0; begin < uses.size();) {
    std::size_t end = begin + 1;
    while (end < uses.size() && uses[end].low == uses[begin].low &&
           uses[end].high == uses[begin].high) {
      ++end;
    }
    visit(std::span(uses).subspan(begin, end - begin));
    begin = end;
  }
}

/// A triangle at an edge.
struct Blade {
  double angle;   ///< about the edge, in an arbitrary unit, rounded
  bool backward;  ///< walks the edge from high to low: its back looks to rising angles
  std::int32_t triangle;
};

/// Triangles at an edge in the order in which a turn about it, counter-clockwise seen against its
/// direction from low to high, meets them. Of those in one direction the forward ones come first:
/// a wedge of material ends before the next one begins.
std::vector<Blade> blades_around(const SurfaceMesh& mesh, std::span<const EdgeUse> edge);

/// Which corner of a triangle a vertex is; 3 where it is none.
std::size_t corner_of(const Triangle& t, std::int32_t vertex);

/// Every edge has two triangles that walk it in opposite directions.
bool is_closed_and_oriented(const std::vector<Triangle>& triangles);

/// Vertices whose triangles form more than one fan.
std::int64_t count_nonmanifold_vertices(const SurfaceMesh& mesh);

/// The steps below change a surface in place and return how much they changed.

/// Merges vertices of open edges that lie within `distance` of each other, when that leaves fewer
/// open edges.
std::int64_t weld_borders(SurfaceMesh& mesh, double distance);
/// Triangles that name a vertex twice.
std::int64_t drop_collapsed(SurfaceMesh& mesh);
/// All but the first of triangles with the same corners, whichever way round; the first too where
/// such pairs form a fin or an inner wall that bounds nothing.
std::int64_t drop_twins(SurfaceMesh& mesh);

/// Makes neighbours agree on their orientation, in each component with the majority of area.
/// @return triangles that were turned over
std::int64_t orient_neighbours(SurfaceMesh& mesh);

/// Cuts surfaces apart that only touch: at edges of more than two triangles those that bound the
/// same wedge of material stay together, vertices get a copy for each further fan. Neighbours must
/// agree on their orientation.
/// @return vertices added
std::int64_t cut_apart(SurfaceMesh& mesh);

/// Walls in the middle of solids, as models of several layers have them. A surface without open
/// edges divides space; a part that its triangles enclose and look away from is solid. Connected
/// surfaces that do not divide space into solid and void, but for such walls, stay as they are.
std::int64_t drop_inner_walls(SurfaceMesh& mesh);

/// Reverses the triangles for which `component[t] == c`.
void reverse(SurfaceMesh& mesh, const std::vector<std::int32_t>& component, std::int32_t c);

SurfaceMesh join(std::span<const SurfaceMesh> pieces);

/// For each closed piece, those that lie inside of it entirely; nothing may intersect.
/// @return for every piece the indices of the pieces around it, ascending
std::vector<std::vector<std::size_t>> enclosing_pieces(std::span<const SurfaceMesh> pieces);

}  // namespace carillon::solvers::mesh::repair
