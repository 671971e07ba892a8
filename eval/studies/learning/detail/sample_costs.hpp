#pragma once

#include <optional>
#include <vector>

#include "eval/studies/datasets.hpp"

namespace carillon::eval::studies {

/// What the build took for a sample of each dataset [s], with effects that datasets share (rooms,
/// fits of radiation) at what they took where they took longest. Nothing where it is not known.
/// @throws FileError  a trace or an index that cannot be read
std::vector<std::optional<double>> seconds_per_sample(const std::vector<Condition>& conditions);

}  // namespace carillon::eval::studies
