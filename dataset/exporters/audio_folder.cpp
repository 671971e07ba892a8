#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <span>

#include "core/csv.hpp"
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

/// A part's table, row by row: of a large set it is gigabytes.
void write_table(const ExportedRows& all, std::span<const std::size_t> rows, const fs::path& path) {
  std::ofstream table(path, std::ios::binary);
  std::vector<std::string> cells = {"file_name"};
  for (const ExportedRows::Column& column : all.columns()) {
    cells.insert(cells.end(), column.labels.begin(), column.labels.end());
  }
  table << core::csv_line(cells);
  LabelStream labels(all, rows);
  for (const std::size_t row : rows) {
    cells = {all.key(row) + ".wav"};
    for (const ordered_json& value : labels.next()) cells.push_back(core::csv_value(value));
    table << core::csv_line(cells);
  }
  table.close();
  if (!table) throw core::FileError(fmt::format("{}: cannot be written", path.string()));
}

std::vector<ExportedFile> write_metadata(const Export& task) {
  std::vector<ExportedFile> files;
  for (const auto& [part, rows] : task.rows.by_part()) {
    const std::string path = part + "/metadata.csv";
    const std::span<const std::size_t> own = rows;
    core::write_durably(task.output / path,
                        [&](const fs::path& temporary) { write_table(task.rows, own, temporary); });
    files.push_back(exported_file(task.output, path));
  }
  return files;
}

}  // namespace

std::vector<ExportedFile> write_audio_folder(const Export& task) {
  write_sounds(task);
  return task.rank == 0 ? write_metadata(task) : std::vector<ExportedFile>{};
}

}  // namespace carillon::dataset::exporters
