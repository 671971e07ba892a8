#include "dataset/run/detail/task_inputs.hpp"

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <span>

#include "core/hash.hpp"
#include "dataset/samples/damping_columns.hpp"
#include "solvers/mesh/shape_source.hpp"

namespace carillon::dataset::run {

using nlohmann::json;

std::string without_growth(const configuration::BuildConfig& config) {
  YAML::Node root = YAML::Load(config.resolved);
  root.remove("limits");  // they decide what fails and no value
  root.remove("dataset");
  root.remove("objects");
  root.remove("materials");
  root.remove("variants");
  if (root["strikes"].IsMap()) root["strikes"].remove("per_object");
  if (root["motion"].IsMap()) root["motion"].remove("simulations");
  return YAML::Dump(root);
}

namespace {

void add_material(core::Sha256& hash, const synth::material::Material& material) {
  const std::vector<double> elastic = solvers::elements::identity_of(material.elastic);
  hash.add(material.name).add("\n").add(std::span<const double>(elastic));
  hash.add(synth::damping::form_of(material.damping.kind).name)
      .add(material.damping.expression)
      .add("\n");
  hash.add(std::span<const double>(material.damping.parameters));
}

/// What the frames of a material show; those of before had none of a material's own.
void add_appearance(core::Sha256& hash, const synth::material::Material& material) {
  hash.add(render::looks::to_json(appearance_of(material)).dump());
}

void add_strike(core::Sha256& hash, const scene::GivenStrike& strike) {
  const Vec3 direction = strike.direction.value_or(Vec3::Zero());
  const std::vector<double> force = {strike.impulse, strike.contact_time};
  hash.add(std::span<const double>(strike.position.data(), 3));
  hash.add(std::span<const double>(direction.data(), 3)).add(std::span<const double>(force));
}

}  // namespace

TaskInputs::TaskInputs(const configuration::BuildConfig& config, const plan::BuildPlan& plan)
    : config_(config), plan_(plan) {
  core::Sha256 hash;
  hash.add(without_growth(config));
  // The columns that every shard has follow from all materials of the build.
  for (const std::string& unit :
       samples::damping_column_units(configuration::named_materials(config))) {
    hash.add(unit).add("\n");
  }
  for (const scene::EffectDecision& effect : config.scene.effects) {
    hash.add(fmt::format("{} {}\n", effect.effect->name, effect.enabled));
    if (effect.enabled && effect.in_scene.content) hash.add(effect.in_scene.content());
  }
  common_ = hash.hex();
  for (std::size_t s = 0; s < plan.shapes.size(); ++s) shapes_.push_back(of_shape(s));
}

std::string TaskInputs::of_shape(std::size_t index) const {
  const plan::Shape& shape = plan_.shapes[index];
  const configuration::ObjectSource& source = config_.objects[shape.source];
  core::Sha256 hash;
  hash.add(common_).add(shape.id).add("\n").add(shape.family).add("\n").add(shape.identity);
  hash.add(shape.sha256);
  hash.add(shape.split_shape).add(solvers::mesh::to_json(shape.request).dump());
  const bool is_drawn = !config_.cameras.empty() || (config_.motion && config_.motion->camera);
  const auto add = [&](const std::string& name) {
    const auto material = scene::object_material(source.object, name, config_.own_materials);
    add_material(hash, material);
    if (is_drawn) add_appearance(hash, material);
  };
  // The modes of an object serve all its materials and sizes: their bits depend on every one.
  for (const plan::Variant& variant : shape.variants) {
    hash.add(fmt::format("{} {}\n", variant.material, plan::size_name(variant)));
    if (source.object.groups.empty()) add(variant.material);
  }
  // Pictures of before had the first region's looks everywhere.
  if (is_drawn && source.object.groups.size() > 1) hash.add("looks of regions\n");
  for (const auto& [group, name] : source.object.groups) {
    hash.add(group).add("\n");
    add(name);
  }
  return hash.hex();
}

std::string TaskInputs::of(const plan::BuildTask& task, std::size_t samples) const {
  core::Sha256 hash;
  hash.add(task.key).add("\n");
  for (const std::size_t shape : task.needs()) hash.add(shapes_[shape]);
  for (std::size_t i = task.first; i < task.first + samples; ++i) {
    const plan::Sample& sample = plan_.samples[i];
    hash.add(sample.key).add("\n");
    const auto& given = config_.scene.strikes.given;
    if (!given.empty()) add_strike(hash, given[static_cast<std::size_t>(sample.strike)]);
  }
  return hash.hex();
}

Standing sort_entries(const configuration::BuildConfig& config, const plan::BuildPlan& plan,
                      const std::map<std::string, json>& entries) {
  Standing standing;
  if (entries.empty()) return standing;
  const TaskInputs inputs(config, plan);
  for (const plan::BuildTask& task : plan.tasks) {
    const auto found = entries.find(task.key);
    if (found == entries.end()) continue;
    const json& entry = found->second;
    const std::string then = entry.value("inputs", "");
    const std::size_t samples = entry.value("samples", std::size_t{0});
    if (then == inputs.of(task)) {
      standing.finished.insert(*found);
    } else if (entry.value("ok", false) && samples > 0 && samples < task.count &&
               then == inputs.of(task, samples)) {
      standing.grown.insert(*found);
    }
  }
  return standing;
}

}  // namespace carillon::dataset::run
