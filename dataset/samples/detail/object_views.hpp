#pragma once

#include <string>
#include <vector>

#include "core/hdf5.hpp"
#include "dataset/samples/modes_task.hpp"

namespace carillon::dataset::samples {

/// Writes what is seen of a shape to its modes file: voxels, base colours of its file, and a frame
/// of each material that it sounds in from every camera; pictures as files of their own where the
/// configuration asks for them.
/// @param mesh     of its regions; without faces where the body is of one
/// @param written  gets the paths of the pictures, relative to the output folder
void write_views(const configuration::BuildConfig& config, const plan::Shape& shape,
                 const solvers::mesh::TetMesh& mesh, const solvers::modes::ModeSurface& surface,
                 const BuildFolders& folders, const core::Hdf5Group& file, core::Trace& trace,
                 std::vector<std::string>& written);

}  // namespace carillon::dataset::samples
