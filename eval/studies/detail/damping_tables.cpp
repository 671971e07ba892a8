#include "eval/studies/detail/damping_tables.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/csv.hpp"

namespace carillon::eval::studies {

using nlohmann::json;
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
    if (results[b].is_null()) continue;
    const FitBlock& block = blocks[b];
    const std::vector<std::string> place = {
        datasets.conditions()[block.condition].name, validation.sources[block.source].name,
        validation.from[block.from], validation.materials[block.condition][block.material].name,
        std::to_string(block.sounds)};
    for (const NamedEstimator& estimator : validation.estimators) {
      const json& fits = results[b].at("fits").at(estimator.name);
      for (std::size_t draw = 0; draw < fits.size(); ++draw) {
        std::vector<std::string> cells = place;
        cells.insert(cells.end(), {std::to_string(draw), estimator.name});
        for (std::size_t p = 0; p < validation.law.parameters; ++p) {
          cells.push_back(fits[draw].is_null() ? "" : core::csv_value(fits[draw][p]));
        }
        csv += core::csv_line(cells);
      }
    }
  }
  return csv;
}

namespace {

/// Errors by what a table has in its rows and columns.
class Errors {
 public:
  explicit Errors(const ordered_json& rows) {
    for (const ordered_json& row : rows) {
      by_place_[place(row["condition"], row["features"], row["from"], row["material"],
                      row["sounds"], row["parameter"], row["estimator"])] = &row;
    }
  }

  /// "12 % (5 to 31)": median and quartiles of the magnitude.
  std::string text(const std::string& condition, const std::string& features,
                   const std::string& from, const std::string& material, std::size_t sounds,
                   const std::string& parameter, const std::string& estimator) const {
    const ordered_json& row =
        *by_place_.at(place(condition, features, from, material, sounds, parameter, estimator));
    if (row["median"].is_null()) return "no fit";
    const auto percent = [&](const char* name) {
      const double value = 100 * row[name].get<double>();
      if (value < 0.01) return std::string("<0.01");
      return value < 9.95 ? fmt::format("{:.2g}", value) : fmt::format("{:.0f}", value);
    };
    return fmt::format("{} % ({} to {})", percent("median"), percent("lower_quartile"),
                       percent("upper_quartile"));
  }

 private:
  static std::string place(const std::string& condition, const std::string& features,
                           const std::string& from, const std::string& material, std::size_t sounds,
                           const std::string& parameter, const std::string& estimator) {
    return fmt::format("{}\n{}\n{}\n{}\n{}\n{}\n{}", condition, features, from, material, sounds,
                       parameter, estimator);
  }
  std::map<std::string, const ordered_json*> by_place_;
};

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
std::string found_text(const ordered_json& found, const std::string& condition,
                       const std::string& features) {
  for (const ordered_json& row : found) {
    if (row["condition"] != condition || row["features"] != features) continue;
    std::string text =
        row["median_per_sound"].is_null()
            ? "no sounds"
            : fmt::format("{:g} features a sound", row["median_per_sound"].get<double>());
    const double fraction =
        row["reverberant_fraction"].is_null() ? 0 : row["reverberant_fraction"].get<double>();
    if (fraction > 0) text += fmt::format(", {:.0f} % of them may be the room's", 100 * fraction);
    return text + fmt::format("; {} of {} sounds have none to fit\n",
                              row["sounds_without"].get<std::size_t>(),
                              row["sounds"].get<std::size_t>());
  }
  return "";
}

/// How often each of two estimators is ahead, of the materials.
std::string ahead_text(const ordered_json& tests, const std::string& condition,
                       const std::string& features, const std::string& from, std::size_t sounds) {
  struct Count {
    int first = 0, second = 0, all = 0;
  };
  std::map<std::string, Count> counts;
  std::vector<std::string> order;
  for (const ordered_json& test : tests) {
    if (test["condition"] != condition || test["features"] != features || test["from"] != from ||
        test["sounds"] != sounds || test["material"] == "all") {
      continue;
    }
    const std::string first = test["estimators"][0], second = test["estimators"][1];
    const std::string key =
        fmt::format("{}: {} against {}", test["parameter"].get<std::string>(), first, second);
    if (!counts.contains(key)) order.push_back(key);
    Count& count = counts[key];
    ++count.all;
    if (test["ahead"] == first) ++count.first;
    if (test["ahead"] == second) ++count.second;
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

std::string damping_text(const DampingValidation& validation, const ordered_json& document) {
  const Errors errors(document["errors"]);
  const std::vector<std::string> parameters = document["parameters"];
  const std::string from = validation.from.front();
  const std::size_t usual = usual_sounds(validation.sounds);
  std::string text;
  for (const std::string condition : document["conditions"]) {
    for (const std::string features : document["features"]) {
      text +=
          fmt::format("\n{}, features: {}, sounds of one {}: relative error, median (quartiles)\n",
                      condition, features, from);
      text += found_text(document["found_features"], condition, features);
      std::string above(name_width, ' '), head(name_width, ' ');
      for (const std::string& parameter : parameters) {
        above += fmt::format("{:<{}}", parameter, width * validation.estimators.size());
        for (const NamedEstimator& estimator : validation.estimators) {
          head += fmt::format("{:<{}}", estimator.name, width);
        }
      }
      text += above + "\n" + head + "\n";
      const auto line = [&](const std::string& name, const std::string& material,
                            std::size_t sounds) {
        text += fmt::format("{:<{}}", name, name_width);
        for (const std::string& parameter : parameters) {
          for (const NamedEstimator& estimator : validation.estimators) {
            text += fmt::format(
                "{:<{}}",
                errors.text(condition, features, from, material, sounds, parameter, estimator.name),
                width);
          }
        }
        text += "\n";
      };
      for (const std::size_t sounds : validation.sounds) {
        line(fmt::format("{} sound{}", sounds, sounds == 1 ? "" : "s"), "all", sounds);
      }
      for (const ordered_json& material : document["materials"]) {
        if (material["condition"] != condition) continue;
        const std::string name = material["name"];
        line(fmt::format("{}: {:.14}", usual, name), name, usual);
      }
      text += fmt::format("{} sounds, signed-rank test after Holm, p < 0.05:\n", usual);
      text += ahead_text(document["tests"], condition, features, from, usual);
    }
  }
  return text;
}

}  // namespace carillon::eval::studies
