#include <fmt/format.h>
#include <fmt/ranges.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <fstream>
#include <iterator>
#include <map>
#include <set>
#include <span>

#include "core/error.hpp"
#include "core/files.hpp"
#include "core/progress.hpp"
#include "dataset/exporters/export.hpp"
#include "dataset/stored/sample_audio.hpp"

namespace carillon::dataset::exporters {

namespace fs = std::filesystem;
using nlohmann::ordered_json;

namespace {

/// Rows that are read in one go.
constexpr std::size_t block_rows = 64;

void write_sounds(const Export& task) {
  const stored::SampleAudio audio(task.index);
  core::Progress progress("export", static_cast<double>(task.rows.size()), task.rank != 0,
                          "sounds");
  for (std::size_t first = 0; first < task.rows.size(); first += block_rows) {
    if (!task.is_own(first / block_rows)) continue;
    const std::size_t count = std::min(block_rows, task.rows.size() - first);
    const std::vector<core::AudioClip> clips = audio.read(first, count);
    for (std::size_t i = 0; i < count; ++i) {
      const std::size_t row = first + i;
      const fs::path path = task.output / sound_path(task.rows, row);
      fs::create_directories(path.parent_path());
      core::write_wav(path, clips[i], audio.format());
      // Neighbours are of one object: when they were written tells nothing.
      if (task.rows.is_hidden(row)) fs::last_write_time(path, fs::file_time_type());
    }
    progress.update(static_cast<double>(first + count), task.rows.key(first));
  }
  progress.finish("");
}

/// A part's table, row by row: of a large set it is gigabytes.
/// @return labels that have a value in any of the rows
std::set<std::string> write_table(const ExportedRows& all, std::span<const std::size_t> rows,
                                  const fs::path& path) {
  std::ofstream table(path, std::ios::binary);
  std::set<std::string> told;
  LabelStream labels(all, rows);
  for (const std::size_t row : rows) {
    ordered_json line = {{"file_name", all.key(row) + ".wav"}};
    for (const auto& [label, value] : labels.next().items()) {
      if (!value.is_null()) told.insert(label);
      line[label] = value;
    }
    table << line.dump() << '\n';
  }
  table.close();
  if (!table) throw core::FileError(fmt::format("{}: cannot be written", path.string()));
  return told;
}

/// AudioFolder takes types from each part's table alone, and refuses tables that differ.
void warn_of_empty_columns(const std::map<std::string, std::set<std::string>>& told) {
  std::set<std::string> of_any;
  for (const auto& [part, labels] : told) of_any.insert(labels.begin(), labels.end());
  for (const auto& [part, labels] : told) {
    std::vector<std::string> empty;
    std::set_difference(of_any.begin(), of_any.end(), labels.begin(), labels.end(),
                        std::back_inserter(empty));
    if (empty.empty()) continue;
    spdlog::warn(
        "{} has no value of {}, which other parts have: Hugging Face's audiofolder takes such "
        "tables "
        "for different; docs/exports.md has the lines that write Parquet",
        part, fmt::join(empty, ", "));
  }
}

std::vector<ExportedFile> write_metadata(const Export& task) {
  std::vector<ExportedFile> files;
  std::map<std::string, std::set<std::string>> told;
  for (const auto& [part, rows] : task.rows.by_part()) {
    const std::string path = part + "/metadata.jsonl";
    const std::span<const std::size_t> own = rows;
    core::write_durably(task.output / path, [&, &name = part](const fs::path& temporary) {
      told[name] = write_table(task.rows, own, temporary);
    });
    files.push_back(exported_file(task.output, path));
  }
  warn_of_empty_columns(told);
  return files;
}

}  // namespace

std::string sound_path(const ExportedRows& rows, std::size_t row) {
  return fmt::format("{}/{}.wav", rows.part(row), rows.key(row));
}

std::vector<ExportedFile> write_audio_folder(const Export& task) {
  write_sounds(task);
  return task.rank == 0 ? write_metadata(task) : std::vector<ExportedFile>{};
}

}  // namespace carillon::dataset::exporters
