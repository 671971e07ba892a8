#pragma once

#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <string>

#include "dataset/run/run_builds.hpp"

namespace carillon::dataset::run {

/// A dataset's trace.json but for what the run as a whole has to say.
nlohmann::json describe_trace(const LoadedBuild& build,
                              const std::map<std::string, nlohmann::json>& finished,
                              const Results& results);

/// Writes a folder's trace.json where it does not say so yet: a run that was killed may have ended
/// all tasks and not have come to it.
/// @param document  of describe_trace(); `runs` of the folder's old one are kept
/// @param outcome   where ranks worked on this folder alone: what the run says of itself is added
///                  (`runs`, `ranks`, `index`) if it ran tasks. Null for one of several builds
void keep_trace(const std::filesystem::path& folder, nlohmann::json& document,
                const RunOutcome* outcome, const mpi::Context& context);

}  // namespace carillon::dataset::run
