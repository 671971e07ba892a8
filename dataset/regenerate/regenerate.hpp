#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "dataset/stored/stored_dataset.hpp"
#include "mpi/context.hpp"

namespace carillon::dataset::regenerate {

struct RegenerateOptions {
  std::string dataset;                 ///< folder
  std::vector<std::string> samples;    ///< row of index.h5, key or id
  std::vector<std::string> overrides;  ///< --set key=value: what is to change
  std::string inputs;                  ///< folder that paths of the configuration are meant from
  std::string output;                  ///< WAV file, a folder for several samples; "": none
};

/// Makes samples of a dataset again and compares each with what is stored.
/// @return `samples[]`: key, id, stored, identical, `differences[]` (as differences()), record
/// (what
///         was drawn), wav; `versions`: libraries of other versions than the build's; `doubts[]`;
///         `modes[]`: shapes whose modes were solved again, and why
/// @throws InputError  no dataset, no such sample, files that are needed are not there
nlohmann::json regenerate(const RegenerateOptions& options, const mpi::Context& context);

}  // namespace carillon::dataset::regenerate
