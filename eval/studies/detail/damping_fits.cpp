#include "eval/studies/detail/damping_fits.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/error.hpp"
#include "core/hash.hpp"
#include "core/numbers.hpp"
#include "core/revision.hpp"
#include "eval/validation/draw_sounds.hpp"

namespace carillon::eval::studies {

using nlohmann::json;

SoundsByObject::SoundsByObject(const dataset::plan::BuildPlan& plan) {
  std::map<std::string, std::map<std::string, std::size_t>> places;
  for (std::size_t i = 0; i < plan.samples.size(); ++i) {
    const dataset::plan::Sample& sample = plan.samples[i];
    const dataset::plan::Shape& shape = plan.shapes[sample.shape];
    const dataset::plan::Variant& variant = shape.variants[sample.variant];
    auto& objects = objects_[variant.material];
    const auto [place, is_new] = places[variant.material].emplace(
        fmt::format("{}/{}", shape.id, dataset::plan::size_name(variant)), objects.size());
    if (is_new) objects.emplace_back();
    objects[place->second].push_back(i);
  }
}

const std::vector<std::vector<std::size_t>>& SoundsByObject::objects(
    const std::string& material) const {
  return objects_.at(material);
}

FeatureStore::FeatureStore(const EvaluatedDatasets& datasets, const std::vector<SoundBlock>& blocks,
                           bool keep_reverberant)
    : datasets_(datasets), blocks_(blocks), keep_reverberant_(keep_reverberant) {}

const std::vector<SoundFeatures>& FeatureStore::sounds(std::size_t condition, std::size_t source) {
  const auto [found, is_new] =
      sounds_.emplace(Key{condition, source}, std::vector<SoundFeatures>{});
  if (!is_new) return found->second;
  const dataset::plan::BuildPlan& plan = datasets_.conditions()[condition].build->plan;
  found->second.resize(plan.samples.size());
  for (const SoundBlock& block : blocks_) {
    if (block.condition != condition || block.source != source) continue;
    auto sounds = read_features(block.file, keep_reverberant_);
    const std::size_t first = plan.tasks[block.task].first + block.first;
    std::move(sounds.begin(), sounds.end(),
              found->second.begin() + static_cast<std::ptrdiff_t>(first));
  }
  return found->second;
}

const std::string& FeatureStore::content(std::size_t condition, std::size_t source) {
  std::string& content = contents_[{condition, source}];
  if (!content.empty()) return content;
  core::Sha256 hash;
  for (const SoundBlock& block : blocks_) {
    if (block.condition != condition || block.source != source) continue;
    hash.add(fmt::format("{} {} {}\n", block.task, block.first, content_of(block.file)));
  }
  return content = hash.hex();
}

std::vector<FitBlock> fit_blocks(const DampingValidation& validation,
                                 const EvaluatedDatasets& datasets, FeatureStore& store) {
  std::string common = fmt::format("carillon {} {} {} {} {}", core::version(), validation.model,
                                   validation.law.parameters, validation.draws, validation.seed);
  if (validation.keep_reverberant) common += " reverberant";
  for (const NamedEstimator& estimator : validation.estimators) common += " " + estimator.name;
  std::vector<FitBlock> blocks;
  for (std::size_t c = 0; c < datasets.conditions().size(); ++c) {
    const Condition& condition = datasets.conditions()[c];
    std::string keys;
    for (const dataset::plan::Sample& sample : condition.build->plan.samples)
      keys += sample.key + "\n";
    const std::string plan = core::sha256(keys);
    for (std::size_t s = 0; s < validation.sources.size(); ++s) {
      const std::string content = store.content(c, s);
      for (std::size_t m = 0; m < validation.materials[c].size(); ++m) {
        for (std::size_t f = 0; f < validation.from.size(); ++f) {
          for (const std::size_t sounds : validation.sounds) {
            FitBlock block{c, s, m, f, sounds, "", ""};
            const std::string which = fmt::format("{}/{}/{}", validation.materials[c][m].name,
                                                  validation.from[f], sounds);
            block.key = fmt::format("{}/{}/{}", validation.sources[s].name, condition.name, which);
            block.inputs =
                core::sha256(fmt::format("{}\n{}\n{}\n{}", common, plan, content, which));
            blocks.push_back(std::move(block));
          }
        }
      }
    }
  }
  return blocks;
}

namespace {

damping::DampingData data_of(const std::vector<std::size_t>& drawn,
                             const std::vector<SoundFeatures>& sounds) {
  std::vector<damping::DampingData> parts;
  for (const std::size_t sound : drawn) parts.push_back(sounds[sound].data);
  return damping::joined(parts);
}

/// @throws Error  there is no fit
std::vector<double> parameters_of(const damping::DampingData& data,
                                  const DampingValidation& validation,
                                  damping::Estimator estimator) {
  if (data.size() == 0) throw core::InputError("no sound that was drawn has a feature");
  damping::FitOptions options;
  options.estimator = estimator;
  options.confidence = false;
  const damping::DampingFit fit = damping::fit_damping(data, validation.law, options);
  for (const double parameter : fit.model.parameters) {
    if (!std::isfinite(parameter)) throw core::SolverError("a parameter that is not finite");
  }
  return fit.model.parameters;
}

}  // namespace

json to_json(const BlockFits& block) {
  json fits = json::object();
  for (const auto& [estimator, draws] : block.fits) {
    fits[estimator] = json::array();
    for (const std::vector<double>& parameters : draws) {
      fits[estimator].push_back(parameters.empty() ? json() : json(parameters));
    }
  }
  return {{"inputs", block.inputs},
          {"block", block.block},
          {"points", block.points},
          {"fits", fits},
          {"why", block.why}};
}

BlockFits fits_from(const json& line) {
  BlockFits block{.inputs = line.at("inputs"),
                  .block = line.at("block"),
                  .points = line.at("points"),
                  .fits = {},
                  .why = line.at("why")};
  for (const auto& [estimator, draws] : line.at("fits").items()) {
    for (const json& parameters : draws) {
      block.fits[estimator].push_back(parameters.is_null() ? std::vector<double>{}
                                                           : parameters.get<std::vector<double>>());
    }
  }
  return block;
}

BlockFits compute_fits(const FitBlock& block, const DampingValidation& validation,
                       const EvaluatedDatasets& datasets, FeatureStore& store) {
  const std::string& material = validation.materials[block.condition][block.material].name;
  const std::string& from = validation.from[block.from];
  auto objects =
      SoundsByObject(datasets.conditions()[block.condition].build->plan).objects(material);
  const std::vector<SoundFeatures>& sounds = store.sounds(block.condition, block.source);
  for (auto& object : objects)
    std::erase_if(object, [&](std::size_t i) { return !sounds[i].there; });
  if (from == "material") {
    std::vector<std::size_t> all;
    for (const auto& object : objects) all.insert(all.end(), object.begin(), object.end());
    objects = {all};
  }
  BlockFits result{.inputs = block.inputs, .block = block.key, .points = 0, .fits = {}, .why = {}};
  std::vector<double> points;
  for (int draw = 0; draw < validation.draws; ++draw) {
    core::RandomStream random(
        validation.seed,
        core::stable_hash(fmt::format("{}/{}/{}/{}", material, from, block.sounds, draw)),
        "evaluate.damping.sounds");
    const auto data = data_of(validation::draw_sounds(objects, block.sounds, random), sounds);
    points.push_back(static_cast<double>(data.size()));
    for (const NamedEstimator& estimator : validation.estimators) {
      std::vector<double>& parameters = result.fits[estimator.name].emplace_back();
      try {
        parameters = parameters_of(data, validation, estimator.estimator);
      } catch (const core::Error& error) {
        // Too few features for this set of sounds; the others go on.
        result.why.emplace(estimator.name, error.message());
      }
    }
  }
  result.points = core::median(points);
  return result;
}

}  // namespace carillon::eval::studies
