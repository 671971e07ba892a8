#include <fmt/format.h>

#include "core/hash.hpp"
#include "dataset/exporters/export.hpp"
#include "dataset/run/croissant.hpp"

namespace carillon::dataset::exporters {

using nlohmann::ordered_json;

namespace {

/// A label: its type, and what its numbers are in.
ordered_json label_field(const ExportedRows::Column& column, const std::string& label,
                         const ordered_json& source) {
  return run::croissant_field("labels", label, run::croissant_type(column.type),
                              run::croissant_column_text(column.name, column.unit), source);
}

/// What a value of 1 in a sound file is.
std::string sound_text(const core::Hdf5Group& index) {
  return fmt::format(
      "the sound, a channel for each listener: {} times the gain of {} {}, full scale 1",
      index.text_attribute("unit", "audio"), index.read_rows<double>("gain", 0, 1).front(),
      index.text_attribute("unit", "gain"));
}

}  // namespace

ExportedFile exported_file(const std::filesystem::path& folder, const std::string& path) {
  return {path, core::sha256_file(folder / path), std::filesystem::file_size(folder / path)};
}

ordered_json croissant_of(ordered_json head, const std::string& format,
                          const std::vector<ExportedFile>& files, const ExportedRows& rows,
                          const core::Hdf5Group& index) {
  const bool tables = format != "webdataset";
  ordered_json distribution = ordered_json::array(), archives = ordered_json::array();
  for (const ExportedFile& file : files) {
    distribution.push_back(run::croissant_file(file.path, file.sha256, file.bytes));
    if (file.path.ends_with(".tar")) archives.push_back({{"@id", file.path}});
  }
  ordered_json sounds = run::croissant_files("sounds", "audio/wav", "*.wav");
  ordered_json labels =
      tables ? run::croissant_files("label-files", "application/jsonlines", "*/metadata.jsonl")
             : run::croissant_files("label-files", "application/json", "*.json");
  if (!tables) sounds["containedIn"] = labels["containedIn"] = archives;
  distribution.push_back(std::move(sounds));
  distribution.push_back(std::move(labels));

  ordered_json label_fields = ordered_json::array();
  // A tar's members are named by the keys, files lie in their part's folder: the first of such a
  // name on the way, as an object may be called so too.
  const ordered_json from_path = {
      {"fileSet", {{"@id", "sounds"}}},
      {"extract", {{"fileProperty", "fullpath"}}},
      {"transform",
       {{"regex",
         tables ? R"(^(?:.*?/)??(?:train|validation|test)/(.*)\.wav$)" : R"(^(.*)\.wav$)"}}}};
  ordered_json key =
      run::croissant_field("samples", "key", "sc:Text", "names the sample", from_path);
  key["references"] = {{"@id", "labels/key"}};
  ordered_json audio = run::croissant_field(
      "samples", "audio", "sc:AudioObject", sound_text(index),
      {{"fileSet", {{"@id", "sounds"}}},
       {"extract", {{"fileProperty", "content"}}},
       {"samplingRate", static_cast<int>(index.number_attribute("sample_rate_hz"))}});
  ordered_json sample_fields = ordered_json::array();
  sample_fields.push_back(std::move(key));
  sample_fields.push_back(std::move(audio));
  for (const ExportedRows::Column& column : rows.columns()) {
    for (const std::string& label : column.labels) {
      const ordered_json extract =
          tables ? ordered_json{{"column", label}} : ordered_json{{"jsonPath", "$." + label}};
      label_fields.push_back(label_field(
          column, label, {{"fileSet", {{"@id", "label-files"}}}, {"extract", extract}}));
      if (label == "key") continue;
      ordered_json joined = label_fields.back();
      joined["@id"] = "samples/" + label;
      joined["source"] = {{"@id", "labels/" + label}};
      sample_fields.push_back(std::move(joined));
    }
  }
  head["distribution"] = std::move(distribution);
  head["recordSet"].push_back(
      run::croissant_records("labels", "what is known of each sample", std::move(label_fields)));
  head["recordSet"].push_back(
      run::croissant_records("samples", "sounds with their labels", std::move(sample_fields)));
  return head;
}

}  // namespace carillon::dataset::exporters
