#include "dataset/run/dataset.hpp"

#include <fmt/format.h>

#include <algorithm>
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

/// Rows of the index beside those of samples, by shape.
struct ObjectRows {
  std::map<std::size_t, std::int64_t> shapes;       ///< in `shapes/`
  std::map<std::size_t, std::int64_t> appearances;  ///< the first in `appearances/`; empty: none
};

/// Frames of objects: one row per shape and material that it is drawn in.
void write_appearances(const Hdf5Group& index, const plan::BuildPlan& plan,
                       const std::vector<std::size_t>& shapes, const samples::BuildFolders& folders,
                       const std::vector<std::string>& files, JoinedFiles& joined,
                       ObjectRows& rows) {
  std::vector<std::string> names;
  for (const std::size_t s : shapes) {
    rows.appearances[s] = static_cast<std::int64_t>(names.size());
    names.resize(names.size() + plan::pictured_materials(plan.shapes[s]).size(), plan.shapes[s].id);
  }
  index.create_group("appearances").write<std::string>("shape", names, {names.size()});
  for (const std::string& name : appearance_arrays()) join(index, name, folders, files, joined);
}

/// Arrays of objects: one row per shape that has samples.
ObjectRows write_shapes(const Hdf5Group& index, const plan::BuildPlan& plan,
                        const std::vector<std::size_t>& done, const samples::BuildFolders& folders,
                        JoinedFiles& joined) {
  ObjectRows rows;
  std::vector<std::size_t> shapes;
  std::vector<std::string> names, families, splits, files;
  for (const std::size_t t : done) {
    for (const std::size_t s : plan.tasks[t].needs()) {
      if (!rows.shapes.emplace(s, static_cast<std::int64_t>(shapes.size())).second) continue;
      shapes.push_back(s);
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
  if (first.has(appearance_arrays().back()))
    write_appearances(index, plan, shapes, folders, files, joined, rows);
  return rows;
}

/// Of samples that are of one object each: their rows in `shapes/` and in `appearances/`.
void write_places(const Hdf5Group& index, const plan::BuildPlan& plan,
                  const std::vector<std::size_t>& done, const ObjectRows& rows) {
  std::vector<std::int64_t> of_shape, of_appearance;
  for (const std::size_t t : done) {
    const plan::BuildTask& task = plan.tasks[t];
    of_shape.insert(of_shape.end(), task.count, rows.shapes.at(task.shape));
    if (rows.appearances.empty()) continue;
    const plan::Shape& shape = plan.shapes[task.shape];
    const std::vector<std::string> materials = plan::pictured_materials(shape);
    for (std::size_t i = task.first; i < task.first + task.count; ++i) {
      const std::string& own = shape.variants[plan.samples[i].variant].material;
      const auto at = std::find(materials.begin(), materials.end(), own) - materials.begin();
      of_appearance.push_back(rows.appearances.at(task.shape) + at);
    }
  }
  const auto write = [&](const std::string& name, const std::vector<std::int64_t>& values) {
    index.write<std::int64_t>(name, values, {values.size()});
    index.write_attribute("unit", "1", name);
  };
  write("shape_index", of_shape);
  if (!rows.appearances.empty()) write("appearance_index", of_appearance);
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
    const ObjectRows rows = write_shapes(index, plan, done, folders, joined);
    // A simulation is of several shapes, which its `bodies` name.
    if (!config.motion) write_places(index, plan, done, rows);
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
