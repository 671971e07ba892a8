#pragma once

#include <optional>

#include "solvers/mesh/shape_source.hpp"
#include "solvers/pitch/pitch_model.hpp"

namespace carillon::solvers::pitch {

/// Mesh that the mesher will make of a body, within a factor of about 1.5.
/// @param curve_cells  of a generated body, its family's; none: a body from a file
MeshSize expected_mesh(const mesh::ShapeExtent& body, const mesh::MeshOptions& options,
                       std::optional<double> curve_cells);

/// Tetrahedra that stand in a file of so many bytes, taken as they are: about 40 bytes each with
/// their fraction of the nodes, as text or binary.
MeshSize expected_mesh_of_file(double bytes, const mesh::ShapeExtent& body, int order);

/// The mesh that a pitch target ends with, as far as that can be told before anything is solved: at
/// the mesher's own size and order 3 solids and stout bars are within 5 cents, walls of one layer
/// are 10 to 90 off and end at order 4 with elements a tenth smaller; never more than max_unknowns.
MeshSize expected_refinement(const MeshSize& mesh, double cents, std::int64_t max_unknowns);

/// What the mode sets of a body come to.
struct ExpectedSets {
  double solves = 1;  ///< eigensolves: of each set, or of a basis for many
  double modes = 10;  ///< of the largest set
  double sets = 1;
};

/// Seconds of one rank of a 2.3 GHz Xeon, within a factor of two for bodies of 600 to 400,000
/// unknowns: the mesher's process, and solves with their counts and error estimates.
double solve_seconds(const MeshSize& mesh, const ExpectedSets& sets);

/// [byte] at the peak of meshing and solving on all ranks, within a quarter of what most bodies of
/// 600 to 100,000 unknowns were seen to hold beside idle ranks: matrices, and either a direct
/// solve's factor and vectors or the judging of its modes; what does not fit the memory limit is
/// solved by other means within it.
/// @param memory_limit  [byte]
double solve_memory(const MeshSize& mesh, const ExpectedSets& sets, int ranks, double memory_limit);

}  // namespace carillon::solvers::pitch
