#include "eval/studies/detail/damping_tables.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/csv.hpp"

namespace carillon::eval::studies {

using nlohmann::ordered_json;

std::string csv_of(const ordered_json& rows) {
  std::string csv;
  for (const ordered_json& row : rows) {
    std::vector<std::string> names, cells;
    for (const auto& [name, value] : row.items()) {
      if (!value.is_array()) {
        names.push_back(name);
        cells.push_back(core::csv_value(value));
        continue;
      }
      const bool texts = value[0].is_string();
      for (std::size_t i = 0; i < 2; ++i) {
        names.push_back(texts ? (i == 0 ? "first" : "second") : name + (i == 0 ? "_low" : "_high"));
        cells.push_back(core::csv_value(value[i]));
      }
    }
    if (csv.empty()) csv = core::csv_line(names);
    csv += core::csv_line(cells);
  }
  return csv;
}

std::string fits_csv(const DampingValidation& validation, const EvaluatedDatasets& datasets,
                     const std::vector<FitBlock>& blocks, const FitResults& results) {
  std::vector<std::string> names = {"condition", "features", "from",     "material",
                                    "sounds",    "draw",     "estimator"};
  for (std::size_t p = 0; p < validation.law.parameters; ++p) {
    names.push_back(synth::damping::parameter_name(p));
  }
  std::string csv = core::csv_line(names);
  for (std::size_t b = 0; b < blocks.size(); ++b) {
    if (!results[b]) continue;
    const FitBlock& block = blocks[b];
    const std::vector<std::string> place = {
        datasets.conditions()[block.condition].name, validation.sources[block.source].name,
        validation.from[block.from], validation.materials[block.condition][block.material].name,
        std::to_string(block.sounds)};
    for (const NamedEstimator& estimator : validation.estimators) {
      const std::vector<std::vector<double>>& fits = results[b]->fits.at(estimator.name);
      for (std::size_t draw = 0; draw < fits.size(); ++draw) {
        std::vector<std::string> cells = place;
        cells.insert(cells.end(), {std::to_string(draw), estimator.name});
        for (std::size_t p = 0; p < validation.law.parameters; ++p) {
          cells.push_back(fits[draw].empty() ? "" : core::csv_value(fits[draw][p]));
        }
        csv += core::csv_line(cells);
      }
    }
  }
  return csv;
}

namespace {

/// "12 % (5 to 31)": median and quartiles of the magnitude.
std::string error_text(const validation::ErrorSummary& summary) {
  if (!std::isfinite(summary.median)) return "no fit";
  const auto percent = [](double fraction) {
    const double value = 100 * fraction;
    if (value < 0.01) return std::string("<0.01");
    return value < 9.95 ? fmt::format("{:.2g}", value) : fmt::format("{:.0f}", value);
  };
  return fmt::format("{} % ({} to {})", percent(summary.median), percent(summary.lower_quartile),
                     percent(summary.upper_quartile));
}

/// The number of sounds that tables by material are for: the papers' twenty, or what is nearest.
std::size_t usual_sounds(const std::vector<std::size_t>& sounds) {
  constexpr double papers = 20;
  return *std::min_element(sounds.begin(), sounds.end(), [](std::size_t a, std::size_t b) {
    return std::abs(std::log(static_cast<double>(a) / papers)) <
           std::abs(std::log(static_cast<double>(b) / papers));
  });
}

constexpr std::size_t name_width = 20;  // of a table's first column
constexpr std::size_t width = 23;       // of the others

/// "54 features a sound, 12 % of them may be the room's; 3 of 9000 sounds have none".
std::string found_text(const std::vector<FoundFeatures>& found, const std::string& condition,
                       const std::string& features) {
  for (const FoundFeatures& row : found) {
    if (row.condition != condition || row.features != features) continue;
    std::string text = std::isfinite(row.median_per_sound)
                           ? fmt::format("{:g} features a sound", row.median_per_sound)
                           : "no sounds";
    if (row.reverberant_fraction > 0) {
      text += fmt::format(", {:.0f} % of them may be the room's", 100 * row.reverberant_fraction);
    }
    return text + fmt::format("; {} of {} sounds have none to fit\n", row.without, row.sounds);
  }
  return "";
}

/// How often each of two estimators is ahead, of the materials.
std::string ahead_text(const std::vector<DampingTest>& tests, const std::string& condition,
                       const std::string& features, const std::string& from, std::size_t sounds) {
  struct Count {
    int first = 0, second = 0, all = 0;
  };
  std::map<std::string, Count> counts;
  std::vector<std::string> order;
  for (const DampingTest& test : tests) {
    const DampingPlace& place = test.place;
    if (place.condition != condition || place.features != features || place.from != from ||
        place.sounds != sounds || place.material == "all") {
      continue;
    }
    const std::string key =
        fmt::format("{}: {} against {}", synth::damping::parameter_name(place.parameter),
                    test.first, test.second);
    if (!counts.contains(key)) order.push_back(key);
    Count& count = counts[key];
    ++count.all;
    if (test.ahead == test.first) ++count.first;
    if (test.ahead == test.second) ++count.second;
  }
  std::string text;
  for (const std::string& key : order) {
    const Count& count = counts[key];
    text += fmt::format("  {}: ahead in {}, behind in {} of {} materials\n", key, count.first,
                        count.second, count.all);
  }
  return text;
}

}  // namespace

std::string damping_text(const DampingValidation& validation, const EvaluatedDatasets& datasets,
                         const DampingFindings& findings) {
  std::map<std::pair<DampingPlace, std::string>, std::string> errors;
  for (const DampingErrors& row : findings.errors) {
    errors[{row.place, row.estimator}] = error_text(row.summary);
  }
  const std::string from = validation.from.front();
  const std::size_t usual = usual_sounds(validation.sounds);
  std::string text;
  for (std::size_t c = 0; c < datasets.conditions().size(); ++c) {
    const std::string& condition = datasets.conditions()[c].name;
    for (const FeatureSource& source : validation.sources) {
      text +=
          fmt::format("\n{}, features: {}, sounds of one {}: relative error, median (quartiles)\n",
                      condition, source.name, from);
      text += found_text(findings.features, condition, source.name);
      std::string above(name_width, ' '), head(name_width, ' ');
      for (std::size_t p = 0; p < validation.law.parameters; ++p) {
        above += fmt::format("{:<{}}", synth::damping::parameter_name(p),
                             width * validation.estimators.size());
        for (const NamedEstimator& estimator : validation.estimators) {
          head += fmt::format("{:<{}}", estimator.name, width);
        }
      }
      text += fmt::format("{}\n{}\n", above, head);
      const auto line = [&](const std::string& name, const std::string& material,
                            std::size_t sounds) {
        text += fmt::format("{:<{}}", name, name_width);
        for (std::size_t p = 0; p < validation.law.parameters; ++p) {
          const DampingPlace place{condition, source.name, from, material, sounds, p};
          for (const NamedEstimator& estimator : validation.estimators) {
            text += fmt::format("{:<{}}", errors.at({place, estimator.name}), width);
          }
        }
        text += "\n";
      };
      for (const std::size_t sounds : validation.sounds) {
        line(fmt::format("{} sound{}", sounds, sounds == 1 ? "" : "s"), "all", sounds);
      }
      for (const TrueMaterial& material : validation.materials[c]) {
        line(fmt::format("{}: {:.14}", usual, material.name), material.name, usual);
      }
      text += fmt::format("{} sounds, signed-rank test after Holm, p < 0.05:\n", usual);
      text += ahead_text(findings.tests, condition, source.name, from, usual);
    }
  }
  return text;
}

}  // namespace carillon::eval::studies
