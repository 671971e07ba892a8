#include <fmt/format.h>

#include "cli/build/croissant.hpp"
#include "cli/export/export.hpp"
#include "core/hash.hpp"

namespace carillon::cli {

using nlohmann::ordered_json;

namespace {

/// A column of the labels: its type, and what its numbers are in.
ordered_json label_field(const ExportedRows::Column& column, const ordered_json& source) {
  const char* types[] = {"sc:Float", "sc:Integer", "sc:Integer", "sc:Text"};
  const std::string what = column.unit.empty() || column.unit == "1"
                               ? fmt::format("{} of the sample", column.name)
                               : fmt::format("{} of the sample, in {}", column.name, column.unit);
  return croissant_field("labels", column.name, types[column.values.index()], what, source);
}

}  // namespace

ExportedFile exported_file(const std::filesystem::path& folder, const std::string& path) {
  return {path, core::sha256_file(folder / path), std::filesystem::file_size(folder / path)};
}

ordered_json croissant_of(ordered_json head, const std::string& format,
                          const std::vector<ExportedFile>& files, const ExportedRows& rows,
                          int sample_rate) {
  const bool tables = format == "wav";
  ordered_json distribution = ordered_json::array(), archives = ordered_json::array();
  for (const ExportedFile& file : files) {
    distribution.push_back(croissant_file(file.path, tables ? "text/csv" : "application/x-tar",
                                          file.sha256, file.bytes));
    archives.push_back({{"@id", file.path}});
  }
  ordered_json sounds = croissant_files("sounds", "audio/wav", "*.wav");
  ordered_json labels = tables ? croissant_files("label-files", "text/csv", "*/metadata.csv")
                               : croissant_files("label-files", "application/json", "*.json");
  if (!tables) sounds["containedIn"] = labels["containedIn"] = archives;
  distribution.push_back(std::move(sounds));
  distribution.push_back(std::move(labels));

  ordered_json label_fields = ordered_json::array();
  // Tables lie in their part's folder and name keys; a tar's members are named by them.
  const ordered_json from_path = {
      {"fileSet", {{"@id", "sounds"}}},
      {"extract", {{"fileProperty", "fullpath"}}},
      {"transform",
       {{"regex",
         tables ? R"(^(?:.*/)?(?:train|validation|test)/(.*)\.wav$)" : R"(^(.*)\.wav$)"}}}};
  ordered_json key = croissant_field("samples", "key", "sc:Text", "names the sample", from_path);
  key["references"] = {{"@id", "labels/key"}};
  ordered_json audio = croissant_field("samples", "audio", "sc:AudioObject",
                                       "the sound, a channel for each listener",
                                       {{"fileSet", {{"@id", "sounds"}}},
                                        {"extract", {{"fileProperty", "content"}}},
                                        {"samplingRate", sample_rate}});
  ordered_json sample_fields = ordered_json::array();
  sample_fields.push_back(std::move(key));
  sample_fields.push_back(std::move(audio));
  for (const ExportedRows::Column& column : rows.columns()) {
    const ordered_json extract = tables ? ordered_json{{"column", column.name}}
                                        : ordered_json{{"jsonPath", "$." + column.name}};
    label_fields.push_back(
        label_field(column, {{"fileSet", {{"@id", "label-files"}}}, {"extract", extract}}));
    if (column.name == "key") continue;
    ordered_json joined = label_fields.back();
    joined["@id"] = "samples/" + column.name;
    joined["source"] = {{"@id", "labels/" + column.name}};
    sample_fields.push_back(std::move(joined));
  }
  head["distribution"] = std::move(distribution);
  head["recordSet"].push_back(
      croissant_records("labels", "what is known of each sample", std::move(label_fields)));
  head["recordSet"].push_back(
      croissant_records("samples", "sounds with their labels", std::move(sample_fields)));
  return head;
}

}  // namespace carillon::cli
