#pragma once

#include <mpi.h>

#include <filesystem>
#include <optional>
#include <span>
#include <string>

#include "solvers/eigen/solve_modes.hpp"

namespace carillon::solvers::eigen {

/// Key of a solve: mesh bytes, regions, options, width of the group of ranks, solver version.
std::string modes_key(const mesh::TetMesh& mesh, std::span<const elements::Elastic> regions,
                      const SolveOptions& options, int group_size);

/// A cached set by its key, unless there is none or its file is unusable. A hit is counted in
/// trace.stages["modes from cache"].
/// @note Collective on comm: rank 0 reads the file, all get the same modes.
std::optional<modes::Modes> load_modes(const std::filesystem::path& cache, const std::string& key,
                                       MPI_Comm comm, core::Trace& trace);
/// Caches a set; where that fails, a warning is all that comes of it.
void store_modes(const std::filesystem::path& cache, const std::string& key,
                 const modes::Modes& modes, MPI_Comm comm);

/// solve_modes() behind a cache of files named by key (empty path: no cache).
/// @note Collective on comm: rank 0 reads or writes the file, all get the same modes.
modes::Modes cached_modes(const mesh::TetMesh& mesh, std::span<const elements::Elastic> regions,
                          const SolveOptions& options, MPI_Comm comm,
                          const std::filesystem::path& cache, core::Trace& trace);

}  // namespace carillon::solvers::eigen
