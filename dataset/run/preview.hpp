#pragma once

#include <mpi.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "core/columns.hpp"
#include "dataset/run/build.hpp"
#include "dataset/samples/sample_row.hpp"

namespace carillon::dataset::run {

/// One sample as a build would make it.
struct Preview {
  const plan::Sample* sample = nullptr;  ///< of the build's plan
  samples::SampleResult result;
  nlohmann::json record;  ///< its columns but for arrays
  bool moving = false, movie = false;
};

/// Makes one sample of a configuration before any build: sound.wav, spectrogram.png, pictures/, and
/// of a scene that moves movies/.
/// @param name    the sample's number, id or key
/// @param output  folder for the files; one without a dataset
/// @return on rank 0 all of it, on the others nothing
/// @throws InputError  no such sample, or `output` holds a dataset
/// @throws SolverError and others  as in a build
/// @note Collective on comm.
Preview preview_sample(LoadedBuild& build, const std::string& name,
                       const std::filesystem::path& output, const std::filesystem::path& cache,
                       MPI_Comm comm);

}  // namespace carillon::dataset::run
