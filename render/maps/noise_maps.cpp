#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/random.hpp"
#include "render/maps/detail/fourier_grid.hpp"
#include "render/maps/detail/patterns.hpp"

namespace carillon::render::maps {

std::vector<double> fractal_noise(const PatternGrid& grid, double exponent, double longest,
                                  double shortest, std::uint64_t seed, std::string_view purpose) {
  core::RandomStream random(seed, 0, purpose);
  FourierGrid noise(grid.width, grid.height);
  const double size_u = grid.width * grid.texel, size_v = grid.height * grid.texel;
  const double lowest = (1 - 1e-9) / longest;
  const double highest =
      shortest > 0 ? (1 + 1e-9) / shortest : std::numeric_limits<double>::infinity();
  const auto draw = [&](int column, int row) {
    const double a = random.normal(), b = random.normal();
    if (2 * column >= grid.width || 2 * std::abs(row) >= grid.height) return;
    const double wave = std::hypot(column / size_u, row / size_v);
    if (wave < lowest || wave > highest) return;
    // Over all directions, a surface's density falls one power faster than its profiles'.
    const double size = std::pow(wave * std::max(size_u, size_v), -(exponent + 1) / 2);
    const std::complex<double> value(size * a, size * b);
    noise.wave(column, row < 0 ? row + grid.height : row) = value;
    if (column == 0) noise.wave(0, row > 0 ? grid.height - row : -row) = std::conj(value);
  };
  for (int ring = 1; 2 * ring < std::max(grid.width, grid.height); ++ring) {
    for (int column = 0; column <= ring; ++column) {
      draw(column, ring);
      if (column > 0) draw(column, -ring);
    }
    for (int row = 1 - ring; row < ring; ++row) draw(ring, row);
  }
  noise.inverse();
  std::vector<double> values;
  values.reserve(std::size_t(grid.width) * std::size_t(grid.height));
  double square = 0;
  for (int row = 0; row < grid.height; ++row) {
    for (int column = 0; column < grid.width; ++column) {
      values.push_back(noise.at(column, row));
      square += values.back() * values.back();
    }
  }
  const double rms = std::sqrt(square / static_cast<double>(values.size()));
  for (double& value : values) value = rms > 0 ? value / rms : 0;
  return values;
}

SurfaceMap noise_map(const PatternValues& values, int texels, std::uint64_t seed) {
  const double length = values.positive("length");
  const double rms = values.positive("rms");
  const double exponent = values.not_negative("exponent");
  const double longest = values.positive("longest");
  const double shortest = values.not_negative("shortest");
  const PatternGrid grid(length, length, texels);
  if (exponent > 8) values.refuse(fmt::format("an exponent of {}", exponent), "0 to 8");
  values.check_detail("the longest wave", longest, grid.texel, 4);
  if (longest > length) {
    values.refuse(fmt::format("a wave of {} m does not repeat within {} m", longest, length),
                  "a longest wave of at most the length");
  }
  if (shortest > longest) {
    values.refuse(
        fmt::format("the shortest wave, {} m, is longer than the longest, {} m", shortest, longest),
        "");
  }
  std::vector<double> heights =
      fractal_noise(grid, exponent, longest, shortest, seed, "texture.noise");
  const auto [low, high] = std::minmax_element(heights.begin(), heights.end());
  if (*low == *high) {
    values.refuse(
        fmt::format("no wave between {} m and {} m repeats within {} m", shortest, longest, length),
        "leave more room between the shortest and the longest");
  }
  for (double& height : heights) height *= rms;
  return relief_of(values.map(), grid, heights);
}

}  // namespace carillon::render::maps
