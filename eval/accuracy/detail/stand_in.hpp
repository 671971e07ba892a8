#pragma once

#include <filesystem>

#include "eval/accuracy/accuracy_config.hpp"

namespace carillon::eval::accuracy {

/// Writes the surface of a generated shape with noise along its normals, as a scanner would give
/// it: triangles, no formula. The same file for the same stand-in.
/// @throws SolverError  the shape cannot be meshed; FileError  the file cannot be written
void write_stand_in(const StandIn& stand_in, const std::filesystem::path& file,
                    const std::filesystem::path& cache);

}  // namespace carillon::eval::accuracy
