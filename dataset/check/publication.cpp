#include "dataset/check/publication.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <set>

#include "core/json.hpp"
#include "dataset/run/croissant.hpp"

namespace carillon::dataset::check {

using nlohmann::json;

namespace {

/// Names of all fields of the description's records.
std::set<std::string> described_columns(const json& document) {
  std::set<std::string> names;
  for (const json& records : document.value("recordSet", json::array())) {
    for (const json& field : records.value("field", json::array())) {
      names.insert(field.value("name", ""));
    }
  }
  return names;
}

/// Columns that only one of description and index has; that there is no index is for another check.
std::vector<std::string> other_columns(const json& document, const std::filesystem::path& file) {
  if (!std::filesystem::is_regular_file(file)) return {};
  std::set<std::string> described = described_columns(document);
  std::vector<std::string> other;
  const core::Hdf5Group index = core::Hdf5Group::open_file(file);
  for (const std::string& name : index.names()) {
    if (!index.is_group(name) && described.erase(name) == 0) other.push_back(name);
  }
  other.insert(other.end(), described.begin(), described.end());
  return other;
}

}  // namespace

Finding check_publication(const DatasetFolder& folder) {
  const json& stored = folder.dataset.description;
  if (folder.building) return {"publication", Verdict::note, "a build is writing it", "", {}};
  if (!stored.is_object()) return {"publication", Verdict::note, "see configuration", "", {}};
  const std::filesystem::path path = folder.dataset.folder / "croissant.json";
  const std::string remedy = "run the build again into this folder: it writes the file anew";
  if (!std::filesystem::exists(path)) {
    return judged("publication", {"croissant.json is not there"}, "", "it is not described",
                  remedy);
  }
  const configuration::About about =
      configuration::about_from(stored.value("about", json::object()));
  const json document = core::read_json(path);
  std::vector<std::string> wrong;
  // How a version of this program puts it beyond that is no fault of a dataset.
  const nlohmann::ordered_json said = run::croissant_about(stored.at("name"), about);
  for (const auto& [property, value] : said.items()) {
    if (!document.is_object() || document.value(property, json()) != json(value)) {
      wrong.push_back(fmt::format("croissant.json: {}", property));
    }
  }
  if (wrong.empty()) {
    for (const std::string& name : other_columns(document, folder.dataset.folder / "index.h5")) {
      wrong.push_back(fmt::format("croissant.json: column {}", name));
    }
  }
  if (!wrong.empty()) {
    return judged("publication", std::move(wrong), "",
                  "croissant.json does not say what dataset.json and index.h5 do", remedy);
  }
  const std::vector<std::string> missing = configuration::missing_keys(about);
  if (missing.empty()) {
    return {
        "publication", Verdict::pass, "croissant.json says all that a publication needs", "", {}};
  }
  return {"publication",
          Verdict::note,
          fmt::format("to be published it lacks {}: keys of `dataset:` in the configuration",
                      fmt::join(missing, ", ")),
          "",
          {}};
}

}  // namespace carillon::dataset::check
