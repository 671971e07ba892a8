#pragma once

#include <filesystem>

#include "solvers/mesh/shape_source.hpp"

namespace carillon::solvers::mesher {

/// Reads or generates, repairs, remeshes and fills with tetrahedra. Meshes carry finer_nodes but
/// for tetrahedra from an MSH file: they are the truth about their body. Runs inside the mesher's
/// own process (no MPI, no PETSc); others call mesh_in_child().
/// @param cache  keeps the bodies that surfaces are repaired to; empty: nothing is kept
/// @throws InputError  not a body, or cannot be repaired; says which and what would help
/// @throws SolverError the mesher failed, or the bound on elements is exceeded (names the size
///                     that would fit)
mesh::MeshResult make_tet_mesh(const mesh::MeshRequest& request,
                               const std::filesystem::path& cache);

/// Diagnosis of a file's surface (of the boundary of its tetrahedra), scaled as `file` says but of
/// any size. Inside the mesher's process too; others call diagnose_in_child().
/// @throws InputError, FileError  the file cannot be read
mesh::Diagnosis diagnose_file(const mesh::MeshFile& file);

}  // namespace carillon::solvers::mesher
