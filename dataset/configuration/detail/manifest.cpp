#include "dataset/configuration/detail/manifest.hpp"

#include <fmt/format.h>

#include <filesystem>
#include <set>
#include <string_view>

#include "core/csv.hpp"
#include "core/error.hpp"
#include "core/text.hpp"
#include "core/units.hpp"
#include "solvers/mesh/readers/read_mesh.hpp"

namespace carillon::dataset::configuration {

namespace {

constexpr std::size_t shown_rows = 20;

/// Cells of a row by the names of their columns.
class Row {
 public:
  Row(const core::CsvTable& table, const core::CsvRow& row) : table_(table), row_(row) {}

  /// "" for a column that is not there or a cell that is empty.
  std::string cell(std::string_view column) const {
    const auto number = table_.column(column);
    return number && *number < row_.cells.size() ? row_.cells[*number] : "";
  }

  /// Length [m]; 0 for none.
  double length(std::string_view column) const {
    const std::string text = cell(column);
    if (text.empty()) return 0;
    const double value = core::parse_quantity(text, core::Dimension::length);
    if (!(value > 0)) throw core::InputError(fmt::format("{}: a length is positive", text));
    return value;
  }

 private:
  const core::CsvTable& table_;
  const core::CsvRow& row_;
};

/// Columns that mean something to a build.
const std::set<std::string, std::less<>> own_columns = {
    "file", "length", "unit", "thickness", "material", "node", "name", "family", "split"};

/// What `read` throws names its column.
void in_column(const char* column, const std::function<void()>& read) {
  try {
    read();
  } catch (const core::Error& error) {
    throw core::InputError(fmt::format("{}: {}", column, error.message()), error.hint());
  }
}

void read_part(const std::string& text, ManifestRow& row) {
  if (text.empty() || text == "train" || text == "validation" || text == "test") {
    row.part = text;
  } else {
    throw core::InputError(fmt::format("\"{}\" is no part", text), "train, validation or test");
  }
}

ObjectSource source_of(const ObjectSource& entry, const Row& row,
                       const std::vector<synth::material::Material>& own) {
  ObjectSource source = entry;
  scene::Object& object = source.object;
  ManifestRow& said = source.row.emplace();
  in_column("file", [&] {
    if (row.cell("file").empty()) throw core::InputError("is empty");
    object.pattern = (std::filesystem::path(object.manifest_folder) / row.cell("file"))
                         .lexically_normal()
                         .string();
    solvers::mesh::readers::kind_of(object.pattern);
  });
  in_column("length", [&] {
    if (const double length = row.length("length"); length > 0) object.file.length = length;
  });
  in_column("unit", [&] {
    if (row.cell("unit").empty()) return;
    if (!row.cell("length").empty())
      throw core::InputError("there is a length already", "a row has a length or a unit");
    object.file.unit = core::parse_unit_of_length(row.cell("unit"));
    object.file.length = 0;
  });
  in_column("thickness", [&] {
    if (const double length = row.length("thickness"); length > 0) object.file.thickness = length;
  });
  in_column("material", [&] {
    const std::string material = row.cell("material");
    if (material.empty() && object.materials.empty() && object.groups.empty())
      throw core::InputError("is empty", "name one here, or `materials:` beside the manifest");
    if (material.empty()) return;
    synth::material::parse_material(material, own);
    object.materials = {material};
    object.groups.clear();
  });
  if (!row.cell("node").empty()) object.nodes = {false, {row.cell("node")}};
  said.name = row.cell("name");
  said.family = row.cell("family");
  in_column("split", [&] { read_part(row.cell("split"), said); });
  return source;
}

/// Labels become columns of the dataset.
void check_label(const std::string& column, const std::string& manifest) {
  const auto is_plain = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_';
  };
  if (!column.empty() && std::all_of(column.begin(), column.end(), is_plain)) return;
  throw core::InputError(
      fmt::format("{}: a label cannot be named \"{}\"", manifest, column),
      "a column's name has letters, digits and _; one that is no label must not stand there");
}

}  // namespace

std::vector<ObjectSource> rows_of_manifest(const ObjectSource& entry,
                                           const std::vector<synth::material::Material>& own) {
  const std::string& manifest = entry.object.manifest;
  const core::CsvTable table = core::read_csv(manifest, '#');
  if (!table.column("file")) {
    throw core::InputError(fmt::format("{} has no column file", manifest),
                           "its first line names the columns: file, and as wanted length or unit, "
                           "thickness, material, "
                           "node, name, family, split; any other is a label");
  }
  std::vector<std::string> labels;
  for (const std::string& column : table.head.cells) {
    if (own_columns.contains(column)) continue;
    check_label(column, manifest);
    labels.push_back(column);
  }
  std::vector<ObjectSource> sources;
  std::vector<std::string> wrong;
  for (const core::CsvRow& cells : table.rows) {
    const Row row(table, cells);
    try {
      sources.push_back(source_of(entry, row, own));
      sources.back().row->place = cells.place;
      for (const std::string& label : labels) sources.back().row->labels[label] = row.cell(label);
    } catch (const core::Error& error) {
      wrong.push_back(fmt::format("{}: {}{}", cells.place, error.message(),
                                  error.hint().empty() ? "" : " (" + error.hint() + ")"));
    }
  }
  if (table.rows.empty()) throw core::InputError(fmt::format("{} has no rows", manifest));
  if (wrong.empty()) return sources;
  std::string all = fmt::format("{} of {} rows are wrong", wrong.size(), table.rows.size());
  for (std::size_t i = 0; i < std::min(wrong.size(), shown_rows); ++i) all += "\n  " + wrong[i];
  if (wrong.size() > shown_rows) all += fmt::format("\n  and {} more", wrong.size() - shown_rows);
  throw core::InputError(all);
}

}  // namespace carillon::dataset::configuration
