#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <vector>

#include "dataset/run/check_files.hpp"
#include "dataset/run/joined_files.hpp"
#include "dataset/samples/modes_task.hpp"

namespace carillon::dataset::run {

/// Writes index.h5: every sample of the given tasks in plan order, arrays joined as virtual
/// datasets, texts copied; `shapes/` holds what belongs to objects, `appearances/` their frames in
/// each material; `shape_index` and `appearance_index` point there.
/// @param done    indices of finished samples tasks, ascending
/// @param target  the file; what it joins it names from folders.output
/// @param joined  of folders.output: files that it knows are not read again, but for the first
///                ones, whose types the index takes
void write_index(const configuration::BuildConfig& config, const plan::BuildPlan& plan,
                 const std::vector<std::size_t>& done, const samples::BuildFolders& folders,
                 const std::filesystem::path& target, JoinedFiles& joined);

/// dataset.json: configuration, versions, materials, shapes, files with checksums. It holds no
/// date, host or timing.
/// @param samples   number of samples in the index
/// @param pitch_targets  by a shape's id, as ModesTaskResult::pitch_target
/// @param files     every file of the dataset
nlohmann::json describe_dataset(const configuration::BuildConfig& config,
                                const plan::BuildPlan& plan, std::size_t samples,
                                const nlohmann::json& pitch_targets,
                                const std::vector<ListedFile>& files);

/// Versions of this program (`carillon`, and `revision` where it was built from a clone) and of the
/// libraries that results depend on.
nlohmann::json program_versions();

}  // namespace carillon::dataset::run
