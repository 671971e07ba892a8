#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <tuple>

#include "core/json.hpp"
#include "core/numbers.hpp"
#include "eval/studies/detail/damping_tables.hpp"
#include "eval/validation/estimator_errors.hpp"
#include "mpi/comm.hpp"

namespace carillon::eval::studies {

using nlohmann::json;
using nlohmann::ordered_json;

namespace {

constexpr double unknown = std::numeric_limits<double>::quiet_NaN();
constexpr const char* all_materials = "all";

/// Fits that are looked at together: of one material, or of all of them.
struct Group {
  std::size_t condition = 0, source = 0, from = 0, sounds = 0;
  std::string material;
  std::vector<std::size_t> blocks;
};

std::vector<Group> groups_of(const DampingValidation& validation,
                             const std::vector<FitBlock>& blocks) {
  std::vector<Group> groups;
  std::map<std::tuple<std::size_t, std::size_t, std::size_t, std::size_t>, Group> of_all;
  for (std::size_t b = 0; b < blocks.size(); ++b) {
    const FitBlock& block = blocks[b];
    const std::string& name = validation.materials[block.condition][block.material].name;
    groups.push_back({block.condition, block.source, block.from, block.sounds, name, {b}});
    Group& all = of_all[{block.condition, block.source, block.from, block.sounds}];
    all.condition = block.condition;
    all.source = block.source;
    all.from = block.from;
    all.sounds = block.sounds;
    all.material = all_materials;
    all.blocks.push_back(b);
  }
  for (auto& [key, group] : of_all) groups.push_back(std::move(group));
  return groups;
}

/// Relative errors of one parameter by one estimator, draw by draw; NaN for fits that failed.
std::vector<double> errors_of(const Group& group, const std::string& estimator, std::size_t p,
                              const DampingValidation& validation,
                              const std::vector<FitBlock>& blocks, const FitResults& results) {
  std::vector<double> errors;
  for (const std::size_t b : group.blocks) {
    const FitBlock& block = blocks[b];
    const double truth = validation.materials[block.condition][block.material].parameters[p];
    if (results[b].is_null()) {
      errors.insert(errors.end(), static_cast<std::size_t>(validation.draws), unknown);
      continue;
    }
    for (const json& fit : results[b].at("fits").at(estimator)) {
      errors.push_back(fit.is_null() ? unknown : (fit[p].get<double>() - truth) / truth);
    }
  }
  return errors;
}

class Tables {
 public:
  Tables(const DampingValidation& validation, const EvaluatedDatasets& datasets,
         const std::vector<FitBlock>& blocks, const FitResults& results)
      : validation_(validation), datasets_(datasets), blocks_(blocks), results_(results) {}

  /// Rows of one group: its errors, and its estimators against each other.
  ordered_json rows_of(const Group& group) const {
    ordered_json errors = ordered_json::array(), tests = ordered_json::array();
    for (std::size_t p = 0; p < validation_.law.parameters; ++p) {
      std::vector<std::vector<double>> found;
      for (const NamedEstimator& estimator : validation_.estimators) {
        found.push_back(errors_of(group, estimator.name, p, validation_, blocks_, results_));
        errors.push_back(error_row(group, estimator.name, p, found.back()));
      }
      for (std::size_t a = 0; a < found.size(); ++a) {
        for (std::size_t b = a + 1; b < found.size(); ++b) {
          tests.push_back(test_row(group, a, b, p, found[a], found[b]));
        }
      }
    }
    return {{"errors", errors}, {"tests", tests}};
  }

 private:
  ordered_json place_of(const Group& group, std::size_t parameter) const {
    return {{"condition", datasets_.conditions()[group.condition].name},
            {"features", validation_.sources[group.source].name},
            {"from", validation_.from[group.from]},
            {"material", group.material},
            {"sounds", group.sounds},
            {"parameter", synth::damping::parameter_name(parameter)}};
  }

  ordered_json error_row(const Group& group, const std::string& estimator, std::size_t parameter,
                         const std::vector<double>& errors) const {
    ordered_json row = place_of(group, parameter);
    core::RandomStream random(validation_.seed, core::stable_hash(row.dump() + estimator),
                              "evaluate.damping.bootstrap");
    const validation::ErrorSummary summary = validation::summarise_errors(errors, random);
    row["estimator"] = estimator;
    row["fits"] = summary.fits;
    row["failed"] = summary.failed;
    row["median"] = core::number_or_null(summary.median);
    row["median95"] = {core::number_or_null(summary.median95.low),
                       core::number_or_null(summary.median95.high)};
    row["mean"] = core::number_or_null(summary.mean);
    row["lower_quartile"] = core::number_or_null(summary.lower_quartile);
    row["upper_quartile"] = core::number_or_null(summary.upper_quartile);
    row["bias"] = core::number_or_null(summary.bias);
    return row;
  }

  ordered_json test_row(const Group& group, std::size_t a, std::size_t b, std::size_t parameter,
                        const std::vector<double>& first, const std::vector<double>& second) const {
    const validation::EstimatorComparison found = validation::compare_errors(first, second);
    ordered_json row = place_of(group, parameter);
    row["estimators"] = {validation_.estimators[a].name, validation_.estimators[b].name};
    row["pairs"] = found.pairs;
    row["median_difference"] = core::number_or_null(found.median_difference);
    row["signed_rank_p"] = core::number_or_null(found.signed_rank.p);
    row["welch_t"] = core::number_or_null(found.welch.t);
    row["welch_p"] = core::number_or_null(found.welch.p);
    return row;
  }

  const DampingValidation& validation_;
  const EvaluatedDatasets& datasets_;
  const std::vector<FitBlock>& blocks_;
  const FitResults& results_;
};

/// Holm's correction over what is asked at once: all pairs of estimators for one parameter, number
/// of sounds, dataset and source of features, in all materials; all of them together are a family
/// of their own.
void correct(ordered_json& tests) {
  std::map<std::string, std::vector<std::size_t>> families;
  for (std::size_t i = 0; i < tests.size(); ++i) {
    const ordered_json& test = tests[i];
    ordered_json family = {test["condition"], test["features"],  test["from"],
                           test["sounds"],    test["parameter"], test["material"] == all_materials};
    families[family.dump()].push_back(i);
  }
  for (const auto& [family, members] : families) {
    for (const std::string name : {"signed_rank_p", "welch_p"}) {
      std::vector<double> probabilities;
      for (const std::size_t i : members) {
        const ordered_json& p = tests[i][name];
        probabilities.push_back(p.is_null() ? unknown : p.get<double>());
      }
      const std::vector<double> raised = statistics::holm(probabilities);
      for (std::size_t k = 0; k < members.size(); ++k) {
        tests[members[k]][name + "_holm"] = core::number_or_null(raised[k]);
      }
    }
  }
  // The estimator that is nearer to the truth, where that is no chance.
  for (ordered_json& test : tests) {
    const auto significant = [&](const char* name) {
      return !test[name].is_null() && test[name].get<double>() < 0.05;
    };
    test["ahead"] = nullptr;
    if (!significant("signed_rank_p_holm") || test["median_difference"].is_null()) continue;
    const double difference = test["median_difference"];
    if (difference != 0) test["ahead"] = test["estimators"][difference < 0 ? 0 : 1];
  }
}

ordered_json materials_of(const DampingValidation& validation, const EvaluatedDatasets& datasets) {
  ordered_json rows = ordered_json::array();
  for (std::size_t c = 0; c < validation.materials.size(); ++c) {
    for (const TrueMaterial& material : validation.materials[c]) {
      ordered_json row = {{"condition", datasets.conditions()[c].name}, {"name", material.name}};
      for (std::size_t p = 0; p < material.parameters.size(); ++p) {
        row[synth::damping::parameter_name(p)] = material.parameters[p];
      }
      rows.push_back(std::move(row));
    }
  }
  return rows;
}

}  // namespace

ordered_json found_features(const DampingValidation& validation, const EvaluatedDatasets& datasets,
                            FeatureStore& store) {
  ordered_json rows = ordered_json::array();
  for (std::size_t c = 0; c < datasets.conditions().size(); ++c) {
    for (std::size_t s = 0; s < validation.sources.size(); ++s) {
      std::vector<double> counts;
      std::size_t without = 0, features = 0, reverberant = 0;
      for (const SoundFeatures& sound : store.sounds(c, s)) {
        if (!sound.there) continue;
        counts.push_back(static_cast<double>(sound.found));
        features += sound.found;
        reverberant += sound.reverberant;
        if (sound.data.size() == 0) ++without;
      }
      rows.push_back(
          {{"condition", datasets.conditions()[c].name},
           {"features", validation.sources[s].name},
           {"sounds", counts.size()},
           {"sounds_without", without},
           {"median_per_sound", core::number_or_null(core::median(counts))},
           {"reverberant_fraction", core::number_or_null(static_cast<double>(reverberant) /
                                                         static_cast<double>(features))}});
    }
  }
  return rows;
}

ordered_json damping_document(const DampingValidation& validation,
                              const EvaluatedDatasets& datasets,
                              const std::vector<FitBlock>& blocks, const FitResults& results,
                              MPI_Comm world) {
  const std::vector<Group> groups = groups_of(validation, blocks);
  const Tables tables(validation, datasets, blocks, results);
  const auto ranks = static_cast<std::size_t>(mpi::size(world));
  const auto rank = static_cast<std::size_t>(mpi::rank(world));
  ordered_json mine = ordered_json::array();
  mpi::agreed(world, [&] {
    for (std::size_t g = rank; g < groups.size(); g += ranks) {
      mine.push_back(tables.rows_of(groups[g]));
    }
  });
  std::vector<ordered_json> parts;
  for (const std::string& text : mpi::all_gather(mine.dump(), world)) {
    parts.push_back(ordered_json::parse(text));
  }
  ordered_json errors = ordered_json::array(), tests = ordered_json::array();
  for (std::size_t g = 0; g < groups.size(); ++g) {
    for (ordered_json& row : parts[g % ranks].at(g / ranks)["errors"]) {
      errors.push_back(std::move(row));
    }
    for (ordered_json& row : parts[g % ranks].at(g / ranks)["tests"]) {
      tests.push_back(std::move(row));
    }
  }
  correct(tests);
  ordered_json document = {{"name", datasets.name()},
                           {"model", validation.model},
                           {"parameters", ordered_json::array()},
                           {"estimators", ordered_json::array()},
                           {"features", ordered_json::array()},
                           {"conditions", ordered_json::array()},
                           {"sounds", validation.sounds},
                           {"draws", validation.draws},
                           {"from", validation.from},
                           {"materials", materials_of(validation, datasets)}};
  for (std::size_t p = 0; p < validation.law.parameters; ++p) {
    document["parameters"].push_back(synth::damping::parameter_name(p));
  }
  for (const auto& estimator : validation.estimators) {
    document["estimators"].push_back(estimator.name);
  }
  for (const auto& source : validation.sources) document["features"].push_back(source.name);
  for (const auto& condition : datasets.conditions()) {
    document["conditions"].push_back(condition.name);
  }
  document["errors"] = std::move(errors);
  document["tests"] = std::move(tests);
  return document;
}

}  // namespace carillon::eval::studies
