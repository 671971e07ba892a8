#include "report/detail/shape_row.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "core/error.hpp"
#include "core/hdf5.hpp"
#include "core/numbers.hpp"

namespace carillon::report {

using dataset::samples::PlacedVariants;
using nlohmann::json;
using nlohmann::ordered_json;

namespace {

/// The modes of a set, each in the first variant that has it in the band.
void add_errors(const dataset::configuration::BuildConfig& config,
                const dataset::plan::Shape& shape, const PlacedVariants& placed, std::size_t set,
                const core::Hdf5Group& file, std::vector<ModeError>& errors) {
  if (!file.has("pitch_errors")) return;
  const auto eigenvalues = file.read<double>("eigenvalues");
  const auto cents = file.read<double>("pitch_errors");
  const auto& variants = placed.sets.variants;
  for (std::size_t mode = 0; mode < std::min(eigenvalues.size(), cents.size()); ++mode) {
    const auto hertz_in = [&](std::size_t variant, std::size_t which) {
      return dataset::samples::frequency_factor(variants[variant]) * std::sqrt(eigenvalues[which]) /
             (2 * std::numbers::pi);
    };
    for (std::size_t v = 0; v < variants.size(); ++v) {
      const double hertz = hertz_in(v, mode);
      if (variants[v].set != set || hertz < config.band.min_frequency ||
          hertz > config.band.max_frequency) {
        continue;
      }
      std::size_t below = 0;
      while (hertz_in(v, below) < config.band.min_frequency) ++below;
      errors.push_back({cents[mode], hertz, &shape, &shape.variants[v], variants[v].length, set,
                        mode, mode - below + 1});
      break;
    }
  }
}

/// What the object's modes file says: of several sets, the worst.
void add_modes(const dataset::configuration::BuildConfig& config, const dataset::plan::Shape& shape,
               const core::Hdf5Group& file, ordered_json& row, std::vector<ModeError>& errors) {
  double complete_to = std::numeric_limits<double>::infinity(), unknowns = 0;
  std::uint64_t modes = 0;
  const PlacedVariants placed = dataset::samples::placed_variants(config, shape, file);
  for (std::size_t s = 0; s < placed.sets.requests.size(); ++s) {
    const core::Hdf5Group set = file.open_group(fmt::format("set-{:03}", s));
    const core::Hdf5Group certificate = set.open_group("certificate");
    complete_to = std::min(complete_to, certificate.number_attribute("complete_to_hz"));
    unknowns = std::max(unknowns, certificate.number_attribute("unknowns"));
    modes = std::max(modes, set.extent("eigenvalues").front());
    row["order"] = static_cast<int>(set.open_group("surface").number_attribute("order"));
    add_errors(config, shape, placed, s, set, errors);
  }
  row["modes"] = modes;
  row["complete_to_hz"] = complete_to;
  row["unknowns"] = unknowns;
  const auto cents = dataset::samples::read_pitch_errors(file);
  if (cents.empty()) return;
  row["pitch_error_cents"] = *std::max_element(cents.begin(), cents.end());
  row["median_pitch_error_cents"] = core::median(cents);
}

}  // namespace

ordered_json to_json(const ModeError& mode) {
  return {{"object", mode.shape->id},
          {"family", mode.shape->family},
          {"material", mode.variant->material},
          {"size", mode.size},
          {"set", mode.set},
          {"in_set", mode.in_set},
          {"mode", mode.number},
          {"hertz", mode.hertz},
          {"cents", mode.cents}};
}

void keep_worst(std::vector<ModeError>& all, std::size_t count) {
  std::stable_sort(all.begin(), all.end(),
                   [](const ModeError& a, const ModeError& b) { return a.cents > b.cents; });
  all.resize(std::min(all.size(), count));
}

ordered_json shape_row(const dataset::stored::StoredDataset& dataset,
                       const dataset::plan::Shape& shape, const json& seconds,
                       std::vector<ModeError>& errors) {
  ordered_json row = {{"id", shape.id},
                      {"family", shape.family},
                      {"material", shape.variants.empty() ? "" : shape.variants.front().material},
                      {"split", shape.split_shape},
                      {"variants", shape.variants.size()},
                      {"modes", nullptr},
                      {"complete_to_hz", nullptr},
                      {"pitch_error_cents", nullptr},
                      {"median_pitch_error_cents", nullptr},
                      {"order", nullptr},
                      {"unknowns", nullptr},
                      {"seconds", seconds}};
  const dataset::samples::BuildFolders folders{dataset.folder, {}};
  const std::filesystem::path path = folders.modes_file(shape);
  try {
    if (std::filesystem::is_regular_file(path)) {
      add_modes(dataset.build.config, shape, core::Hdf5Group::open_file(path), row, errors);
    }
  } catch (const core::Error& error) {
    row["failure"] = error.message();
  }
  return row;
}

}  // namespace carillon::report
