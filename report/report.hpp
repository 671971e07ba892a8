#pragma once

#include <cstddef>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "dataset/stored/stored_dataset.hpp"

namespace carillon::report {

/// What a report finds below the folders that it is asked for, each in the order of their names.
struct ReportFolders {
  std::vector<std::filesystem::path> datasets;      ///< with dataset.json
  std::vector<std::filesystem::path> builds;        ///< with status.json, sweeps' own among them
  std::vector<std::filesystem::path> sweeps;        ///< with sweep.json
  std::vector<std::filesystem::path> studies;       ///< with accuracy.json
  std::vector<std::filesystem::path> evaluations;   ///< `evaluation/`
  std::vector<std::filesystem::path> nightly_runs;  ///< with nightly.json
  std::vector<std::string> unreadable;              ///< what could not be looked into, and why
};

/// Looks in the folders and those below, to a depth of four; a dataset's own folders are left out.
/// @param may_be_empty  there may be nothing in any of them
/// @throws InputError  a folder that is not there or cannot be read, or nothing in any of them
ReportFolders find_report_folders(const std::vector<std::string>& folders,
                                  bool may_be_empty = false);

/// What was built and how long it took: objects, stages, effects, ranks, failures, configuration.
/// Made of the folder's own files; nothing is computed again. `worst_modes`: those with the largest
/// estimated errors, the largest first; `pitch_target_cents` of the build, or null.
/// @param rows  of objects, tasks, failures and warnings each, at the most: those that took
/// longest,
///              the first failures; `objects`, `tasks_run`, `failed` and `warned` count all
nlohmann::ordered_json dataset_report(const dataset::stored::StoredDataset& dataset,
                                      std::size_t rows);

/// What a page can hold of one kind.
struct ReportShare {
  std::size_t count = 0;  ///< at most so many
  std::size_t bytes = 0;  ///< and not more than so much text
};

/// @throws FileError  names the first shard of a dataset that is not there, or not whole
void require_shards(const std::filesystem::path& folder);

/// Sounds that stand for a dataset, evenly chosen from its rows: WAV file of 16 bits with its peak
/// at half of full scale, what was drawn for it, frame and voxels of its object. Each has an equal
/// share of the bytes; of a longer clip its beginning is taken, of many listeners the first two.
nlohmann::ordered_json heard_samples(const std::filesystem::path& folder, ReportShare share);

/// The same of the samples that were made last, of the newest tasks in turn, the newest first: read
/// from their shards, which a build has written before the index knows them, without voxels. None
/// of a folder without journal.jsonl.
nlohmann::ordered_json newest_samples(const std::filesystem::path& folder, ReportShare share);

/// `objects`: objects of a dataset, each in one of its materials and sizes: surface, looks of its
/// parts, and modes with their errors, as displacements along the normal, the lowest ones as far as
/// they fit (of a few, displacements in the room), and what damps them.
/// `left_out`: how many objects are not among them, by reason; `bytes`: of the share, those used.
/// @param notes  of what could not be read
nlohmann::ordered_json gallery_objects(const dataset::stored::StoredDataset& dataset,
                                       ReportShare share, nlohmann::ordered_json& notes);

/// Presets whose damping is Rayleigh's, for the gallery.
nlohmann::ordered_json gallery_materials();

/// A folder's JSON document with the folder's path as `folder`, and `made` from the trace beside it
/// (NAME-trace.json, or the last run of trace.json), where there is one.
/// @param key  that it must have
/// @throws FileError  it cannot be read, or is none of this kind
nlohmann::ordered_json read_document(const std::filesystem::path& folder, const std::string& name,
                                     const std::string& key);

/// damping.json of an evaluation, shortened to what is shown, with `seconds_per_sound`.
/// @throws FileError  as read_document()
nlohmann::ordered_json read_damping(const std::filesystem::path& folder);

/// classification.json of an evaluation, with the confusion of one method for each task: of that
/// which is most often right.
/// @throws FileError  as read_document()
nlohmann::ordered_json read_classification(const std::filesystem::path& folder);

/// The page that shows a report.
/// @throws InputError  the program was built without it
std::string report_page(const nlohmann::ordered_json& report);

/// What a page is to show.
struct PageRequest {
  std::vector<std::string> folders;  ///< of datasets, studies and evaluations, or that hold such
  std::size_t sounds = 12;           ///< samples to hear, of all datasets together
  std::size_t objects = 40;          ///< objects to strike, likewise
  nlohmann::ordered_json made;       ///< mpi::made_by()
  bool may_be_empty = false;         ///< as find_report_folders()
};

struct Page {
  std::string html;
  std::size_t datasets = 0, studies = 0, objects = 0;  ///< that are shown
  std::vector<std::string> notes;                      ///< what is left out, and why
};

/// One page of all that the folders hold, within some 15 MB; what cannot be read is noted.
/// @throws FileError, InputError  as find_report_folders()
Page make_page(const PageRequest& request);

}  // namespace carillon::report
