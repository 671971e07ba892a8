#include "dataset/regenerate/regenerate.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <map>

#include "core/audio.hpp"
#include "core/error.hpp"
#include "core/temporary_folder.hpp"
#include "core/text.hpp"
#include "dataset/regenerate/detail/compare.hpp"
#include "dataset/samples/sample_row.hpp"
#include "scene/chain.hpp"
#include "scene/columns.hpp"

namespace carillon::dataset::regenerate {

using core::Hdf5Group;
using core::InputError;
namespace fs = std::filesystem;

namespace {

/// Keys of the rows of index.h5; none while there is no index.
std::vector<std::string> stored_keys(const fs::path& folder) {
  if (!fs::is_regular_file(folder / "index.h5")) return {};
  const Hdf5Group index = Hdf5Group::open_file(folder / "index.h5");
  return index.has("key") ? index.read<std::string>("key") : std::vector<std::string>{};
}

/// Key of a sample by its row in index.h5, its key or its id.
std::string key_of(const stored::StoredDataset& dataset, const std::vector<std::string>& rows,
                   const std::string& name) {
  std::uint64_t number = 0;
  const auto [end, error] = std::from_chars(name.data(), name.data() + name.size(), number);
  const bool numeric = error == std::errc() && end == name.data() + name.size();
  if (numeric && number < rows.size()) return rows[number];
  std::vector<std::string> keys;
  for (const plan::Sample& sample : dataset.build.plan.samples) {
    if (sample.key == name || (numeric && sample.id == number)) return sample.key;
    keys.push_back(sample.key);
  }
  const std::string near = numeric ? "" : core::nearest_name(name, keys);
  throw InputError(fmt::format("{} has no sample \"{}\"", dataset.folder.string(), name),
                   !near.empty() ? fmt::format("did you mean {}?", near)
                   : rows.empty()
                       ? fmt::format("it has no index.h5 (yet); keys look like {}", keys.front())
                       : fmt::format("rows of index.h5 go from 0 to {}, keys look like {}",
                                     rows.size() - 1, keys.front()));
}

const plan::Sample& find_sample(const plan::BuildPlan& plan, const std::string& key) {
  for (const plan::Sample& sample : plan.samples) {
    if (sample.key == key) return sample;
  }
  throw InputError(
      fmt::format("with these --set there is no sample {}", key),
      "objects, materials and sizes are part of a sample's key; change something else");
}

/// Everything that the modes of a shape depend on: equal texts, equal modes files.
std::string modes_identity(const configuration::BuildConfig& config, const plan::Shape& shape) {
  const solvers::eigen::SolveOptions& s = config.solver;
  std::string text = fmt::format(
      "{} {} {} {} {} {} {} {} {} {}", solvers::mesh::to_json(shape.request).dump(),
      config.band.min_frequency, config.band.max_frequency, config.band.max_modes,
      config.pitch_cents, config.pitch_cents > 0 ? config.max_unknowns : 0, s.memory_limit,
      solvers::modes::name_of(s.solver), solvers::modes::name_of(s.linear_solver), s.mirror_planes);
  const configuration::ObjectSource& source = config.objects[shape.source];
  for (const plan::Variant& variant : shape.variants) {
    text += fmt::format(" {} {}", variant.material, plan::size_name(variant));
    std::vector<std::string> names = {variant.material};
    if (!source.object.groups.empty()) {
      names.clear();
      for (const auto& [group, name] : source.object.groups) names.push_back(name);
    }
    for (const std::string& name : names) {
      const auto material = scene::object_material(source.object, name, config.own_materials);
      text += fmt::format(" {}", fmt::join(solvers::elements::identity_of(material.elastic), " "));
    }
  }
  return text;
}

/// Why the stored modes of a shape will not do; "" where they will.
std::string why_solve(const stored::StoredDataset& dataset, const run::LoadedBuild& build,
                      const plan::Shape& shape) {
  if (!fs::is_regular_file(samples::BuildFolders{dataset.folder, ""}.modes_file(shape))) {
    return fmt::format("modes/{}.h5 is missing", shape.id);
  }
  for (const plan::Shape& old : dataset.build.plan.shapes) {
    if (old.id == shape.id) {
      return modes_identity(dataset.build.config, old) == modes_identity(build.config, shape)
                 ? ""
                 : "--set changes its modes";
    }
  }
  return "--set adds it";
}

/// A mesh file where it is now.
plan::Shape with_mesh(const stored::StoredDataset& dataset, plan::Shape shape,
                      const configuration::BuildConfig& config) {
  if (shape.path.empty() || fs::is_regular_file(shape.path)) return shape;
  const configuration::ObjectSource& source = config.objects[shape.source];
  fs::path folder = fs::path(source.object.pattern).parent_path();
  if (source.object.modelnet)
    folder = folder.parent_path().parent_path() / shape.family / shape.given_part;
  const fs::path found = folder / fs::path(shape.path).filename();
  if (!fs::is_regular_file(found)) {
    throw InputError(
        fmt::format("{}: its modes must be solved again, and its mesh {} is not there", shape.id,
                    shape.path),
        fmt::format("looked for in {}; --inputs FOLDER names the folder that paths of the "
                    "configuration are meant from",
                    fmt::join(dataset.tried, ", ")));
  }
  shape.path = shape.request.file.path = found.string();
  return shape;
}

/// Where the modes are that a sample is made from: the dataset's own, or a folder with those that
/// had to be solved again beside links to the others.
samples::BuildFolders folders_with_modes(const stored::StoredDataset& dataset,
                                         const run::LoadedBuild& build, const plan::Sample& sample,
                                         const std::string& cache, const fs::path& temporary,
                                         core::Trace& trace, std::vector<SolvedAgain>& again) {
  const samples::BuildFolders stored{dataset.folder, cache}, own{temporary, cache};
  const std::vector<std::size_t> shapes = plan::shapes_of(build.plan, sample);
  std::map<std::size_t, std::string> whys;
  for (const std::size_t s : shapes) {
    const std::string why = why_solve(dataset, build, build.plan.shapes[s]);
    if (!why.empty()) whys[s] = why;
  }
  if (whys.empty()) return stored;
  for (const std::size_t s : shapes) {
    const plan::Shape& shape = build.plan.shapes[s];
    const fs::path file = own.modes_file(shape);
    if (fs::exists(file)) continue;
    if (!whys.contains(s)) {
      fs::create_directories(file.parent_path());
      fs::create_symlink(fs::absolute(stored.modes_file(shape)), file);
      continue;
    }
    samples::run_modes_task(build.config, with_mesh(dataset, shape, build.config), own,
                            MPI_COMM_SELF, trace);
    again.push_back({shape.id, whys[s]});
  }
  return own;
}

/// The shard that holds a sample, and its row in it.
struct Place {
  std::optional<Hdf5Group> shard;
  std::uint64_t row = 0;
};

Place find_stored(const stored::StoredDataset& dataset, const plan::Sample& sample) {
  const plan::BuildPlan& plan = dataset.build.plan;
  Place place;
  for (const plan::BuildTask& task : plan.tasks) {
    if (task.kind != plan::TaskKind::samples ||
        plan.shapes[task.shape].id != plan.shapes[sample.shape].id) {
      continue;
    }
    const fs::path path = samples::BuildFolders{dataset.folder, ""}.shard_file(task);
    if (!fs::is_regular_file(path)) continue;
    Hdf5Group shard = Hdf5Group::open_file(path);
    const auto ids = shard.read<std::uint64_t>("id");
    const auto found = std::find(ids.begin(), ids.end(), sample.id);
    if (found == ids.end()) continue;
    place.row = static_cast<std::uint64_t>(found - ids.begin());
    place.shard = std::move(shard);
    break;
  }
  return place;
}

/// Where a sample's sound goes: the file itself for one, files of a folder for several.
fs::path wav_path(const RegenerateOptions& options, const std::string& key) {
  if (options.samples.size() == 1) return options.output;
  return fs::path(options.output) / (core::file_safe(key) + ".wav");
}

}  // namespace

Regenerated regenerate(const RegenerateOptions& options) {
  const stored::StoredDataset dataset = stored::open_dataset(options.dataset, options.inputs);
  const std::vector<std::string> rows = stored_keys(dataset.folder);
  std::vector<std::string> keys;
  for (const std::string& name : options.samples) keys.push_back(key_of(dataset, rows, name));
  const run::LoadedBuild build =
      options.overrides.empty() ? dataset.build : stored::changed_build(dataset, options.overrides);
  stored::require_inputs(dataset, build.config);

  Regenerated out{.dataset = options.dataset,
                  .changed = options.overrides,
                  .versions = stored::other_versions(dataset),
                  .doubts = dataset.doubts};
  const core::TemporaryFolder temporary;
  core::Trace trace;
  std::map<std::size_t, samples::AddRow> makers;  // by shape
  for (const std::string& key : keys) {
    const plan::Sample& sample = find_sample(build.plan, key);
    if (!makers.contains(sample.shape)) {
      const samples::BuildFolders folders = folders_with_modes(
          dataset, build, sample, options.cache, temporary.path(), trace, out.modes);
      makers[sample.shape] =
          samples::row_maker(build.config, build.plan, sample.shape, folders, trace);
    }
    core::Columns made(scene::columns());
    const samples::SampleResult result = makers[sample.shape](sample, made);
    const Place place = find_stored(dataset, find_sample(dataset.build.plan, key));
    RegeneratedSample entry{.key = key, .id = sample.id, .stored = place.shard.has_value()};
    if (place.shard) entry.differences = differences(made, *place.shard, place.row);
    entry.record = made.last_row(core::longest_shown);
    if (!options.output.empty()) {
      const fs::path path = wav_path(options, key);
      if (path.has_parent_path()) fs::create_directories(path.parent_path());
      core::write_wav(path, scene::clip_of(result.sound), build.config.scene.audio.dtype);
      entry.wav = path.string();
    }
    out.samples.push_back(std::move(entry));
  }
  return out;
}

}  // namespace carillon::dataset::regenerate
