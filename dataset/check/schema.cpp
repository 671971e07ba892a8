#include "dataset/check/schema.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <map>

#include "core/error.hpp"
#include "dataset/check/detail/column_rules.hpp"
#include "scene/columns.hpp"

namespace carillon::dataset::check {

using core::Hdf5Group;

namespace {

/// What a column is in one file.
struct Kind {
  std::string type;
  core::Extent inner;
  std::string unit;
  bool operator==(const Kind&) const = default;
  std::string text() const {
    return fmt::format("{}[{}] in \"{}\"", type, fmt::join(inner, ", "), unit);
  }
};

/// @param rows  takes the first extent
Kind kind_of(const Hdf5Group& file, const std::string& column, std::uint64_t& rows) {
  Kind kind;
  kind.inner = file.extent(column);
  rows = kind.inner.empty() ? 0 : kind.inner.front();
  if (!kind.inner.empty()) kind.inner.erase(kind.inner.begin());
  kind.type = file.element_type(column);
  try {
    kind.unit = file.text_attribute("unit", column);
  } catch (const core::Error&) {
    kind.unit = "(none)";
  }
  return kind;
}

/// Columns by name; of the first shard, the measure of the others.
using Kinds = std::map<std::string, Kind>;

Kinds check_shard(const Hdf5Group& file, const configuration::BuildConfig& config,
                  std::size_t count, std::vector<std::string>& items) {
  Kinds kinds;
  for (const std::string& column : file.names()) {
    const core::ColumnRule* rule = core::find_rule(scene::columns(), column);
    if (rule == nullptr || expected(*rule, config) == false) {
      items.push_back(rule == nullptr
                          ? fmt::format("{}: is no column of a dataset (docs/format.md)", column)
                          : fmt::format("{}: its effect is off in the configuration", column));
      continue;
    }
    std::uint64_t rows = 0;
    const Kind kind = kind_of(file, column, rows);
    const std::string broken = break_of(*rule, config, kind.type, kind.inner, kind.unit);
    if (!broken.empty()) items.push_back(fmt::format("{}: {}", column, broken));
    if (rows != count) items.push_back(fmt::format("{}: {} rows, not {}", column, rows, count));
    kinds[column] = kind;
  }
  for (const core::ColumnRule& rule : scene::columns()) {
    const std::string name = std::string(rule.name) == "alpha" ? "alpha1" : rule.name;
    if (expected(rule, config) == true && !kinds.contains(name)) {
      items.push_back(name + ": is missing");
    }
  }
  const double rate = file.number_attribute("sample_rate_hz");
  if (rate != config.scene.audio.sample_rate) {
    items.push_back(
        fmt::format("sample_rate_hz is {}, not {}", rate, config.scene.audio.sample_rate));
  }
  return kinds;
}

void compare_kinds(const Kinds& kinds, const Kinds& first, const std::string& of_first,
                   std::vector<std::string>& items) {
  for (const auto& [name, kind] : first) {
    const auto here = kinds.find(name);
    if (here == kinds.end()) {
      items.push_back(fmt::format("{}: is missing; {} has it", name, of_first));
    } else if (here->second != kind) {
      items.push_back(
          fmt::format("{}: {}, but {} in {}", name, here->second.text(), kind.text(), of_first));
    }
  }
  for (const auto& [name, kind] : kinds) {
    if (!first.contains(name)) {
      items.push_back(fmt::format("{}: is not in {}", name, of_first));
    }
  }
}

}  // namespace

Finding check_schema(const DatasetFolder& folder, std::vector<std::size_t>& readable) {
  const run::LoadedBuild& build = folder.dataset.build;
  std::vector<std::string> items;
  Kinds first;
  std::string of_first;
  for (const std::size_t t : folder.present) {
    std::vector<std::string> here;
    try {
      const Hdf5Group file = Hdf5Group::open_file(folder.dataset.folder / folder.path_of(t));
      const Kinds kinds = check_shard(file, build.config, build.plan.tasks[t].count, here);
      if (of_first.empty()) {
        first = kinds;
        of_first = folder.path_of(t);
      }
      compare_kinds(kinds, first, of_first, here);
      if (here.empty()) readable.push_back(t);
      for (const std::string& item : here) items.push_back(folder.path_of(t) + ": " + item);
    } catch (const core::Error& error) {
      items.push_back(error.message());
    }
  }
  return judged("schema", std::move(items),
                fmt::format("{} columns, alike in {} shards", first.size(), folder.present.size()),
                "shards are not as docs/format.md describes them",
                "delete these shards and run the build again into this folder");
}

}  // namespace carillon::dataset::check
