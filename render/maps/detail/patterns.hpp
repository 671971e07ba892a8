#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "render/maps/surface_map.hpp"

namespace carillon::render::maps {

/// Parameters of a generated map, asked for by name.
class PatternValues {
 public:
  PatternValues(std::string map, const std::map<std::string, double>& values)
      : map_(std::move(map)), values_(values) {}
  /// @throws InputError  what it says cannot be; names map and parameter
  double positive(const std::string& name) const;
  double not_negative(const std::string& name) const;
  int count(const std::string& name) const;  ///< a whole number from 1 on
  [[noreturn]] void refuse(const std::string& message, const std::string& hint) const;
  /// A detail that fewer than `minimum` texels would draw is refused.
  void check_detail(const std::string& name, double length, double texel, double minimum) const;
  const std::string& map() const { return map_; }

 private:
  std::string map_;
  const std::map<std::string, double>& values_;
};

/// Texels in which a rectangle repeats: square ones, `texels` along its longer side; the shorter is
/// stretched to a whole number of them.
struct PatternGrid {
  PatternGrid(double length_u, double length_v, int texels);
  int width, height;
  double texel;
  Eigen::Array2d stretch;  ///< texels' size over what it would be unstretched
  /// Centre of a texel in the rectangle as it was asked for [m].
  Eigen::Vector2d at(int column, int row) const {
    return {(column + 0.5) * texel / stretch.x(), (row + 0.5) * texel / stretch.y()};
  }
};

/// The relief of heights [m], shifted so that the highest is 0.
SurfaceMap relief_of(const std::string& name, const PatternGrid& grid,
                     const std::vector<double>& heights);

/// Gaussian noise that repeats over the grid, of mean 0 and rms 1, row by row. The power spectral
/// density of a profile falls as wave number to the power -exponent from the longest to the
/// shortest wave [m]. Coarse waves are drawn first: the same seed is the same surface in more
/// texels.
std::vector<double> fractal_noise(const PatternGrid& grid, double exponent, double longest,
                                  double shortest, std::uint64_t seed, std::string_view purpose);

SurfaceMap brick_map(const PatternValues& values, int texels, std::uint64_t seed);
SurfaceMap tile_map(const PatternValues& values, int texels, std::uint64_t seed);
SurfaceMap groove_map(const PatternValues& values, int texels, std::uint64_t seed);
SurfaceMap pebble_map(const PatternValues& values, int texels, std::uint64_t seed);
SurfaceMap noise_map(const PatternValues& values, int texels, std::uint64_t seed);

}  // namespace carillon::render::maps
