#include "render/maps/generated_maps.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "core/error.hpp"
#include "core/units.hpp"
#include "render/maps/detail/patterns.hpp"

namespace carillon::render::maps {
namespace {

struct Pattern {
  GeneratedMap map;
  SurfaceMap (*make)(const PatternValues& values, int texels, std::uint64_t seed);
};

const std::vector<Pattern>& patterns() {
  static const std::vector<Pattern> all = {
      {{"brick",
        "bricks in running bond with sunk mortar",
        {{"length", 0.215},
         {"height", 0.065},
         {"mortar", 0.010},
         {"mortar_depth", 0.004},
         {"rounding", 0.003},
         {"unevenness", 0.0001},
         {"columns", 2},
         {"rows", 4}}},
       brick_map},
      {{"grooves",
        "straight grooves along v, a sine across (round: 0) or ridges that are arcs (round: 1)",
        {{"wavelength", 0.002}, {"depth", 0.0002}, {"waves", 16}, {"round", 0}}},
       groove_map},
      {{"pebbles",
        "rounded stones side by side",
        {{"size", 0.02}, {"depth", 0.006}, {"irregularity", 0.7}, {"columns", 8}}},
       pebble_map},
      {{"tiles",
        "square tiles with sunk joints",
        {{"side", 0.1},
         {"gap", 0.004},
         {"gap_depth", 0.002},
         {"rounding", 0.001},
         {"unevenness", 0},
         {"columns", 2}}},
       tile_map},
      {{"noise",
        "fractal noise: its profiles' power falls as wave number to the power -exponent",
        {{"length", 0.1}, {"rms", 0.0002}, {"exponent", 2.5}, {"longest", 0.05}, {"shortest", 0}}},
       noise_map}};
  return all;
}

std::string hint_for(const std::string& name, const std::vector<std::string>& known) {
  const std::string nearest = core::nearest_name(name, known);
  return nearest.empty() ? fmt::format("known: {}", fmt::join(known, ", "))
                         : fmt::format("did you mean \"{}\"?", nearest);
}

}  // namespace

const std::vector<GeneratedMap>& generated_maps() {
  static const std::vector<GeneratedMap> all = [] {
    std::vector<GeneratedMap> maps;
    for (const Pattern& pattern : patterns()) maps.push_back(pattern.map);
    return maps;
  }();
  return all;
}

SurfaceMap generate_map(const std::string& name, const std::map<std::string, double>& parameters,
                        int texels, std::uint64_t seed) {
  std::vector<std::string> names;
  for (const Pattern& pattern : patterns()) {
    names.push_back(pattern.map.name);
    if (pattern.map.name != name) continue;
    std::map<std::string, double> values = pattern.map.defaults;
    std::vector<std::string> known;
    for (const auto& [parameter, value] : values) known.push_back(parameter);
    for (const auto& [parameter, value] : parameters) {
      const auto found = values.find(parameter);
      if (found == values.end()) {
        throw core::InputError(fmt::format("map {}: there is no parameter \"{}\"", name, parameter),
                               hint_for(parameter, known));
      }
      found->second = value;
    }
    if (texels < 16 || texels > 4096) {
      throw core::InputError(
          fmt::format("map {}: 16 to 4096 texels along the longer side, not {}", name, texels));
    }
    return pattern.make({name, values}, texels, seed);
  }
  throw core::InputError(fmt::format("there is no map \"{}\"", name), hint_for(name, names));
}

double PatternValues::positive(const std::string& name) const {
  const double value = values_.at(name);
  if (!(value > 0) || !std::isfinite(value)) {
    refuse(fmt::format("{} must be positive, not {}", name, value), "");
  }
  return value;
}

double PatternValues::not_negative(const std::string& name) const {
  const double value = values_.at(name);
  if (!(value >= 0) || !std::isfinite(value)) {
    refuse(fmt::format("{} must not be negative, not {}", name, value), "");
  }
  return value;
}

int PatternValues::count(const std::string& name) const {
  const double value = values_.at(name);
  if (!(value >= 1 && value <= 4096) || value != std::floor(value)) {
    refuse(fmt::format("{} must be a whole number from 1 to 4096, not {}", name, value), "");
  }
  return static_cast<int>(value);
}

void PatternValues::refuse(const std::string& message, const std::string& hint) const {
  throw core::InputError(fmt::format("map {}: {}", map_, message), hint);
}

void PatternValues::check_detail(const std::string& name, double length, double texel,
                                 double minimum) const {
  if (length >= minimum * texel) return;
  refuse(fmt::format("{} of {:.3g} m is less than {} texels of {:.3g} m", name, length, minimum,
                     texel),
         "ask for more texels, or for fewer repetitions in the map");
}

PatternGrid::PatternGrid(double length_u, double length_v, int texels)
    : texel(std::max(length_u, length_v) / texels) {
  width = std::max(4, static_cast<int>(std::lround(length_u / texel)));
  height = std::max(4, static_cast<int>(std::lround(length_v / texel)));
  stretch = {width * texel / length_u, height * texel / length_v};
}

SurfaceMap relief_of(const std::string& name, const PatternGrid& grid,
                     const std::vector<double>& heights) {
  SurfaceMap map;
  map.name = name;
  map.width = grid.width;
  map.height = grid.height;
  map.texel = grid.texel;
  const double highest = *std::max_element(heights.begin(), heights.end());
  map.heights.reserve(heights.size());
  for (const double height : heights) map.heights.push_back(static_cast<float>(height - highest));
  return map;
}

}  // namespace carillon::render::maps
