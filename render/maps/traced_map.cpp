#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <span>

#include "core/error.hpp"
#include "render/maps/detail/ball_search.hpp"

namespace carillon::render::maps {
namespace {

void check_radius(double radius) {
  if (!(radius >= 0) || !std::isfinite(radius)) {
    throw core::InputError(fmt::format("a tip's radius must not be negative, not {} m", radius));
  }
}

/// Values become the control points of the cubic B-spline that has them at the texels' centres:
/// the recursive filter of Unser, Aldroubi and Eden (1993, part II, table I), whose reach is cut
/// off where it has fallen below the last bit.
void to_control_points(std::span<double> values, bool repeats) {
  const double pole = std::sqrt(3.0) - 2;
  constexpr std::ptrdiff_t reach = 30;
  const auto n = static_cast<std::ptrdiff_t>(values.size());
  const std::vector<double> given(values.begin(), values.end());
  const auto at = [&](std::ptrdiff_t i) {
    const std::ptrdiff_t period = repeats ? n : 2 * n;
    i = (i % period + period) % period;
    return given[static_cast<std::size_t>(i < n ? i : 2 * n - 1 - i)];
  };
  std::vector<double> forward(values.size() + reach);
  double sum = 0;
  for (std::ptrdiff_t i = -reach; i < n + reach; ++i) {
    sum = at(i) + pole * sum;
    if (i >= 0) forward[static_cast<std::size_t>(i)] = sum;
  }
  sum = 0;
  for (std::ptrdiff_t i = n + reach - 1; i >= 0; --i) {
    sum = pole * (sum - forward[static_cast<std::size_t>(i)]);
    if (i < n) values[static_cast<std::size_t>(i)] = 6 * sum;
  }
}

}  // namespace

double traced_height(const SurfaceMap& map, const Eigen::Vector2d& uv, double radius) {
  check_radius(radius);
  if (!map.relief()) return traced_height(integrated_relief(map), uv, radius);
  const double height = height_at(map, uv);
  if (radius == 0 || !std::isfinite(height)) return height;
  const double highest = *std::max_element(map.heights.begin(), map.heights.end());
  const Eigen::Array2i texel = (uv / map.texel).array().floor().cast<int>();
  const BallSearch search(map, radius, BallSearch::reach(radius, height, highest), texel,
                          texel + 1);
  Eigen::Vector2d contact = uv;
  return search.height(uv, contact);
}

SurfaceMap traced_map(const SurfaceMap& map, double radius) {
  check_radius(radius);
  if (!map.relief()) return traced_map(integrated_relief(map), radius);
  if (radius == 0) return map;
  const int width = map.width, height = map.height;
  const auto [lowest, highest] = std::minmax_element(map.heights.begin(), map.heights.end());
  const BallSearch search(map, radius, BallSearch::reach(radius, *lowest, *highest), {0, 0},
                          {width, height});
  std::vector<double> heights(map.heights.size());
  for (int j = 0; j < height; ++j) {
    Eigen::Vector2d contact(map.texel / 2, (j + 0.5) * map.texel);
    for (int i = 0; i < width; ++i) {
      const Eigen::Vector2d uv((i + 0.5) * map.texel, (j + 0.5) * map.texel);
      // Where the ball touched a texel before is where it may well touch now.
      heights[std::size_t(j) * std::size_t(width) + std::size_t(i)] = search.height(uv, contact);
    }
    to_control_points(
        std::span(heights).subspan(std::size_t(j) * std::size_t(width), std::size_t(width)),
        map.repeats);
  }
  std::vector<double> column(static_cast<std::size_t>(height));
  SurfaceMap traced = map;
  for (std::size_t i = 0; i < static_cast<std::size_t>(width); ++i) {
    for (std::size_t j = 0; j < column.size(); ++j) {
      column[j] = heights[j * static_cast<std::size_t>(width) + i];
    }
    to_control_points(column, map.repeats);
    for (std::size_t j = 0; j < column.size(); ++j) {
      traced.heights[j * static_cast<std::size_t>(width) + i] =
          static_cast<float>(std::min(column[j], 0.0));
    }
  }
  return traced;
}

}  // namespace carillon::render::maps
