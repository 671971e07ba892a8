#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <limits>
#include <map>

#include "eval/damping/law_text.hpp"
#include "eval/studies/detail/damping_validation.hpp"

namespace carillon::eval::studies {

using core::ConfigNode;
using core::Dimension;

namespace {

/// Different names, each of those that are allowed.
std::vector<std::string> read_names(ConfigNode& node, const std::string& key,
                                    const std::vector<std::string>& allowed,
                                    const std::vector<std::string>& fallback) {
  const std::vector<std::string> names = node.texts(key, fallback);
  if (names.empty()) node.fail(key, "names nothing", fmt::format("{}", fmt::join(allowed, ", ")));
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (std::find(allowed.begin(), allowed.end(), names[i]) == allowed.end()) {
      node.fail(key, fmt::format("unknown value \"{}\"", names[i]),
                fmt::format("one or more of {}", fmt::join(allowed, ", ")));
    }
    if (std::find(names.begin(), names.begin() + static_cast<std::ptrdiff_t>(i), names[i]) !=
        names.begin() + static_cast<std::ptrdiff_t>(i)) {
      node.fail(key, fmt::format("\"{}\" stands here twice", names[i]));
    }
  }
  return names;
}

/// Sounds of a material, or of each of its objects, at least.
std::size_t drawable_sounds(const Condition& condition, bool of_one_object) {
  const std::size_t of_object = condition.build->config.scene.strikes_per_object();
  if (of_one_object) return of_object;
  std::map<std::string, std::size_t> of_material;
  for (const dataset::plan::Sample& sample : condition.build->plan.samples) {
    const dataset::plan::Shape& shape = condition.build->plan.shapes[sample.shape];
    ++of_material[shape.variants[sample.variant].material];
  }
  std::size_t fewest = std::numeric_limits<std::size_t>::max();
  for (const auto& [material, count] : of_material) fewest = std::min(fewest, count);
  return fewest;
}

std::vector<std::size_t> read_sounds(ConfigNode& node, const EvaluatedDatasets& datasets,
                                     bool of_one_object) {
  const auto values = node.quantities("sound_counts", Dimension::none, 0,
                                      std::vector<double>{1, 2, 5, 10, 20, 50, 100});
  std::vector<std::size_t> sounds;
  for (const double value : values) {
    if (!(value >= 1 && value <= 1e6 && value == static_cast<double>(static_cast<int>(value)))) {
      node.fail("sound_counts", fmt::format("{} is no number of sounds", value));
    }
    sounds.push_back(static_cast<std::size_t>(value));
  }
  std::sort(sounds.begin(), sounds.end());
  if (sounds.empty()) node.fail("sound_counts", "names no number");
  if (std::adjacent_find(sounds.begin(), sounds.end()) != sounds.end()) {
    node.fail("sound_counts", "the same number stands here twice");
  }
  for (const Condition& condition : datasets.conditions()) {
    const std::size_t maximum = drawable_sounds(condition, of_one_object);
    if (sounds.back() <= maximum) continue;
    node.fail("sound_counts",
              fmt::format("{} sounds cannot be drawn of {}, the {}", sounds.back(), maximum,
                          of_one_object ? "strikes of each object" : "sounds of a material"),
              of_one_object
                  ? "ask for fewer, raise strikes.per_object, or set draws_from: [material]"
                  : "ask for fewer, or raise strikes.per_object");
  }
  return sounds;
}

std::vector<FeatureSource> read_sources(ConfigNode& node) {
  features::FeatureOptions options;
  const auto names = read_names(node, "extractors", {"esprit", "peaks", room_likelihood, "truth"},
                                {"esprit", "truth"});
  options.contact_time = node.not_negative("contact_time", Dimension::time, options.contact_time);
  options.min_frequency =
      node.quantity("min_frequency", Dimension::frequency, options.min_frequency);
  options.max_frequency =
      node.quantity("max_frequency", Dimension::frequency, options.max_frequency);
  if (node.has("min_decay_rate")) {
    options.min_decay_rate = node.not_negative("min_decay_rate", Dimension::none, 0);
  }
  options.min_level = node.quantity("min_level", Dimension::none, options.min_level);
  options.explained = node.positive("explained", Dimension::none, options.explained);
  if (options.explained > 1) node.fail("explained", "is a fraction, 1 at most");
  options.max_features = static_cast<std::size_t>(
      node.integer("max_features", 1, 1000000, static_cast<std::int64_t>(options.max_features)));
  if (!(options.min_frequency >= 0 && options.max_frequency > options.min_frequency)) {
    node.fail("max_frequency", "must be above min_frequency");
  }
  std::vector<FeatureSource> sources;
  for (const std::string& name : names) {
    options.method =
        name == "peaks" ? features::FeatureMethod::peaks : features::FeatureMethod::esprit;
    sources.push_back({name, name == "truth", options});
  }
  return sources;
}

/// The damping of every material of a dataset, where it is of the kind that is fitted.
std::vector<TrueMaterial> true_materials(const Condition& condition, const ConfigNode& node,
                                         DampingValidation& validation) {
  std::vector<TrueMaterial> materials;
  if (condition.build->config.spread != dataset::configuration::MaterialSpread{}) {
    node.fail("", "fits are of materials, and `material_spread` gives each object its own",
              "remove it from the configuration");
  }
  for (const dataset::configuration::ObjectSource& source : condition.build->config.objects) {
    if (source.object.groups.empty()) continue;
    node.fail("", fmt::format("the objects of {} have several materials each: whose damping would "
                              "their sounds show?",
                              source.object.name));
  }
  for (const synth::material::Material& material :
       dataset::configuration::named_materials(condition.build->config)) {
    const synth::damping::DampingModel& damping = material.damping;
    if (damping.kind != validation.law.kind) {
      node.fail("model",
                fmt::format("{} is damped by {}: the truth is not known of {}", material.name,
                            synth::damping::form_of(damping.kind).name, validation.model));
    }
    if (validation.law.parameters != damping.parameters.size()) {
      if (!materials.empty()) {
        node.fail("model", fmt::format("{} has {} parameters, others have {}", material.name,
                                       damping.parameters.size(), validation.law.parameters));
      }
      validation.law.parameters = damping.parameters.size();
    }
    for (std::size_t i = 0; i < damping.parameters.size(); ++i) {
      if (damping.parameters[i] != 0) continue;
      node.fail("", fmt::format("{} of {} is 0: relative to it every error is infinite",
                                synth::damping::parameter_name(i), material.name));
    }
    materials.push_back({material.name, damping.parameters});
  }
  return materials;
}

}  // namespace

DampingValidation read_damping_config(ConfigNode& node, const EvaluatedDatasets& datasets) {
  DampingValidation validation;
  validation.model = node.choice("model", {"rayleigh", "caughey", "power", "hybrid"}, "rayleigh");
  for (const synth::damping::DampingForm& form : synth::damping::damping_forms()) {
    if (form.name == validation.model) validation.law.kind = form.kind;
  }
  std::vector<std::string> all;
  for (const damping::Estimator estimator : damping::all_estimators) {
    all.emplace_back(damping::name_of(estimator));
  }
  for (const std::string& name : read_names(node, "estimators", all, all)) {
    validation.estimators.push_back({name, damping::estimator_named(name)});
  }
  validation.draws = static_cast<int>(node.integer("draws", 1, 100000, 30));
  validation.from = read_names(node, "draws_from", {"object", "material"}, {"object", "material"});
  validation.sounds = read_sounds(
      node, datasets, std::count(validation.from.begin(), validation.from.end(), "object") > 0);
  validation.seed = static_cast<std::uint64_t>(
      node.integer("seed", 0, std::numeric_limits<std::int64_t>::max(), 0));
  ConfigNode features = node.child("features");
  validation.sources = read_sources(features);
  validation.keep_reverberant =
      features.choice("reverberant", {"leave_out", "keep"}, "leave_out") == "keep";
  for (FeatureSource& source : validation.sources) {
    source.options.keep_reverberant = validation.keep_reverberant;
  }
  for (const Condition& condition : datasets.conditions()) {
    validation.materials.push_back(true_materials(condition, node, validation));
  }
  return validation;
}

}  // namespace carillon::eval::studies
