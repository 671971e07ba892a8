#pragma once

#include <mpi.h>

#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "core/trace.hpp"
#include "solvers/assembly/mirror_class.hpp"
#include "solvers/eigen/pitch_error.hpp"
#include "solvers/eigen/solve_modes.hpp"

namespace carillon::solvers::eigen {

/// Modes of a class of fields, or of all, on the mesh that they were solved on.
struct ClassModes {
  modes::Modes modes;           ///< pitch_errors empty
  std::vector<TrueMode> truth;  ///< of as many modes, in no order; empty where none was asked for
};

/// A body as its mirror planes let it be solved.
struct PartToSolve {
  mesh::MirroredPart part;
  ErrorMargins margins;  ///< of the part's elements
};

/// The part beside a body's planes of symmetry where its classes are cheaper to solve than the
/// whole: options.mirror_planes is set, the body is one piece, the part has 600 unknowns or more,
/// and its factors are far below what each of the ranks may take, so that the direct solver serves.
/// @return nothing where the body is to be solved whole
std::optional<PartToSolve> part_to_solve(const mesh::TetMesh& mesh,
                                         std::span<const elements::Elastic> regions,
                                         const SolveOptions& options, int ranks);

/// Solves one class for several bands.
/// @param options  memory is what this class may take
/// @return one for each band; nothing where one cannot be certified
/// @note Collective on comm.
using SolveClass = std::function<std::vector<std::optional<ClassModes>>(
    const assembly::MirrorClass&, std::span<const modes::Band>, const SolveOptions& options,
    MPI_Comm comm)>;

/// Modes of a body from its classes, which are spread over the ranks: each band's number of modes
/// is shared out among them, and those that turn out to have more are asked again.
/// @param mesh  the whole body
/// @return one for each band; nothing where a class could not certify its modes
/// @note Collective on comm.
std::vector<std::optional<modes::Modes>> solve_classes(
    const mesh::TetMesh& mesh, const PartToSolve& body, std::span<const modes::Band> bands,
    const SolveOptions& options, const SolveClass& solve_class, MPI_Comm comm);

/// The lowest modes of a body from those of its classes on a part: shapes are unfolded, modes put
/// in order, and pitch errors told by their place among all.
/// @param classes  one for each of mirror_classes(), in their order
modes::Modes join_classes(const mesh::TetMesh& mesh, const mesh::MirroredPart& part,
                          std::span<const ClassModes> classes, const modes::Band& band);

}  // namespace carillon::solvers::eigen
