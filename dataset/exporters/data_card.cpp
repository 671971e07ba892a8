#include "dataset/exporters/data_card.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <map>
#include <set>

#include "core/revision.hpp"
#include "dataset/configuration/about.hpp"
#include "dataset/exporters/detail/card_header.hpp"
#include "dataset/run/croissant.hpp"
#include "dataset/stored/shared_rows.hpp"
#include "scene/columns.hpp"

namespace carillon::dataset::exporters {

using nlohmann::ordered_json;

namespace {

/// Rows of a table of classes: more are for the files.
constexpr std::size_t max_classes = 50;

/// A line of a Markdown table.
std::string table_line(const std::vector<std::string>& cells) {
  std::string line = "|";
  for (const std::string& cell : cells) {
    line += ' ';
    for (const char letter : cell) {
      if (letter == '|') line += '\\';
      line += letter == '\n' ? ' ' : letter;
    }
    line += " |";
  }
  return line + "\n";
}

std::string table_head(const std::vector<std::string>& cells) {
  return table_line(cells) + table_line(std::vector<std::string>(cells.size(), "---"));
}

/// How often each text of a column is in each part, the most frequent first.
std::string counts_table(const std::string& column, const ExportedRows& rows,
                         const core::Hdf5Group& index) {
  const auto parts = parts_in_order(rows);
  const std::vector<std::string> texts = index.read<std::string>(column);
  std::map<std::string, std::vector<std::size_t>> counts;
  for (std::size_t p = 0; p < parts.size(); ++p) {
    for (const std::size_t row : parts[p].second) {
      if (rows.is_hidden(row)) continue;
      std::vector<std::size_t>& of_text = counts[texts[row]];
      of_text.resize(parts.size());
      ++of_text[p];
    }
  }
  std::vector<std::pair<std::size_t, std::string>> order;
  for (const auto& [text, count] : counts) {
    std::size_t all = 0;
    for (const std::size_t n : count) all += n;
    order.emplace_back(all, text);
  }
  std::stable_sort(order.begin(), order.end(),
                   [](const auto& a, const auto& b) { return a.first > b.first; });
  std::vector<std::string> cells = {"`" + column + "`"};
  for (const auto& [part, members] : parts) cells.push_back(part);
  std::string text = table_head(cells);
  for (std::size_t k = 0; k < std::min(order.size(), max_classes); ++k) {
    cells = {order[k].second};
    for (const std::size_t n : counts.at(order[k].second)) cells.push_back(fmt::format("{}", n));
    text += table_line(cells);
  }
  if (order.size() > max_classes) text += fmt::format("\n{} more.\n", order.size() - max_classes);
  return text + "\n";
}

std::string parts_text(const CardSource& source, const ExportedRows& rows,
                       const core::Hdf5Group& index) {
  const std::vector<std::string> shapes =
      index.has("shape") ? index.read<std::string>("shape") : std::vector<std::string>(rows.size());
  std::string text = "## Parts\n\n" + table_head({"part", "samples", "`shape`s"});
  for (const auto& [part, members] : parts_in_order(rows)) {
    std::set<std::string> distinct;
    for (const std::size_t row : members) distinct.insert(shapes[row]);
    text +=
        table_line({part, fmt::format("{}", members.size()), fmt::format("{}", distinct.size())});
  }
  text += fmt::format("\nThe parts are those of the column `{}`. ", source.split);
  if (index.has("simulation")) {
    text +=
        "Simulations are held out as wholes; objects of `test` may be heard in `train` too.\n\n";
    return text;
  }
  if (source.split == "split_shape") {
    text += "Whole objects are held out: none of `test` is heard in `train`.\n";
  } else if (source.split == "split_strike") {
    text +=
        "Strikes of each object are held out: the objects of `test` are heard in `train` too.\n";
  }
  return text +
         "\n**Do not mix `split_shape` and `split_strike`.** They divide the same samples in two "
         "ways: what is in `test` of one may be in `train` of the other. Train, choose and test by "
         "one of them.\n\n";
}

std::string classes_text(const ExportedRows& rows, const core::Hdf5Group& index) {
  std::string text;
  for (const char* column : {"material", "family"}) {
    if (index.has(column)) text += counts_table(column, rows, index);
  }
  return text.empty() ? ""
                      : "## Classes\n\nSamples of each class in each part whose labels are "
                        "here.\n\n" +
                            text;
}

std::string sound_text(const CardSource& source, const core::Hdf5Group& index) {
  const core::Extent extent = index.extent("audio");
  const std::uint64_t channels = extent.size() > 2 ? extent[1] : 1;
  std::string text = fmt::format(
      "## Sounds\n\nWAV files of {} samples at {} Hz, {} channel{}, {}. Full scale, a value of 1, "
      "is "
      "1 / `gain` {}.\n",
      extent.back(), index.number_attribute("sample_rate_hz"), channels, channels == 1 ? "" : "s",
      index.element_type("audio") == "int16" ? "16 bits" : "32-bit floating-point",
      index.text_attribute("unit", "audio"));
  if (source.format == "lhotse") {
    return text +
           "`recordings_PART.jsonl` and `supervisions_PART.jsonl` are Lhotse's manifests, with "
           "paths from this folder; `PART/metadata.jsonl` has the columns below.\n\n";
  }
  return text +
         "\n```python\nfrom datasets import load_dataset\n\ndataset = load_dataset(\".\")  # this "
         "folder, or its name on the Hub\n```\n\n";
}

/// `position_x`, `position_y`, `position_z`; of many the first and the last.
std::string names_of(const ExportedRows::Column& column) {
  constexpr std::size_t max_named = 3;
  const std::vector<std::string>& labels = column.labels;
  if (labels.size() > max_named) {
    return fmt::format("`{}` to `{}`", labels.front(), labels.back());
  }
  return fmt::format("`{}`", fmt::join(labels, "`, `"));
}

std::string columns_text(const ExportedRows& rows) {
  std::string text =
      "## Columns\n\nA number that there is not, NaN in what follows, is null. Texts are texts "
      "also where they are digits, as `id` is.\n\n" +
      table_head({"column", "type", "unit", "meaning"});
  for (const ExportedRows::Column& column : rows.columns()) {
    const core::ColumnRule* rule = core::find_rule(scene::columns(), column.name);
    std::string meaning = rule == nullptr ? "" : rule->meaning;
    for (const stored::SharedRows& shared : stored::shared_rows())
      if (column.name == shared.column) meaning = shared.meaning;
    if (column.stored == "uint64") meaning += ", in decimal digits";
    text += table_line(
        {names_of(column), column.type == "text" ? "string" : column.type, column.unit, meaning});
  }
  return text + "\n";
}

std::string materials_table(const ordered_json& materials) {
  if (materials.empty()) return "";
  std::string text =
      "Materials:\n\n" + table_head({"material", "Young's modulus [Pa]", "Poisson's ratio",
                                     "density [kg/m^3]", "damping c(lambda) [1/s]", "source"});
  const auto number = [](const ordered_json& material, const char* key) {
    return material.contains(key) && material[key].is_number()
               ? fmt::format("{:.6g}", material[key].get<double>())
               : "";
  };
  for (const ordered_json& material : materials) {
    const ordered_json damping = material.value("damping", ordered_json::object());
    text += table_line({material.value("name", ""), number(material, "youngs_modulus_pa"),
                        number(material, "poisson_ratio"), number(material, "density_kg_m3"),
                        damping.value("formula", ""), material.value("source", "")});
  }
  return text + "\n";
}

/// Objects by family: how many, and a few of their names.
std::string objects_table(const ordered_json& shapes) {
  if (shapes.empty()) return "";
  constexpr std::size_t max_named = 5;
  std::map<std::string, std::vector<std::string>> families;
  for (const ordered_json& shape : shapes) {
    families[shape.value("family", "")].push_back(shape.value("id", ""));
  }
  std::string text = "Objects:\n\n" + table_head({"family", "objects", "names"});
  for (auto& [family, names] : families) {
    const std::size_t count = names.size();
    if (count > max_named) {
      names.resize(max_named);
      names.emplace_back("...");
    }
    text +=
        table_line({family, fmt::format("{}", count), fmt::format("{}", fmt::join(names, ", "))});
  }
  return text + "\n";
}

std::string making_text(const CardSource& source) {
  const ordered_json versions = source.said.value("versions", ordered_json::object());
  const std::string configuration = source.said.value("configuration", "");
  std::string text =
      "## How it was made\n\nThe sounds are synthesized: the modes of each object are solved by "
      "finite elements, and rung by strikes. ";
  text +=
      fmt::format("Carillon {} built the dataset{} (`carillon build`), and Carillon {} ",
                  versions.value("carillon", "of an unknown version"),
                  configuration.empty() ? "" : " from the configuration below", core::revision());
  text += fmt::format("exported it:\n\n    carillon export {} --format {} --split {}{}{}{}{}\n\n",
                      source.name, source.format, source.split,
                      source.arrays.empty() ? "" : " --with ", fmt::join(source.arrays, " "),
                      source.hidden.empty() ? "" : " --hide ", fmt::join(source.hidden, " "));
  if (!source.hidden.empty()) {
    text += fmt::format(
        "Samples of {} have no labels here, and names that tell nothing. Whoever made this scores "
        "answers for them: a CSV file with the columns `sample` (the file's name without .wav) and "
        "`class`, or one of probabilities for each class.\n\n",
        fmt::join(source.hidden, " and "));
  }
  text += materials_table(source.said.value("materials", ordered_json::array()));
  text += objects_table(source.said.value("shapes", ordered_json::array()));
  if (source.said.contains("shapes")) {
    text +=
        "`dataset.json` has every material and object in full, and versions of libraries; "
        "`croissant.json` describes the files (MLCommons Croissant).\n\n";
  }
  if (configuration.empty()) return text;
  return text + fmt::format(
                    "<details><summary>The configuration, with every default</summary>\n\n"
                    "```yaml\n{}```\n\n</details>\n\n",
                    configuration);
}

std::string license_text(const configuration::About& about) {
  std::string text = "## Licence\n\n";
  if (about.license.empty()) {
    text +=
        "None was given. Its maker chooses one: `license:` in `dataset:` of the configuration (an "
        "SPDX identifier such as CC-BY-4.0, or an address), then `carillon build` and `carillon "
        "export` again; or the header of this file, and this section.\n";
  } else {
    text += fmt::format("{}.\n", about.license);
  }
  text +=
      "\nThe dataset is its maker's own: the licence of Carillon, the program, does not extend to "
      "what is made with it. Meshes, materials and recordings that went into it may have owners.\n";
  if (!about.creators.empty()) {
    text += fmt::format("\nMade by {}.\n", fmt::join(about.creators, ", "));
  }
  if (!about.version.empty()) text += fmt::format("\nVersion {}.\n", about.version);
  if (!about.url.empty()) text += fmt::format("\n<{}>\n", about.url);
  if (!about.cite_as.empty()) {
    text += fmt::format("\nTo be cited as:\n\n```\n{}\n```\n", about.cite_as);
  }
  return text;
}

}  // namespace

std::string data_card(const CardSource& source, const ExportedRows& rows,
                      const core::Hdf5Group& index) {
  const configuration::About about =
      configuration::about_from(source.said.value("about", ordered_json::object()));
  const std::string what =
      about.description.empty() ? run::samples_sentence(rows.size()) + "." : about.description;
  return card_header(source, rows, index) + fmt::format("\n# {}\n\n{}\n\n", source.name, what) +
         parts_text(source, rows, index) + classes_text(rows, index) + sound_text(source, index) +
         columns_text(rows) + making_text(source) + license_text(about);
}

}  // namespace carillon::dataset::exporters
