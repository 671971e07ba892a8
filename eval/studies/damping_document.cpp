#include <fmt/format.h>

#include <cmath>
#include <cstring>
#include <string_view>
#include <tuple>
#include <type_traits>

#include "core/json.hpp"
#include "core/numbers.hpp"
#include "eval/studies/detail/damping_tables.hpp"
#include "mpi/comm.hpp"

namespace carillon::eval::studies {

using nlohmann::json;
using nlohmann::ordered_json;

namespace {

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
    if (!results[b]) {
      errors.insert(errors.end(), static_cast<std::size_t>(validation.draws), core::nan);
      continue;
    }
    for (const std::vector<double>& fit : results[b]->fits.at(estimator)) {
      errors.push_back(fit.empty() ? core::nan : (fit[p] - truth) / truth);
    }
  }
  return errors;
}

ordered_json to_json(const DampingPlace& place) {
  return {{"condition", place.condition},
          {"features", place.features},
          {"from", place.from},
          {"material", place.material},
          {"sounds", place.sounds},
          {"parameter", synth::damping::parameter_name(place.parameter)}};
}

template <class Value>
void append_bytes(std::string& text, const Value& value) {
  static_assert(std::is_trivially_copyable_v<Value>);
  text.append(reinterpret_cast<const char*>(&value), sizeof value);
}

template <class Value>
Value simulation_bytes(std::string_view& text) {
  Value value;
  std::memcpy(&value, text.data(), sizeof value);
  text.remove_prefix(sizeof value);
  return value;
}

class Tables {
 public:
  Tables(const DampingValidation& validation, const EvaluatedDatasets& datasets,
         const std::vector<FitBlock>& blocks, const FitResults& results)
      : validation_(validation), datasets_(datasets), blocks_(blocks), results_(results) {}

  /// Numbers of one group's rows, as bytes: of each parameter errors, then tests.
  std::string numbers_of(const Group& group) const {
    std::string numbers;
    for (std::size_t p = 0; p < validation_.law.parameters; ++p) {
      const std::string place = to_json(place_of(group, p)).dump();
      std::vector<std::vector<double>> found;
      for (const NamedEstimator& estimator : validation_.estimators) {
        found.push_back(errors_of(group, estimator.name, p, validation_, blocks_, results_));
        core::RandomStream random(validation_.seed, core::stable_hash(place + estimator.name),
                                  "evaluate.damping.bootstrap");
        append_bytes(numbers, validation::summarise_errors(found.back(), random));
      }
      for (std::size_t a = 0; a < found.size(); ++a) {
        for (std::size_t b = a + 1; b < found.size(); ++b) {
          append_bytes(numbers, validation::compare_errors(found[a], found[b]));
        }
      }
    }
    return numbers;
  }

  /// Rows of one group: its errors, and its estimators against each other.
  void add_rows(const Group& group, std::string_view& numbers, DampingFindings& findings) const {
    const std::vector<NamedEstimator>& estimators = validation_.estimators;
    for (std::size_t p = 0; p < validation_.law.parameters; ++p) {
      const DampingPlace place = place_of(group, p);
      for (const NamedEstimator& estimator : estimators) {
        findings.errors.push_back(
            {place, estimator.name, simulation_bytes<validation::ErrorSummary>(numbers)});
      }
      for (std::size_t a = 0; a < estimators.size(); ++a) {
        for (std::size_t b = a + 1; b < estimators.size(); ++b) {
          findings.tests.push_back({place, estimators[a].name, estimators[b].name,
                                    simulation_bytes<validation::EstimatorComparison>(numbers)});
        }
      }
    }
  }

 private:
  DampingPlace place_of(const Group& group, std::size_t parameter) const {
    return {datasets_.conditions()[group.condition].name,
            validation_.sources[group.source].name,
            validation_.from[group.from],
            group.material,
            group.sounds,
            parameter};
  }

  const DampingValidation& validation_;
  const EvaluatedDatasets& datasets_;
  const std::vector<FitBlock>& blocks_;
  const FitResults& results_;
};

/// Raises probabilities after Holm, and says which estimator is ahead.
void correct(std::vector<DampingTest>& tests) {
  std::map<DampingPlace, std::vector<DampingTest*>> families;
  for (DampingTest& test : tests) {
    DampingPlace family = test.place;
    if (family.material != all_materials) family.material = "each";
    families[family].push_back(&test);
  }
  for (const auto& [family, members] : families) {
    std::vector<double> signed_rank, welch;
    for (const DampingTest* test : members) {
      signed_rank.push_back(test->found.signed_rank.p);
      welch.push_back(test->found.welch.p);
    }
    signed_rank = statistics::holm(signed_rank);
    welch = statistics::holm(welch);
    for (std::size_t i = 0; i < members.size(); ++i) {
      members[i]->signed_rank_holm = signed_rank[i];
      members[i]->welch_holm = welch[i];
    }
  }
  for (DampingTest& test : tests) {
    const double difference = test.found.median_difference;
    if (!(test.signed_rank_holm < 0.05) || !std::isfinite(difference) || difference == 0) continue;
    test.ahead = difference < 0 ? test.first : test.second;
  }
}

ordered_json to_json(const DampingErrors& errors) {
  const validation::ErrorSummary& summary = errors.summary;
  ordered_json row = to_json(errors.place);
  row["estimator"] = errors.estimator;
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

ordered_json to_json(const DampingTest& test) {
  ordered_json row = to_json(test.place);
  row["estimators"] = {test.first, test.second};
  row["pairs"] = test.found.pairs;
  row["median_difference"] = core::number_or_null(test.found.median_difference);
  row["signed_rank_p"] = core::number_or_null(test.found.signed_rank.p);
  row["welch_t"] = core::number_or_null(test.found.welch.t);
  row["welch_p"] = core::number_or_null(test.found.welch.p);
  row["signed_rank_p_holm"] = core::number_or_null(test.signed_rank_holm);
  row["welch_p_holm"] = core::number_or_null(test.welch_holm);
  row["ahead"] = test.ahead.empty() ? ordered_json() : ordered_json(test.ahead);
  return row;
}

ordered_json to_json(const FoundFeatures& found) {
  return {{"condition", found.condition},
          {"features", found.features},
          {"sounds", found.sounds},
          {"sounds_without", found.without},
          {"median_per_sound", core::number_or_null(found.median_per_sound)},
          {"reverberant_fraction", core::number_or_null(found.reverberant_fraction)}};
}

template <class Row>
ordered_json list_of(const std::vector<Row>& rows) {
  ordered_json list = ordered_json::array();
  for (const Row& row : rows) list.push_back(to_json(row));
  return list;
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

std::vector<FoundFeatures> count_features(const DampingValidation& validation,
                                          const EvaluatedDatasets& datasets, FeatureStore& store) {
  std::vector<FoundFeatures> rows;
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
      rows.push_back({datasets.conditions()[c].name, validation.sources[s].name, counts.size(),
                      without, core::median(counts),
                      static_cast<double>(reverberant) / static_cast<double>(features)});
    }
  }
  return rows;
}

DampingFindings find_errors(const DampingValidation& validation, const EvaluatedDatasets& datasets,
                            const std::vector<FitBlock>& blocks, const FitResults& results,
                            MPI_Comm world) {
  const std::vector<Group> groups = groups_of(validation, blocks);
  const Tables tables(validation, datasets, blocks, results);
  const auto ranks = static_cast<std::size_t>(mpi::size(world));
  const auto rank = static_cast<std::size_t>(mpi::rank(world));
  std::string mine;
  mpi::agreed(world, [&] {
    for (std::size_t g = rank; g < groups.size(); g += ranks) mine += tables.numbers_of(groups[g]);
  });
  const std::vector<std::string> parts = mpi::all_gather(mine, world);
  std::vector<std::string_view> rest(parts.begin(), parts.end());
  DampingFindings findings;
  for (std::size_t g = 0; g < groups.size(); ++g) {
    tables.add_rows(groups[g], rest[g % ranks], findings);
  }
  correct(findings.tests);
  return findings;
}

ordered_json damping_json(const DampingValidation& validation, const EvaluatedDatasets& datasets,
                          const DampingFindings& findings, const std::vector<json>& failures) {
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
  document["errors"] = list_of(findings.errors);
  document["tests"] = list_of(findings.tests);
  document["failures"] = failures;
  document["found_features"] = list_of(findings.features);
  return document;
}

}  // namespace carillon::eval::studies
