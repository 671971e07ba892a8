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

/// Pitch error [cent] to expect of the mesher's own sizes, by the largest wave number among the
/// modes [rad/m]: within a factor of two for bars, tiles, blocks and wrenches of 10 to 200 modes.
/// It grows more slowly with the wave number than that of a smooth mode would, as corners have
/// errors of their own.
double expected_error(const MeshSize& mesh, double wave_number);

/// The mesh that a pitch target ends with, as far as that can be told before anything is solved:
/// one step of the search (pitch_target.hpp) from an expected error. Never more than max_unknowns.
/// @param error  that the mesh is expected to have [cent]
/// @param cents  the target; 0: none
MeshSize expected_refinement(const MeshSize& mesh, double error, double cents,
                             std::int64_t max_unknowns);

/// What the mode sets of a body come to.
struct ExpectedSets {
  double solves = 1;  ///< eigensolves: of each set, or of a basis for many
  double modes = 10;  ///< of the largest set
  double sets = 1;
};

/// Processor seconds of the mesher's process, on an AMD EPYC.
double mesh_seconds(const MeshSize& mesh);

/// Processor seconds of one rank of an AMD EPYC, within a factor of two for bodies of 600 to
/// 400,000 unknowns: solves with their counts and error estimates.
double solve_seconds(const MeshSize& mesh, const ExpectedSets& sets);

/// [byte] at the peak of meshing and solving on all ranks, within a quarter of what most bodies of
/// 600 to 100,000 unknowns were seen to hold beside idle ranks: matrices, and either a direct
/// solve's factor and vectors or the judging of its modes; what does not fit the memory limit is
/// solved by other means within it.
/// @param memory_limit  [byte]
double solve_memory(const MeshSize& mesh, const ExpectedSets& sets, int ranks, double memory_limit);

}  // namespace carillon::solvers::pitch
