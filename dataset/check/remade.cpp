#include "dataset/check/remade.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "core/error.hpp"
#include "core/hash.hpp"
#include "core/hdf5.hpp"
#include "core/hdf5_compare.hpp"
#include "core/temporary_folder.hpp"
#include "dataset/run/dataset.hpp"
#include "dataset/run/progress_so_far.hpp"

namespace carillon::dataset::check {

using core::Hdf5Group;
using nlohmann::json;

namespace {

std::vector<std::string> compare_index(const DatasetFolder& folder,
                                       const std::filesystem::path& path) {
  const run::LoadedBuild& build = folder.dataset.build;
  const core::TemporaryFolder temporary;
  const std::filesystem::path again = temporary.path() / "index.h5";
  run::JoinedFiles joined(folder.dataset.folder);
  run::write_index(build.config, build.plan, folder.present, {folder.dataset.folder, ""}, again,
                   joined);
  if (core::sha256_file(path) == core::sha256_file(again)) return {};
  // Another HDF5 may lay out the same contents in another way.
  return core::compare_hdf5(path, again);
}

}  // namespace

Finding check_index(const DatasetFolder& folder, const std::vector<std::size_t>& readable) {
  const auto path = folder.dataset.folder / "index.h5";
  const std::string remedy = "run the build again into this folder: it writes the index anew";
  if (!std::filesystem::is_regular_file(path)) {
    if (folder.building) return {"index", Verdict::note, "not written yet", "", {}};
    return judged("index", {"index.h5 is not there"}, "", "there is no index", remedy);
  }
  std::vector<std::string> items;
  std::size_t rows = 0;
  try {
    const Hdf5Group index = Hdf5Group::open_file(path);
    const bool filled = index.has("id");
    if (filled) rows = index.extent("id").front();
    const std::size_t blocks = filled ? index.virtual_sources("id").size() : 0;
    // A running build writes shards first, the index now and then.
    if (folder.building && blocks != folder.present.size()) {
      return {"index", Verdict::note, fmt::format("holds {} samples so far", rows), "", {}};
    }
    if (readable != folder.present) {
      items.push_back("not all shards can be read: see schema");
    } else {
      items = compare_index(folder, path);
    }
  } catch (const core::Error& error) {
    items.push_back(error.message());
  }
  return judged("index", std::move(items),
                fmt::format("{} samples, as shards, modes files and plan have them", rows),
                "index.h5 is not what shards, modes files and plan make", remedy);
}

namespace {

/// Targets that the journal has; of others, those that dataset.json itself has.
json pitch_targets_of(const json& description, const run::Gathered& journal) {
  json targets = json::object();
  for (const json& shape : description.at("shapes")) {
    if (shape.contains("pitch_target")) {
      targets[shape.at("id").get<std::string>()] = shape.at("pitch_target");
    }
  }
  targets.update(journal.pitch_targets);
  return targets;
}

/// Own materials are read from inputs/ here: where the build read them is not known.
void take_sources(const configuration::BuildConfig& config, const json& stored, json& materials) {
  for (std::size_t i = 0; i < materials.size() && i < stored.size(); ++i) {
    const bool own = std::any_of(config.own_materials.begin(), config.own_materials.end(),
                                 [&](const synth::material::Material& material) {
                                   return materials[i].at("name") == material.name;
                                 });
    if (own && stored[i].contains("source")) materials[i]["source"] = stored[i].at("source");
  }
}

void compare_values(const json& stored, const json& expected, std::vector<std::string>& items) {
  for (const json& change : json::diff(stored, expected)) {
    const std::string place = change.at("path"), what = change.at("op");
    const std::string name = place.empty() ? "dataset.json" : place.substr(1);
    if (what == "add") {
      items.push_back(fmt::format("{}: is missing", name));
    } else if (what == "remove") {
      items.push_back(fmt::format("{}: does not belong there", name));
    } else {
      items.push_back(fmt::format("{}: is {}, not {}", name,
                                  stored.at(json::json_pointer(place)).dump(),
                                  change.at("value").dump()));
    }
  }
}

void compare_files(const DatasetFolder& folder, const run::Gathered& journal,
                   std::vector<std::string>& items) {
  std::set<std::string> listed;
  for (const run::ListedFile& file : folder.listed) listed.insert(file.path);
  for (const run::ListedFile& file : journal.files) {
    if (!listed.contains(file.path))
      items.push_back(fmt::format("files: {} is missing", file.path));
  }
}

}  // namespace

Finding check_description(const DatasetFolder& folder) {
  const json& stored = folder.dataset.description;
  if (folder.building) return {"description", Verdict::note, "a build is writing it", "", {}};
  if (!stored.is_object()) return {"description", Verdict::note, "see configuration", "", {}};
  const run::LoadedBuild& build = folder.dataset.build;
  const run::Gathered journal = run::gather(build.plan, folder.finished);
  json expected =
      run::describe_dataset(build.config, build.plan, 0, pitch_targets_of(stored, journal), {});
  // As it comes back from a file.
  expected = json::parse(expected.dump());
  take_sources(build.config, stored.at("materials"), expected.at("materials"));
  // Other checks see to these.
  for (const char* name : {"samples", "configuration", "versions", "files"}) {
    if (stored.contains(name)) expected[name] = stored.at(name);
  }
  std::vector<std::string> items;
  compare_values(stored, expected, items);
  compare_files(folder, journal, items);
  Finding finding =
      judged("description", std::move(items), "dataset.json is what plan and journal make",
             "dataset.json is not what the plan and the journal make",
             "run the build again into this folder: it writes the file anew; restore inputs/ if it "
             "changed");
  if (finding.verdict == Verdict::fail) return finding;
  for (const auto& [name, version] : stored::other_versions(folder.dataset)) {
    finding.verdict = Verdict::note;
    finding.text = "dataset.json is what plan and journal make; it names other versions than here";
    finding.items.push_back(
        fmt::format("{}: {}, here {}", name, version.stored.dump(), version.here.dump()));
  }
  return finding;
}

}  // namespace carillon::dataset::check
