#pragma once

#include <filesystem>
#include <vector>

#include "eval/features/feature.hpp"

namespace carillon::eval::features {

/// Features from a table of comma-separated values whose first line names the columns: `frequency`
/// (damped) and `decay_rate`, or in its place `damping_ratio` (zeta), `q`, `loss_factor` (eta) or
/// `t60`; optionally `frequency_error` and the error of any of these, `amplitude` and `reverberant`
/// (1: may be the room's). A unit follows an underscore or stands in brackets: `frequency_hz`,
/// `Frequency (kHz)`, `T60 [ms]`, `zeta [%]`. With omega the damped angular frequency,
///
///   d = omega zeta / sqrt(1 - zeta^2), zeta = 1 / (2 Q) = eta / 2;  d = ln(1000) / T60,
///
/// and errors by the slopes of these. Columns that say the same twice must agree within 2 %. Other
/// columns are not read, quoted ones may have commas in them. Errors that are missing are NaN.
/// Empty lines and lines that begin with # are passed over.
/// @throws FileError   not readable
/// @throws InputError  a column that is missing or there twice, a unit that is not known, a value
///                     that is no number, not positive or of what does not ring, two columns that
///                     disagree; names file and line
std::vector<Feature> read_feature_table(const std::filesystem::path& path);

}  // namespace carillon::eval::features
