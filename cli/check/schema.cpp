#include "cli/check/schema.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <map>

#include "cli/check/column_rules.hpp"
#include "core/error.hpp"

namespace carillon::cli {

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

Kinds check_shard(const Hdf5Group& file, const BuildConfig& config, std::size_t count,
                  std::vector<std::string>& items) {
  Kinds kinds;
  for (const std::string& column : file.names()) {
    const ColumnRule* rule = find_rule(column);
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
  for (const ColumnRule& rule : column_rules()) {
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
  const LoadedBuild& build = folder.dataset.build;
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

namespace {

void check_sources(const Hdf5Group& index, const DatasetFolder& folder,
                   const std::vector<std::size_t>& tasks, const std::string& column,
                   std::vector<std::string>& items) {
  const auto sources = index.virtual_sources(column);
  if (sources.size() != tasks.size()) {
    items.push_back(
        fmt::format("{}: joins {} shards, there are {}", column, sources.size(), tasks.size()));
    return;
  }
  for (std::size_t i = 0; i < sources.size(); ++i) {
    const auto& source = sources[i];
    if (source.file != folder.path_of(tasks[i]) || source.dataset != column ||
        source.rows != folder.dataset.build.plan.tasks[tasks[i]].count) {
      items.push_back(fmt::format("{}: block {} is {} rows of {}:{}, not {}", column, i,
                                  source.rows, source.file, source.dataset,
                                  folder.path_of(tasks[i])));
      return;
    }
  }
}

/// Texts are copied into the index: they must be those of the shards.
void check_texts(const Hdf5Group& index, const DatasetFolder& folder,
                 const std::vector<std::size_t>& tasks, const std::string& column,
                 std::vector<std::string>& items) {
  const auto all = index.read<std::string>(column);
  std::vector<std::string> shards;
  for (const std::size_t t : tasks) {
    const auto own =
        Hdf5Group::open_file(folder.dataset.folder / folder.path_of(t)).read<std::string>(column);
    shards.insert(shards.end(), own.begin(), own.end());
  }
  const auto differ = std::mismatch(all.begin(), all.end(), shards.begin(), shards.end());
  if (differ.first == all.end()) return;
  items.push_back(
      fmt::format("{}: row {} is not what the shard holds", column, differ.first - all.begin()));
}

/// What is read through the index against the shards themselves.
void check_values(const Hdf5Group& index, const DatasetFolder& folder,
                  const std::vector<std::size_t>& tasks, std::vector<std::string>& items) {
  const auto ids = index.read<std::uint64_t>("id");
  const auto texts = [&](const std::string& name) { return index.read<std::string>(name); };
  const auto keys = texts("key"), shapes = texts("shape"), names = texts("shapes/shape");
  const auto bodies = index.read<std::int64_t>("shape_index");
  std::uint64_t row = 0;
  for (const std::size_t t : tasks) {
    const Hdf5Group shard = Hdf5Group::open_file(folder.dataset.folder / folder.path_of(t));
    const auto own_ids = shard.read<std::uint64_t>("id");
    const auto own_keys = shard.read<std::string>("key");
    for (std::size_t i = 0; i < own_ids.size(); ++i, ++row) {
      if (row >= ids.size() || row >= keys.size() || row >= bodies.size()) break;
      const auto body = static_cast<std::size_t>(bodies[row]);
      if (ids[row] == own_ids[i] && keys[row] == own_keys[i] && body < names.size() &&
          names[body] == shapes[row]) {
        continue;
      }
      items.push_back(fmt::format("row {}: is not sample {} of {}", row, i, folder.path_of(t)));
      break;
    }
    const std::uint64_t begin = row - own_ids.size();
    if (!own_ids.empty() &&
        index.read_rows<float>("audio", begin, 1) != shard.read_rows<float>("audio", 0, 1)) {
      items.push_back(fmt::format("row {}: other audio than in {}", begin, folder.path_of(t)));
    }
  }
  if (row != ids.size()) {
    items.push_back(fmt::format("{} rows, the shards have {}", ids.size(), row));
  }
}

}  // namespace

Finding check_index(const DatasetFolder& folder, const std::vector<std::size_t>& readable) {
  std::vector<std::string> items;
  const auto path = folder.dataset.folder / "index.h5";
  const std::string remedy = "run the build again into this folder: it writes the index anew";
  if (!std::filesystem::is_regular_file(path)) {
    if (folder.building) return {"index", Verdict::note, "not written yet", "", {}};
    return judged("index", {"index.h5 is not there"}, "", "there is no index", remedy);
  }
  std::size_t rows = 0;
  try {
    const Hdf5Group index = Hdf5Group::open_file(path);
    // A running build writes shards first, the index now and then.
    std::vector<std::size_t> tasks = folder.present;
    if (index.has("id")) {
      rows = index.extent("id").front();
      std::size_t blocks = index.virtual_sources("id").size();
      if (folder.building && blocks < tasks.size()) {
        return {"index", Verdict::note, fmt::format("holds {} samples so far", rows), "", {}};
      }
    }
    if (!tasks.empty() && readable == tasks) {
      const Hdf5Group first =
          Hdf5Group::open_file(folder.dataset.folder / folder.path_of(tasks.front()));
      for (const std::string& column : first.names()) {
        std::uint64_t count = 0, own = 0;
        if (!index.has(column)) {
          items.push_back(column + ": is missing");
        } else if (kind_of(index, column, count) != kind_of(first, column, own)) {
          items.push_back(column + ": another type, extent or unit than in the shards");
        } else if (count != rows) {
          items.push_back(fmt::format("{}: {} rows, id has {}", column, count, rows));
        } else if (index.is_text(column)) {
          check_texts(index, folder, tasks, column, items);
        } else {
          check_sources(index, folder, tasks, column, items);
        }
      }
      if (items.empty()) check_values(index, folder, tasks, items);
    } else if (readable != tasks) {
      items.push_back("not all shards can be read: see schema");
    } else if (rows > 0) {
      items.push_back(fmt::format("{} rows, and there is no shard", rows));
    }
  } catch (const core::Error& error) {
    items.push_back(error.message());
  }
  return judged("index", std::move(items), fmt::format("{} samples resolve to their shards", rows),
                "index.h5 does not hold what the shards hold", remedy);
}

}  // namespace carillon::cli
