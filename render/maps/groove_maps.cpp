#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "render/maps/detail/patterns.hpp"

namespace carillon::render::maps {

SurfaceMap groove_map(const PatternValues& values, int texels, std::uint64_t) {
  const double wavelength = values.positive("wavelength");
  const double depth = values.positive("depth");
  const int waves = values.count("waves");
  const double round = values.not_negative("round");
  if (round != 0 && round != 1) {
    values.refuse(fmt::format("round is {}", round), "0 for a sine, 1 for round ridges");
  }
  if (round == 1 && depth > wavelength / 2) {
    values.refuse(fmt::format("ridges {} m apart that are arcs of circles cannot be {} m deep",
                              wavelength, depth),
                  "a depth of at most half a wavelength");
  }
  // A whole number of texels a wave: each is as long as asked for, to the last bit, and alike.
  const int per_wave = texels / waves;
  if (per_wave < 4) {
    values.refuse(fmt::format("{} waves need more than {} texels", waves, texels),
                  "at least 4 texels a wave");
  }
  const int width = per_wave * waves;
  const PatternGrid grid(waves * wavelength, waves * wavelength, width);
  const double radius = (wavelength * wavelength / 4 + depth * depth) / (2 * depth);
  std::vector<double> profile;
  for (int i = 0; i < per_wave; ++i) {
    const double place = (i + 0.5) / per_wave - 0.5;  // of a wave, from the ridge
    const double off = place * wavelength;
    profile.push_back(round == 1 ? std::sqrt(radius * radius - off * off) - radius
                                 : depth / 2 * (std::cos(2 * std::numbers::pi * place) - 1));
  }
  std::vector<double> heights;
  heights.reserve(std::size_t(width) * std::size_t(width));
  for (int row = 0; row < width; ++row) {
    for (int column = 0; column < width; ++column) {
      heights.push_back(profile[std::size_t(column % per_wave)]);
    }
  }
  return relief_of(values.map(), grid, heights);
}

}  // namespace carillon::render::maps
