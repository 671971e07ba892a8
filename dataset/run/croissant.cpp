#include "dataset/run/croissant.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <map>
#include <regex>
#include <string_view>

#include "core/hash.hpp"
#include "core/hdf5.hpp"
#include "scene/columns.hpp"

namespace carillon::dataset::run {

using nlohmann::ordered_json;

namespace {

/// The context of the specification's Appendix 1, but for what mlcroissant has otherwise, as
/// published descriptions do: schema.org by https (readers compare addresses letter by letter), and
/// the term `samplingRate`.
ordered_json context() {
  ordered_json context = {{"@language", "en"}, {"@vocab", "https://schema.org/"}};
  for (const char* term :
       {"annotation",         "arrayShape", "citeAs",     "column",   "containedIn",
        "equivalentProperty", "excludes",   "extract",    "field",    "fileProperty",
        "fileObject",         "fileSet",    "format",     "includes", "isArray",
        "isLiveDataset",      "jsonPath",   "key",        "md5",      "parentField",
        "readLines",          "recordSet",  "references", "regex",    "samplingRate",
        "sdVersion",          "separator",  "source",     "subField", "transform",
        "unArchive",          "value"}) {
    context[term] = fmt::format("cr:{}", term);
  }
  context["conformsTo"] = "dct:conformsTo";
  context["cr"] = "http://mlcommons.org/croissant/";
  context["rai"] = "http://mlcommons.org/croissant/RAI/";
  context["data"] = {{"@id", "cr:data"}, {"@type", "@json"}};
  context["dataType"] = {{"@id", "cr:dataType"}, {"@type", "@vocab"}};
  context["dct"] = "http://purl.org/dc/terms/";
  context["examples"] = {{"@id", "cr:examples"}, {"@type", "@json"}};
  context["sc"] = "https://schema.org/";
  return context;
}

/// The specification asks for an address. An identifier of SPDX's list, which has one, is told by
/// its version, CC-BY-4.0; of those without any, by name.
std::string license_address(const std::string& license) {
  static const std::regex identifier(R"((?:[A-Za-z0-9]+-)+[0-9][A-Za-z0-9.-]*|MIT|ISC|Unlicense)");
  return std::regex_match(license, identifier) ? "https://spdx.org/licenses/" + license : license;
}

}  // namespace

ordered_json croissant_about(const std::string& name, const configuration::About& about) {
  ordered_json said = {{"name", name}};
  const auto say = [&](const char* property, const std::string& text) {
    if (!text.empty()) said[property] = text;
  };
  say("description", about.description);
  say("license", license_address(about.license));
  say("url", about.url);
  say("version", about.version);
  say("datePublished", about.published);
  say("citeAs", about.cite_as);
  for (const std::string& creator : about.creators) {
    said["creator"].push_back({{"@type", "sc:Person"}, {"name", creator}});
  }
  return said;
}

ordered_json croissant_head(const std::string& name, const configuration::About& about,
                            const std::string& what) {
  ordered_json head = {{"@context", context()},
                       {"@type", "sc:Dataset"},
                       {"name", name},
                       {"conformsTo", "http://mlcommons.org/croissant/1.1"},
                       {"description", what}};
  head.update(croissant_about(name, about));
  return head;
}

namespace {

std::string mime_type(const std::string& path) {
  static const std::map<std::string, const char*> types = {
      {".wav", "audio/wav"},         {".png", "image/png"},
      {".mp4", "video/mp4"},         {".csv", "text/csv"},
      {".tar", "application/x-tar"}, {".json", "application/json"},
      {".md", "text/markdown"},      {".jsonl", "application/jsonlines"}};
  const auto found = types.find(std::filesystem::path(path).extension().string());
  return found != types.end() ? found->second : "application/x-hdf5";
}

}  // namespace

ordered_json croissant_file(const std::string& path, const std::string& sha256,
                            std::uintmax_t bytes) {
  return {{"@type", "cr:FileObject"},
          {"@id", path},
          {"name", path},
          {"contentUrl", path},
          {"contentSize", fmt::format("{} B", bytes)},
          {"encodingFormat", mime_type(path)},
          {"sha256", sha256}};
}

ordered_json croissant_files(const std::string& id, const std::string& mime_type,
                             const ordered_json& includes) {
  return {{"@type", "cr:FileSet"},
          {"@id", id},
          {"name", id},
          {"encodingFormat", mime_type},
          {"includes", includes}};
}

ordered_json croissant_records(const std::string& id, const std::string& description,
                               ordered_json fields) {
  return {{"@type", "cr:RecordSet"},
          {"@id", id},
          {"name", id},
          {"description", description},
          {"key", {{"@id", id + "/key"}}},
          {"field", std::move(fields)}};
}

ordered_json croissant_field(const std::string& record_set, const std::string& name,
                             const std::string& type, const std::string& description,
                             const ordered_json& source) {
  ordered_json field = {{"@type", "cr:Field"},
                        {"@id", record_set + "/" + name},
                        {"name", name},
                        {"description", description},
                        {"dataType", type}};
  if (!source.is_null()) field["source"] = source;
  return field;
}

std::string croissant_column_text(const std::string& name, const std::string& unit) {
  // Tables have a cell for each number of a row, as in support_force_2.
  std::string_view column = name;
  const core::ColumnRule* rule = core::find_rule(scene::columns(), column);
  while (rule == nullptr && column.find('_') != std::string_view::npos) {
    column = column.substr(0, column.rfind('_'));
    rule = core::find_rule(scene::columns(), column);
  }
  std::string text = rule == nullptr ? fmt::format("column {}", name) : rule->meaning;
  std::erase(text, '`');
  return unit == "1" ? text : fmt::format("{}, in {}", text, unit);
}

namespace {

/// A column of the index: one value a sample, or an array.
ordered_json column_field(const core::Hdf5Group& index, const std::string& name) {
  const std::string type = index.element_type(name);
  const std::string unit = type == "text" ? "1" : index.text_attribute("unit", name);
  ordered_json field =
      croissant_field("samples", name, croissant_type(type), croissant_column_text(name, unit),
                      {{"fileObject", {{"@id", "index.h5"}}}, {"extract", {{"column", name}}}});
  const core::Extent extent = index.extent(name);
  if (extent.size() > 1) {
    field["isArray"] = true;
    field["arrayShape"] = fmt::format("{}", fmt::join(extent.begin() + 1, extent.end(), ","));
  }
  return field;
}

}  // namespace

std::string samples_sentence(std::size_t samples) {
  return fmt::format("{} sounds of struck objects, synthesized from their modes by Carillon",
                     samples);
}

ordered_json dataset_croissant(const std::filesystem::path& folder,
                               const nlohmann::json& description) {
  ordered_json document = croissant_head(
      description.at("name"),
      configuration::about_from(description.value("about", nlohmann::json::object())),
      samples_sentence(description.at("samples")));
  const std::filesystem::path index_file = folder / "index.h5";
  ordered_json distribution = ordered_json::array();
  distribution.push_back(croissant_file("index.h5", core::sha256_file(index_file),
                                        std::filesystem::file_size(index_file)));
  for (const nlohmann::json& file : description.at("files")) {
    const std::string path = file.at("path");
    distribution.push_back(croissant_file(path, file.at("sha256"), file.at("bytes")));
  }
  document["distribution"] = std::move(distribution);
  ordered_json fields = ordered_json::array();
  const core::Hdf5Group index = core::Hdf5Group::open_file(index_file);
  for (const std::string& name : index.names()) {
    if (!index.is_group(name)) fields.push_back(column_field(index, name));
  }
  if (fields.empty()) return document;
  document["recordSet"].push_back(
      croissant_records("samples", "a row of index.h5 for each sample", std::move(fields)));
  return document;
}

std::string croissant_type(const std::string& element_type) {
  if (element_type == "text") return "sc:Text";
  return element_type.starts_with("float") ? "sc:Float" : "sc:Integer";
}

}  // namespace carillon::dataset::run
