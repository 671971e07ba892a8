#pragma once

#include <map>
#include <nlohmann/json.hpp>
#include <string>

#include "dataset/run/build.hpp"

namespace carillon::dataset::run {

/// Every failed task of a build in plan order: `task, stage, sample, kind, message, hint, skipped,
/// reproduce` (docs/format.md); stage and sample where they are known.
/// @param finished  journal entry of each task that ended, by its key
nlohmann::json describe_failures(const LoadedBuild& build, const std::string& output,
                                 const std::map<std::string, nlohmann::json>& finished);

}  // namespace carillon::dataset::run
