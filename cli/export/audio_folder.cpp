#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <map>

#include "cli/dataset/sample_audio.hpp"
#include "cli/export/export.hpp"
#include "core/files.hpp"
#include "core/progress.hpp"

namespace carillon::cli {

namespace fs = std::filesystem;

namespace {

/// Rows that are read in one go.
constexpr std::size_t block_rows = 64;

void write_sounds(const Export& task) {
  const SampleAudio audio(task.index);
  core::Progress progress("export", static_cast<double>(task.rows.size()),
                          task.quiet || task.rank != 0);
  for (std::size_t first = 0; first < task.rows.size(); first += block_rows) {
    if (!task.is_own(first / block_rows)) continue;
    const std::size_t count = std::min(block_rows, task.rows.size() - first);
    const std::vector<core::AudioClip> clips = audio.read(first, count);
    for (std::size_t i = 0; i < count; ++i) {
      const std::size_t row = first + i;
      const fs::path path = task.output / task.rows.part(row) / (task.rows.key(row) + ".wav");
      fs::create_directories(path.parent_path());
      core::write_wav(path, clips[i], audio.format());
    }
    progress.update(static_cast<double>(first + count), task.rows.key(first));
  }
  progress.finish("");
}

/// One table for each part.
std::vector<ExportedFile> write_metadata(const Export& task) {
  std::string header = "file_name";
  for (const ExportedRows::Column& column : task.rows.columns()) {
    header += "," + csv_cell(column.name);
  }
  std::map<std::string, std::string> tables;
  for (std::size_t row = 0; row < task.rows.size(); ++row) {
    std::string& table = tables[task.rows.part(row)];
    if (table.empty()) table = header + "\n";
    table += csv_cell(task.rows.key(row) + ".wav");
    const nlohmann::ordered_json values = task.rows.values(row);
    for (const nlohmann::ordered_json& value : values) table += "," + csv_cell(value);
    table += "\n";
  }
  std::vector<ExportedFile> files;
  for (const auto& [part, table] : tables) {
    const std::string path = part + "/metadata.csv";
    core::write_text_durably(task.output / path, table);
    files.push_back(exported_file(task.output, path));
  }
  return files;
}

}  // namespace

std::vector<ExportedFile> write_audio_folder(const Export& task) {
  write_sounds(task);
  return task.rank == 0 ? write_metadata(task) : std::vector<ExportedFile>{};
}

}  // namespace carillon::cli
