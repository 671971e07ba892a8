#pragma once

#include <filesystem>
#include <vector>

#include "eval/features/feature.hpp"

namespace carillon::eval::features {

/// Features from a table of comma-separated values whose first line names the columns:
/// `frequency_hz` and `decay_rate_per_s`, and optionally `frequency_error_hz`,
/// `decay_rate_error_per_s`, `amplitude` and `reverberant` (1: may be the room's); other
/// columns are not read, quoted ones may have commas in them. Errors that are missing are NaN.
/// Empty lines and lines that begin with # are passed over.
/// @throws FileError   not readable
/// @throws InputError  a column that is missing, a value that is no number or not positive; names
///                     file and line
std::vector<Feature> read_feature_table(const std::filesystem::path& path);

}  // namespace carillon::eval::features
