#pragma once

#include <nlohmann/json.hpp>

#include "dataset/run/run_builds.hpp"

namespace carillon::dataset::sweep {

/// Sounds of a variant that are listened to; of more, so many evenly spaced ones.
constexpr std::size_t max_measured_sounds = 200;

/// One variant's row of sweep.csv, from the columns of its index.h5: a pure function of the
/// dataset. Null where there is nothing to tell: no samples, no noise, sounds that do not decay.
nlohmann::ordered_json variant_results(const run::BuildRun& run, const run::Results& results);

/// What the clock said, of all runs of a variant: seconds of its tasks, and how often it meshed and
/// solved or found that in the cache.
/// @param finished  journal entries by task
nlohmann::ordered_json variant_timing(const std::map<std::string, nlohmann::json>& finished);

}  // namespace carillon::dataset::sweep
