#pragma once

#include <mpi.h>

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "dataset/check/report.hpp"

namespace carillon::dataset::check {

/// What is known of a dataset after all checks.
struct CheckedDataset {
  std::string name;  ///< its folder
  std::size_t samples = 0, shapes = 0;
  bool building = false;          ///< a build is writing to it
  std::vector<Finding> findings;  ///< in the order in which they are told
  bool passed = false;
};

/// Every check of a dataset; ranks share the reading of files and samples.
/// @param inputs  folder that paths in the configuration are meant from; "": where it lay
/// @return on rank 0 all of it, on the others whether it passed
/// @throws FileError, InputError  it is no dataset; on every rank
/// @note Collective on comm.
CheckedDataset check_dataset(const std::filesystem::path& dataset, const std::string& inputs,
                             MPI_Comm comm);

}  // namespace carillon::dataset::check
