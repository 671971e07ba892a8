#pragma once

#include <cstdint>

#include "solvers/mesh/tet_mesh.hpp"

namespace carillon::solvers::pitch {

/// A mesh as predictions see it: how much of it there is, and how that grows.
struct MeshSize {
  int order = 1;
  double element_size = 0;  ///< longest edge [m]
  double elements = 0, vertices = 0, edges = 0, faces = 0;
  double thickness = 0;  ///< 2 volume / boundary area [m]
  double images = 1;     ///< parts that all are images of one, by whose classes it is solved

  double unknowns() const;
  /// Elements through the thickness: 1 for a wall with edges longer than it is thick.
  double layers() const;
};

/// Counts a mesh.
MeshSize size_of(const mesh::TetMesh& mesh);

/// The same body in elements of another order, with edges a factor longer. Walls of one layer are
/// refined in two directions, solids in three.
MeshSize resized(const MeshSize& mesh, int order, double size_factor);

/// Work of a solve in units of its own; only ratios mean something. Fitted to solves of 3k to 250k
/// unknowns of boxes and shells at orders 2 to 4, where it is right within a third: factor and
/// triangular solves grow as n^1.35 in a wall and n^1.5 in a solid, and elements of higher orders
/// couple more unknowns.
double relative_cost(const MeshSize& mesh);

/// Memory [byte] of the direct factor: as measured on a plate and a cube of 70k to 400k unknowns,
/// within a half.
double factor_memory(const MeshSize& mesh);

/// Pitch error [cent] after a change of order and size. Eigenvalues of smooth modes converge as
/// c (x / p)^(2 p) with x proportional to the size (Babuska and Osborn 1991), where one measured
/// error gives x; c = 866 cents, a relative error of 1, is right within a factor of two from one
/// order to the next for plates, bowls, cups, tubes, bells and blocks.
/// @param measured      error [cent] at from_order, above zero
/// @param size_factor   new size / measured one
double predicted_error(double measured, int from_order, int order, double size_factor);

/// Error [cent] that a step towards a target aims at: below it, the lower the more an error has to
/// fall, as predictions are right within a factor of two for small steps, and another step would
/// cost more than the margin.
/// @param reached  error so far [cent]
double aimed_error(double target, double reached);

/// Sizes that a step may have, over that of the elements so far: pow(2, k / 6) for these k.
constexpr int finest_sixth = -24, coarsest_sixth = 6;

/// Layers at inward edges (mesh::grade_to_edges) with which these keep to half of a target [cent]:
/// at automatic sizes they leave 12 cents or less, and each layer a sixth of that (of L-, U-, T-
/// and stepped sections).
int edge_layers_for(double cents);

}  // namespace carillon::solvers::pitch
