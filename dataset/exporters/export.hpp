#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/hdf5.hpp"
#include "dataset/exporters/exported_rows.hpp"

namespace carillon::dataset::exporters {

/// A dataset that is written in another format, by several ranks.
struct Export {
  std::filesystem::path output;
  const core::Hdf5Group& index;
  const ExportedRows& rows;
  int rank = 0, ranks = 1;

  /// Whether this rank writes the `number`-th of what is shared out.
  bool is_own(std::size_t number) const {
    return number % static_cast<std::size_t>(ranks) == static_cast<std::size_t>(rank);
  }
};

/// A file that an export made, from its folder.
struct ExportedFile {
  std::string path, sha256;
  std::uintmax_t bytes = 0;
};

/// This rank's share of Hugging Face's AudioFolder layout: PART/KEY.wav. Rank 0 also writes
/// PART/metadata.jsonl, whose `file_name` names the files and whose values have the same types in
/// all parts.
/// @return the tables
std::vector<ExportedFile> write_audio_folder(const Export& task);

/// Where a sample's sound is in that layout, from the export's folder.
std::string sound_path(const ExportedRows& rows, std::size_t row);

/// This rank's share of the same files, with which rank 0 writes Lhotse's manifests
/// recordings_PART.jsonl and supervisions_PART.jsonl: an event for each stored strike of a
/// simulation, or one for a clip of one strike. Times in seconds from the clip's begin.
/// @return the tables and manifests
std::vector<ExportedFile> write_lhotse(const Export& task);

/// This rank's share of WebDataset's layout: PART-NNNNNN.tar with KEY.wav, KEY.json and, of each
/// further column, KEY.NAME.npy; samples in an order that is random but fixed.
/// @param arrays     columns of the index or of its `shapes`
/// @param per_shard  samples of a tar file
/// @return the tar files
/// @throws InputError  there is no such column
std::vector<ExportedFile> write_web_dataset(const Export& task,
                                            const std::vector<std::string>& arrays,
                                            std::size_t per_shard);

ExportedFile exported_file(const std::filesystem::path& folder, const std::string& path);

/// The Croissant description of an export: its files, and records that joins of them make.
/// @param head    as croissant_head makes it
/// @param format  `wav`, `webdataset` or `lhotse`
/// @param files   of all ranks, and others of the export
nlohmann::ordered_json croissant_of(nlohmann::ordered_json head, const std::string& format,
                                    const std::vector<ExportedFile>& files,
                                    const ExportedRows& rows, const core::Hdf5Group& index);

}  // namespace carillon::dataset::exporters
