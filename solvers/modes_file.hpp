#pragma once

#include <filesystem>
#include <functional>
#include <string>

#include "core/hdf5.hpp"
#include "solvers/modes.hpp"

namespace carillon::solvers {

/// Stores modes in an HDF5 group (docs/format.md names the fields), with units as attributes.
void write_modes(const core::Hdf5Group& group, const Modes& modes);
Modes read_modes(const core::Hdf5Group& group);

/// Key of a solve: mesh bytes, regions, options, width of the group of ranks, solver version.
std::string modes_key(const TetMesh& mesh, std::span<const Elastic> regions,
                      const SolveOptions& options, int group_size);

/// solve_modes() behind a cache of files named by key (empty path: no cache). A hit is counted
/// in trace.stages["modes from cache"].
/// @note Collective on comm: rank 0 reads or writes the file, all get the same modes.
Modes cached_modes(const TetMesh& mesh, std::span<const Elastic> regions,
                   const SolveOptions& options, MPI_Comm comm, const std::filesystem::path& cache,
                   core::Trace& trace);

}  // namespace carillon::solvers
