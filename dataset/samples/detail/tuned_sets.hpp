#pragma once

#include <filesystem>
#include <functional>

#include "core/hdf5.hpp"
#include "dataset/samples/modes_task.hpp"
#include "scene/pitch.hpp"

namespace carillon::dataset::samples {

/// Whether pitches decide the sizes of a shape's variants.
bool is_tuned(const plan::Shape& shape);

/// Mesh and mode sets of a shape whose variants have sizes, up to a band.
using SetsAtSizes =
    std::function<solvers::pitch::PitchResult(const plan::Shape&, const solvers::modes::Band&)>;

/// Mode sets of a tuned shape. Each variant has the size at which its mode is at its pitch: as
/// frequencies go with the inverse of lengths, exactly, the solve is the one of the shape as drawn,
/// up to where the configuration's band then lies. A first solve of the lowest modes tells where.
/// @param shape  its variants get their sizes
/// @throws InputError, SolverError  there is no such mode; a size outside 1 mm to 10 m; and as
///                                  `solve` does
/// @note Collective on comm.
solvers::pitch::PitchResult make_tuned_sets(const configuration::BuildConfig& config,
                                            const BuildFolders& folders, MPI_Comm comm,
                                            core::Trace& trace, const SetsAtSizes& solve,
                                            plan::Shape& shape);

/// Writes the sizes of a tuned shape's variants as `tuned_sizes` [variants].
void write_tuned_sizes(const core::Hdf5Group& file, const plan::Shape& shape);

/// A shape's variants with their sizes, those of a tuned one from its modes file.
/// @throws FileError  the file has other variants
std::vector<plan::Variant> sized_variants(const plan::Shape& shape, const core::Hdf5Group& file);

}  // namespace carillon::dataset::samples
