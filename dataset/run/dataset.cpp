#include "dataset/run/dataset.hpp"

#include <fmt/format.h>

#include <map>

#include "core/files.hpp"
#include "core/hdf5.hpp"
#include "dataset/samples/damping_columns.hpp"
#include "dataset/samples/samples_task.hpp"
#include "scene/material_json.hpp"

namespace carillon::dataset::run {

using core::Hdf5Group;
using core::VirtualSource;

namespace {

/// Joins the rows of one dataset of several files: texts are copied, arrays become virtual.
void join(const Hdf5Group& into, const std::string& name, const samples::BuildFolders& folders,
          const std::vector<std::string>& files, JoinedFiles& joined) {
  if (joined.of(files.front()).texts.contains(name)) {
    std::vector<std::string> all;
    for (const std::string& file : files) joined.append_texts(file, name, all);
    into.write<std::string>(name, all, {all.size()});
    return;
  }
  std::vector<VirtualSource> sources;
  for (const std::string& file : files) sources.push_back({file, name, joined.rows(file, name)});
  into.write_virtual(name, folders.output, sources);
}

void copy_text_attribute(const Hdf5Group& from, const Hdf5Group& to, const std::string& attribute,
                         const std::string& object) {
  to.write_attribute(attribute, from.text_attribute(attribute, object), object);
}

/// Arrays of objects: one row per shape that has samples. Returns the row of each shape.
std::map<std::size_t, std::int64_t> write_shapes(const Hdf5Group& index,
                                                 const plan::BuildPlan& plan,
                                                 const std::vector<std::size_t>& done,
                                                 const samples::BuildFolders& folders,
                                                 JoinedFiles& joined) {
  std::map<std::size_t, std::int64_t> rows;
  std::vector<std::string> names, families, splits, files;
  for (const std::size_t t : done) {
    for (const std::size_t s : plan.tasks[t].needs()) {
      if (!rows.emplace(s, static_cast<std::int64_t>(rows.size())).second) continue;
      names.push_back(plan.shapes[s].id);
      families.push_back(plan.shapes[s].family);
      splits.push_back(plan.shapes[s].split_shape);
      files.push_back("modes/" + plan.shapes[s].id + ".h5");
    }
  }
  const Hdf5Group group = index.create_group("shapes");
  group.write<std::string>("shape", names, {names.size()});
  group.write<std::string>("family", families, {families.size()});
  group.write<std::string>("split_shape", splits, {splits.size()});
  group.write<std::string>("modes_file", files, {files.size()});
  const Hdf5Group first = Hdf5Group::open_file(folders.output / files.front());
  for (const std::string& name : object_arrays()) {
    if (first.has(name)) join(group, name, folders, files, joined);
  }
  return rows;
}

}  // namespace

void write_index(const configuration::BuildConfig& config, const plan::BuildPlan& plan,
                 const std::vector<std::size_t>& done, const samples::BuildFolders& folders,
                 const std::filesystem::path& target, JoinedFiles& joined) {
  core::write_durably(target, [&](const std::filesystem::path& path) {
    const Hdf5Group index = Hdf5Group::create_file(path);
    if (done.empty()) return;
    std::vector<std::string> files;
    for (const std::size_t t : done) files.push_back(plan.tasks[t].key + ".h5");
    const Hdf5Group first = Hdf5Group::open_file(folders.output / files.front());
    index.write_attribute("sample_rate_hz", first.number_attribute("sample_rate_hz"));
    for (const std::string& name : first.names()) {
      join(index, name, folders, files, joined);
      copy_text_attribute(first, index, "unit", name);
    }
    if (config.mel) samples::write_mel_attributes(*config.mel, index);
    const auto rows = write_shapes(index, plan, done, folders, joined);
    if (!config.motion) {  // a simulation is of several shapes, which its `objects` name
      std::vector<std::int64_t> shape_index;
      for (const std::size_t t : done) {
        shape_index.insert(shape_index.end(), plan.tasks[t].count, rows.at(plan.tasks[t].shape));
      }
      index.write<std::int64_t>("shape_index", shape_index, {shape_index.size()});
      index.write_attribute("unit", "1", "shape_index");
    }
    index.flush();
  });
}

namespace {

nlohmann::json describe_materials(const configuration::BuildConfig& config) {
  nlohmann::json list = nlohmann::json::array();
  for (const synth::material::Material& material : configuration::named_materials(config))
    list.push_back(scene::to_json(material));
  return list;
}

nlohmann::json describe_shapes(const plan::BuildPlan& plan, const nlohmann::json& pitch_targets) {
  nlohmann::json list = nlohmann::json::array();
  for (const plan::Shape& shape : plan.shapes) {
    nlohmann::json entry = {
        {"id", shape.id},
        {"family", shape.family},
        {"object", shape.source},
        {"split_shape", shape.split_shape},
        {"request", solvers::mesh::to_json(shape.request)},
        {"solver",
         {{"name", scene::name_of(shape.solver.solver)}, {"reason", shape.solver.reason}}}};
    if (!shape.path.empty()) {
      entry["sha256"] = shape.sha256;
      entry["signature"] = shape.signature;
    }
    if (!shape.labels.empty()) entry["labels"] = shape.labels;
    if (pitch_targets.contains(shape.id)) {
      // The mesh that was kept, not the one that the search began with.
      const nlohmann::json& target = pitch_targets.at(shape.id);
      entry["pitch_target"] = target;
      if (target.contains("order")) {
        entry["request"]["options"]["order"] = target.at("order");
        entry["request"]["options"]["element_size"] = target.at("element_size_m");
      }
    }
    nlohmann::json variants = nlohmann::json::array();
    for (const plan::Variant& v : shape.variants) {
      variants.push_back({{"material", v.material}});
      nlohmann::json& variant = variants.back();
      if (v.tune > 0) {
        variant["tune_hz"] = v.tune;
        variant["tune_mode"] = v.tune_mode;
      } else {
        variant["size"] = v.size;
      }
    }
    entry["variants"] = variants;
    list.push_back(entry);
  }
  return list;
}

}  // namespace

nlohmann::json describe_dataset(const configuration::BuildConfig& config,
                                const plan::BuildPlan& plan, std::size_t samples,
                                const nlohmann::json& pitch_targets,
                                const std::vector<ListedFile>& files) {
  nlohmann::json missed = nlohmann::json::array();
  for (const plan::Shape& shape : plan.shapes) {
    if (pitch_targets.contains(shape.id) && !pitch_targets.at(shape.id).at("met").get<bool>()) {
      missed.push_back(shape.id);
    }
  }
  nlohmann::json document = {{"name", config.name},
                             {"seed", config.seed},
                             {"samples", samples},
                             {"configuration", config.resolved},
                             {"versions", program_versions()},
                             {"materials", describe_materials(config)},
                             {"shapes", describe_shapes(plan, pitch_targets)},
                             {"missed_pitch_targets", missed},
                             {"files", files}};
  if (const nlohmann::json about = configuration::to_json(config.about); !about.empty())
    document["about"] = about;
  return document;
}

}  // namespace carillon::dataset::run
