#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "render/maps/detail/fourier_grid.hpp"
#include "render/maps/surface_map.hpp"

namespace carillon::render::maps {
namespace {

using std::numbers::pi;

/// Inner products of the cubic B-spline with itself and with its neighbours, as functions of the
/// wave number k [rad per texel]: samples of the B-spline of degree 7 and of its derivatives.
struct Products {
  double values;  ///< spline times spline
  double mixed;   ///< slope times spline, over -i
  double slopes;  ///< slope times slope
};

Products products_at(double k) {
  const double c1 = std::cos(k), c2 = std::cos(2 * k), c3 = std::cos(3 * k);
  const double s1 = std::sin(k), s2 = std::sin(2 * k), s3 = std::sin(3 * k);
  return {(2416 + 2 * (1191 * c1 + 120 * c2 + c3)) / 5040, 2 * (245 * s1 + 56 * s2 + s3) / 720,
          (80 - 2 * (15 * c1 + 24 * c2 + c3)) / 120};
}

std::vector<Products> products(int count, double step) {
  std::vector<Products> all;
  for (int k = 0; k < count; ++k) all.push_back(products_at(k * step));
  return all;
}

/// Normal equations of one wave: both slopes' errors in the mean square, with the sign of i left to
/// the caller. The mean height is free: 0.
template <class T>
T height_of_wave(const Products& u, const Products& v, const T& slope_u, const T& slope_v) {
  const double stiffness = u.slopes * v.values + u.values * v.slopes;
  if (!(stiffness > 1e-14)) return T{};
  return (u.mixed * v.values * slope_u + u.values * v.mixed * slope_v) / stiffness;
}

std::vector<double> repeating(const SurfaceMap& map) {
  const int width = map.width, height = map.height;
  FourierGrid u(width, height), v(width, height);
  std::size_t texel = 0;
  for (int row = 0; row < height; ++row) {
    for (int column = 0; column < width; ++column, ++texel) {
      u.at(column, row) = map.slopes_u[texel];
      v.at(column, row) = map.slopes_v[texel];
    }
  }
  u.forward();
  v.forward();
  const auto along_u = products(u.waves(), 2 * pi / width);
  const auto along_v = products(height, 2 * pi / height);
  for (int row = 0; row < height; ++row) {
    for (int column = 0; column < u.waves(); ++column) {
      u.wave(column, row) *= std::complex<double>(0, -1);
      v.wave(column, row) *= std::complex<double>(0, -1);
      u.wave(column, row) = height_of_wave(along_u[std::size_t(column)], along_v[std::size_t(row)],
                                           u.wave(column, row), v.wave(column, row));
    }
  }
  u.inverse();
  std::vector<double> heights;
  heights.reserve(texel);
  for (int row = 0; row < height; ++row) {
    for (int column = 0; column < width; ++column) {
      heights.push_back(u.at(column, row) / (double(width) * height));
    }
  }
  return heights;
}

/// The relief goes on mirrored, so that its slopes across an edge change their sign there: sums of
/// cosines, whose slopes are sines of the opposite sign.
std::vector<double> mirrored(const SurfaceMap& map) {
  const int width = map.width, height = map.height;
  std::vector<double> u(map.slopes_u.begin(), map.slopes_u.end());
  std::vector<double> v(map.slopes_v.begin(), map.slopes_v.end());
  to_mirrored_waves(u, width, height, core::Mirrored::odd, core::Mirrored::even);
  to_mirrored_waves(v, width, height, core::Mirrored::even, core::Mirrored::odd);
  const auto along_u = products(width, pi / width);
  const auto along_v = products(height, pi / height);
  std::vector<double> heights(u.size());
  const auto at = [&](int column, int row) {
    return std::size_t(row) * std::size_t(width) + std::size_t(column);
  };
  for (int row = 0; row < height; ++row) {
    for (int column = 0; column < width; ++column) {
      const double slope_u = column == 0 ? 0 : u[at(column - 1, row)];
      const double slope_v = row == 0 ? 0 : v[at(column, row - 1)];
      heights[at(column, row)] = -height_of_wave(along_u[std::size_t(column)],
                                                 along_v[std::size_t(row)], slope_u, slope_v);
    }
  }
  from_mirrored_waves(heights, width, height);
  return heights;
}

}  // namespace

SurfaceMap integrated_relief(const SurfaceMap& map) {
  if (map.relief()) return map;
  const std::vector<double> heights = map.repeats ? repeating(map) : mirrored(map);
  const double highest = *std::max_element(heights.begin(), heights.end());
  SurfaceMap relief = map;
  relief.slopes_u.clear();
  relief.slopes_v.clear();
  relief.heights.reserve(heights.size());
  for (const double height : heights) {
    relief.heights.push_back(static_cast<float>((height - highest) * map.texel));
  }
  return relief;
}

}  // namespace carillon::render::maps
