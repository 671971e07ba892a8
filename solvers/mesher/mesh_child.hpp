#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "solvers/mesh/shape_source.hpp"

namespace carillon::solvers::mesher {

/// Limits of the mesher's process.
struct ChildLimits {
  double seconds = 300;             ///< wall clock, then it is killed
  std::int64_t memory = 8ll << 30;  ///< address space [byte]
};

/// Exit code of a mesher that cannot read its request or write its reply.
constexpr int mesher_without_storage = 74;

/// Key of a mesh: SHA-256 of the request, of the file's bytes and of the mesher's version.
/// @throws FileError  the mesh file cannot be read
std::string mesh_key(const mesh::MeshRequest& request);

/// Key of the body that a file's surface is repaired to.
/// @throws FileError  the file cannot be read
std::string body_key(const mesh::MeshFile& file);

/// Meshes in a child process (`carillon-mesh`, found by core::find_helper or in $CARILLON_MESH),
/// so that a crash, a hang or a lack of memory there costs this call only. The result is kept in
/// `cache` under its key (empty path: no cache), and so is the body that a file's surface is
/// repaired to: it is meshed at other sizes too.
/// @throws InputError, SolverError  as make_tet_mesh does, and SolverError for a crash, the time
///         limit or the memory limit, each named
/// @throws StorageError  there is no mesher, no process for it or no folder for its request
mesh::MeshResult mesh_in_child(const mesh::MeshRequest& request, const ChildLimits& limits,
                               const std::filesystem::path& cache);

/// Whether `cache` holds the mesh of a request; false as well where the mesh file cannot be read.
bool mesh_is_cached(const mesh::MeshRequest& request, const std::filesystem::path& cache);

/// Diagnosis alone, in the same child (no repair, no tetrahedra).
mesh::Diagnosis diagnose_in_child(const mesh::MeshFile& file, const ChildLimits& limits);

}  // namespace carillon::solvers::mesher
