#include "dataset/exporters/detail/card_header.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <regex>

#include "dataset/exporters/detail/hub_license.hpp"
#include "dataset/stored/shared_rows.hpp"

namespace carillon::dataset::exporters {

namespace {

/// A scalar of YAML: as it is where nothing in it has a meaning, else in quotes, as JSON has them.
std::string yaml_text(const std::string& text) {
  static const std::regex plain("[A-Za-z_][A-Za-z0-9_./*-]*");
  static const std::regex word("(true|false|yes|no|on|off|null|y|n)", std::regex::icase);
  if (std::regex_match(text, plain) && !std::regex_match(text, word)) return text;
  return nlohmann::json(text).dump();
}

/// The Hub's names for how many samples there are.
std::string size_category(std::size_t samples) {
  struct Category {
    std::size_t below;
    const char* name;
  };
  static constexpr std::array<Category, 6> categories = {{{1000, "n<1K"},
                                                          {10'000, "1K<n<10K"},
                                                          {100'000, "10K<n<100K"},
                                                          {1'000'000, "100K<n<1M"},
                                                          {10'000'000, "1M<n<10M"},
                                                          {100'000'000, "10M<n<100M"}}};
  for (const Category& category : categories) {
    if (samples < category.below) return category.name;
  }
  return "100M<n<1B";
}

/// One feature; `margin` are the blanks before its dash.
std::string feature(const std::string& margin, const std::string& name, const std::string& type) {
  return fmt::format("{0}- name: {1}\n{0}  dtype: {2}\n", margin, yaml_text(name), type);
}

/// The labels, each with the type that it has in every part.
std::string label_features(const ExportedRows& rows, const std::string& margin) {
  std::string text;
  for (const ExportedRows::Column& column : rows.columns()) {
    const std::string type = column.type == "text" ? "string" : column.type;
    for (const std::string& label : column.labels) text += feature(margin, label, type);
  }
  return text;
}

/// A .npy member: nested lists, as the Hub's loader makes of arrays.
std::string array_feature(const std::string& name, const core::Hdf5Group& index) {
  const std::string path = stored::find_array(index, name).path;
  const std::string type = index.element_type(path);
  const std::size_t axes = index.extent(path).size() - 1;
  if (axes == 0) return feature("  ", name + ".npy", type);
  std::string text = fmt::format("  - name: {}\n", yaml_text(name + ".npy"));
  std::string margin = "    ";
  for (std::size_t axis = 1; axis < axes; ++axis, margin += "  ") text += margin + "sequence:\n";
  return text + margin + "sequence: " + type + "\n";
}

std::string features(const CardSource& source, const ExportedRows& rows,
                     const core::Hdf5Group& index) {
  std::string text = "dataset_info:\n  features:\n";
  if (source.format == "wav")
    return text + feature("  ", "audio", "audio") + label_features(rows, "  ");
  text += feature("  ", "wav", "audio");
  text += "  - name: json\n    struct:\n" + label_features(rows, "    ");
  for (const std::string& name : source.arrays) text += array_feature(name, index);
  return text + feature("  ", "__key__", "string") + feature("  ", "__url__", "string");
}

std::string data_files(const CardSource& source, const ExportedRows& rows) {
  std::string text = "configs:\n- config_name: default\n  data_files:\n";
  for (const auto& [part, members] : parts_in_order(rows)) {
    text += fmt::format("  - split: {}\n    path: {}\n", yaml_text(part),
                        yaml_text(part + (source.format == "wav" ? "/**" : "-*.tar")));
  }
  return text;
}

std::string license_lines(const std::string& license) {
  const HubLicense hub = hub_license(license);
  std::string text = fmt::format("license: {}\n", yaml_text(hub.id));
  if (!hub.name.empty()) text += fmt::format("license_name: {}\n", yaml_text(hub.name));
  if (!hub.link.empty()) text += fmt::format("license_link: {}\n", yaml_text(hub.link));
  return text;
}

}  // namespace

std::vector<std::pair<std::string, std::vector<std::size_t>>> parts_in_order(
    const ExportedRows& rows) {
  std::vector<std::pair<std::string, std::vector<std::size_t>>> ordered;
  std::map<std::string, std::vector<std::size_t>> parts = rows.by_part();
  for (const char* first : {"train", "validation", "test"}) {
    if (auto part = parts.extract(first)) ordered.emplace_back(first, std::move(part.mapped()));
  }
  for (auto& [part, members] : parts) ordered.emplace_back(part, std::move(members));
  return ordered;
}

std::string card_header(const CardSource& source, const ExportedRows& rows,
                        const core::Hdf5Group& index) {
  const nlohmann::ordered_json about = source.said.value("about", nlohmann::ordered_json::object());
  std::string text = "---\n" + license_lines(about.value("license", ""));
  text += fmt::format("pretty_name: {}\n", yaml_text(source.name));
  text += "task_categories:\n- audio-classification\n";
  text += "tags:\n- audio\n- impact-sounds\n- modal-synthesis\n- synthetic\n";
  text += fmt::format("size_categories:\n- {}\n", yaml_text(size_category(rows.size())));
  if (source.format != "lhotse") {
    text += data_files(source, rows) + features(source, rows, index);
  }
  return text + "---\n";
}

}  // namespace carillon::dataset::exporters
