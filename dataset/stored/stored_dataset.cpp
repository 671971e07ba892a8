#include "dataset/stored/stored_dataset.hpp"
#include "dataset/plan/identities.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "core/config_text.hpp"
#include "core/error.hpp"
#include "core/files.hpp"
#include "core/hash.hpp"
#include "core/json.hpp"
#include "core/what_is.hpp"
#include "dataset/configuration/inputs.hpp"
#include "dataset/run/dataset.hpp"

namespace carillon::dataset::stored {

using core::InputError;
using nlohmann::json;
namespace fs = std::filesystem;

namespace {

/// A file with a JSON object; null where it is not there or is none.
json read_object(const fs::path& path) {
  json document = core::read_json(path);
  return document.is_object() ? document : json(nullptr);
}

std::vector<std::string> folders_to_try(const fs::path& folder, const std::string& inputs) {
  if (!inputs.empty()) return {inputs};
  std::vector<std::string> folders;
  const json trace = read_object(folder / "trace.json");
  if (trace.is_object() && trace.contains("configuration_folder")) {
    folders.push_back(trace.at("configuration_folder").get<std::string>());
  }
  const fs::path here = fs::absolute(folder).lexically_normal();
  for (const fs::path& path : {here, here.parent_path(), fs::current_path()}) {
    folders.push_back(path.string());
  }
  return folders;
}

std::string assignment(const std::string& key, const fs::path& path) {
  return key + "=" + core::yaml_text(path.string());
}

/// Files of the configuration by their keys, where they are found.
std::vector<std::string> find_inputs(const StoredDataset& dataset) {
  std::vector<std::string> overrides;
  const auto add_if = [&](const std::string& key, const std::string& path, bool pattern) {
    for (const std::string& folder : dataset.tried) {
      const fs::path candidate = fs::absolute(fs::path(folder) / path).lexically_normal();
      const bool found =
          pattern ? !core::glob_files(candidate.string()).empty() : fs::exists(candidate);
      if (!found) continue;
      overrides.push_back(assignment(key, candidate));
      return;
    }
  };
  const std::string file = (dataset.folder / "configuration.yaml").string();
  core::ConfigNode root = core::ConfigNode::parse(dataset.configuration, file);
  /// @param named  what the copy is named after, where that is not the key
  const auto kept = [&](const std::string& key, const std::string& named = "") {
    const fs::path copy = fs::absolute(dataset.folder) / "inputs" / (named.empty() ? key : named);
    if (fs::exists(copy)) overrides.push_back(assignment(key, copy));
    return fs::exists(copy);
  };
  if (root.has("materials_file") && !kept("materials_file")) {
    add_if("materials_file", root.text("materials_file"), false);
  }
  core::ConfigNode strikes = root.child("strikes");
  if (strikes.has("csv") && !kept("strikes.csv")) add_if("strikes.csv", strikes.text("csv"), false);
  std::vector<core::ConfigNode> objects = root.children("objects");
  for (std::size_t i = 0; i < objects.size(); ++i) {
    const std::string key = fmt::format("objects[{}].", i);
    for (const char* profile : {"svg", "csv"}) {
      if (objects[i].has(profile) && !kept(key + profile, key + "profile"))
        add_if(key + profile, objects[i].text(profile), false);
    }
    for (const char* files : {"mesh", "glob"})
      if (objects[i].has(files)) add_if(key + files, objects[i].text(files), true);
    if (objects[i].has("manifest")) {
      // The copy lies elsewhere than the files that it names.
      const std::string manifest = objects[i].text("manifest");
      const fs::path beside = fs::path(manifest).parent_path();
      add_if(key + "folder", objects[i].text("folder", beside.empty() ? "." : beside.string()),
             false);
      if (!kept(key + "manifest")) add_if(key + "manifest", manifest, false);
    }
    if (objects[i].has("modelnet")) add_if(key + "modelnet", objects[i].text("modelnet"), false);
  }
  if (root.has("motion")) {
    core::ConfigNode motion = root.child("motion");
    const auto image_of = [&](core::ConfigNode node, const std::string& key) {
      if (!node.has("texture")) return;
      core::ConfigNode texture = node.child("texture");
      const std::string image = key + ".texture.image";
      if (texture.has("image") && !kept(image)) add_if(image, texture.text("image"), false);
    };
    if (motion.has("ground")) image_of(motion.child("ground"), "motion.ground");
    std::vector<core::ConfigNode> bodies = motion.children("bodies");
    for (std::size_t i = 0; i < bodies.size(); ++i) {
      image_of(bodies[i], fmt::format("motion.bodies[{}]", i));
    }
  }
  core::ConfigNode noise = root.child("noise");
  if (noise.has("folder")) add_if("noise.folder", noise.text("folder"), false);
  core::ConfigNode room = root.child("room");
  if (room.has("responses")) add_if("room.responses", room.text("responses"), false);
  return overrides;
}

/// Mesh files as dataset.json has them, so that the files themselves need not be there.
plan::FindMeshes meshes_of(const json& description) {
  if (!description.is_object() || !description.contains("shapes")) return {};
  return [shapes = description.at("shapes")](std::size_t object) {
    std::vector<plan::FoundMesh> found;
    for (const json& shape : shapes) {
      if (!shape.contains("sha256") || shape.at("object").get<std::size_t>() != object) continue;
      const json& file = shape.at("request").at("file");
      found.push_back({file.at("path").get<std::string>(),
                       shape.at("sha256").get<std::string>(),
                       shape.at("signature").get<solvers::mesh::ShapeSignature>(),
                       {},
                       file.value("node", "")});
    }
    return found;
  };
}

run::LoadedBuild load(const StoredDataset& dataset, const std::vector<std::string>& overrides) {
  run::LoadedBuild build;
  build.path = (dataset.folder / "configuration.yaml").string();
  build.overrides = dataset.overrides;
  build.overrides.insert(build.overrides.end(), overrides.begin(), overrides.end());
  build.config = configuration::read_build_config(dataset.configuration, build.path,
                                                  build.overrides, scene::effects(), false);
  try {
    build.plan = plan::make_plan(build.config, meshes_of(dataset.description));
  } catch (const json::exception&) {
    // A dataset.json of other fields: the meshes themselves must do.
    build.plan = plan::make_plan(build.config);
  }
  return build;
}

std::string stored_fingerprint(const std::string& configuration) {
  constexpr std::string_view mark = "# inputs: ";
  const std::size_t at = configuration.rfind(mark);
  if (at == std::string::npos) return "";
  const std::size_t begin = at + mark.size();
  return configuration.substr(begin, configuration.find('\n', begin) - begin);
}

void verify_inputs(StoredDataset& dataset) {
  for (const plan::Shape& shape : dataset.build.plan.shapes) {
    std::error_code error;
    if (shape.path.empty() || !fs::is_regular_file(shape.path, error)) continue;
    if (plan::mesh_sha256(shape.path) != shape.sha256) {
      dataset.doubts.push_back(
          fmt::format("{} is not the mesh any more that {} was made of", shape.path, shape.id));
    }
  }
  const std::string stored = stored_fingerprint(dataset.configuration);
  if (stored.empty()) {
    dataset.doubts.push_back(
        "configuration.yaml has no line \"# inputs:\": what it was read with "
        "cannot be verified");
    return;
  }
  try {
    require_inputs(dataset, dataset.build.config);
    if (plan::fingerprint(dataset.build.config, dataset.build.plan) != stored) {
      dataset.doubts.push_back(
          "materials, strikes, profiles, recordings or meshes are not those that the dataset was "
          "built from (\"# inputs:\" of configuration.yaml)");
    }
  } catch (const core::Error& error) {
    dataset.doubts.push_back("inputs cannot be verified: " + error.message());
  }
}

}  // namespace

InputError not_a_dataset(const fs::path& folder) {
  const core::WhatIs what = core::what_is(folder);
  // A folder of which nothing is known, or a dataset that lacks something.
  const bool unknown = what.name == "a folder" || what.name == "a dataset";
  return InputError(
      fmt::format("{} is no dataset: {}", folder.string(),
                  what.name == "missing" ? "there is no such folder"
                  : unknown              ? "it has no configuration.yaml or no index.h5"
                                         : "it is " + what.name),
      what.takes.empty() || unknown ? "name the folder that `carillon build` made" : what.takes);
}

StoredDataset open_dataset(const fs::path& folder, const std::string& inputs,
                           const std::optional<std::string>& configuration) {
  StoredDataset dataset;
  dataset.folder = folder;
  if (configuration) {
    dataset.configuration = *configuration;
  } else {
    if (!fs::is_regular_file(folder / "configuration.yaml")) {
      throw not_a_dataset(folder);
    }
    dataset.configuration = core::read_file(folder / "configuration.yaml");
  }
  dataset.description = read_object(folder / "dataset.json");
  dataset.tried = folders_to_try(folder, inputs);
  dataset.overrides = find_inputs(dataset);
  dataset.build = load(dataset, {});
  verify_inputs(dataset);
  return dataset;
}

run::LoadedBuild changed_build(const StoredDataset& dataset,
                               const std::vector<std::string>& overrides) {
  return load(dataset, overrides);
}

void require_inputs(const StoredDataset& dataset, const configuration::BuildConfig& config) {
  for (const scene::EffectDecision& effect : config.scene.effects) {
    if (!effect.enabled || !effect.in_scene.check) continue;
    try {
      effect.in_scene.check();
    } catch (const core::Error& error) {
      if (!effect.in_scene.content) throw;  // it reads no files
      throw InputError(
          fmt::format("effect {}: {}", effect.effect->name, error.message()),
          fmt::format("looked for in {}; --inputs FOLDER names the folder that paths of the "
                      "configuration are meant from",
                      fmt::join(dataset.tried, ", ")));
    }
  }
}

OtherVersions other_versions(const StoredDataset& dataset) {
  OtherVersions others;
  if (!dataset.description.is_object()) return others;
  const json stored = dataset.description.value("versions", json::object()),
             here = run::program_versions();
  for (const auto& [name, version] : stored.items()) {
    if (!here.contains(name) || here.at(name) != version) {
      others[name] = {version, here.value(name, json())};
    }
  }
  return others;
}

}  // namespace carillon::dataset::stored
