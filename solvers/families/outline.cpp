#include "solvers/families/outline.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/error.hpp"

namespace carillon::solvers::families {
namespace {

using Point = std::array<double, 2>;

double turn(const Point& a, const Point& b, const Point& c) {
  return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
}

bool in_box(const Point& a, const Point& b, const Point& p) {
  return std::min(a[0], b[0]) <= p[0] && p[0] <= std::max(a[0], b[0]) &&
         std::min(a[1], b[1]) <= p[1] && p[1] <= std::max(a[1], b[1]);
}

/// Whether the closed segments ab and cd share a point.
bool segments_meet(const Point& a, const Point& b, const Point& c, const Point& d) {
  if (std::max(a[1], b[1]) < std::min(c[1], d[1]) || std::max(c[1], d[1]) < std::min(a[1], b[1]))
    return false;
  const double abc = turn(a, b, c), abd = turn(a, b, d), cda = turn(c, d, a), cdb = turn(c, d, b);
  if (((abc > 0) != (abd > 0)) && ((cda > 0) != (cdb > 0)) && abc != 0 && abd != 0 && cda != 0 &&
      cdb != 0)
    return true;
  return (abc == 0 && in_box(a, b, c)) || (abd == 0 && in_box(a, b, d)) ||
         (cda == 0 && in_box(c, d, a)) || (cdb == 0 && in_box(c, d, b));
}

void refuse_crossings(const ProfilePolygon& p, const std::string& what) {
  const std::size_t n = p.size();
  for (std::size_t i = 0; i < n; ++i) {
    const Point &a = p[i], &b = p[(i + 1) % n], &after = p[(i + 2) % n];
    // Neighbours share a point by right; they must not fold back on to each other.
    const bool folds = turn(a, b, after) == 0 &&
                       (b[0] - a[0]) * (after[0] - b[0]) + (b[1] - a[1]) * (after[1] - b[1]) < 0;
    bool meets = folds;
    for (std::size_t j = i + 2; j < n && !meets; ++j)
      if ((j + 1) % n != i) meets = segments_meet(a, b, p[j], p[(j + 1) % n]);
    if (meets)
      throw core::InputError(
          fmt::format("{}: the outline crosses or touches itself near radius {:.4g} m, height "
                      "{:.4g} m",
                      what, b[0], b[1]),
          "draw the outline of the solid section once around, walls included");
  }
}

}  // namespace

double polygon_area(const ProfilePolygon& polygon) {
  double twice = 0;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const auto &a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
    twice += a[0] * b[1] - a[1] * b[0];
  }
  return twice / 2;
}

ProfilePolygon checked_profile(const ProfilePolygon& polygon, const std::string& what) {
  double size = 0;
  for (const auto& p : polygon) {
    if (!std::isfinite(p[0]) || !std::isfinite(p[1]))
      throw core::InputError(what + ": a point of the profile is not finite");
    size = std::max(size, std::hypot(p[0] - polygon.front()[0], p[1] - polygon.front()[1]));
  }
  ProfilePolygon clean;
  for (Point p : polygon) {
    if (p[0] < -1e-6 * size)
      throw core::InputError(
          fmt::format("{}: the point ({:.4g}, {:.4g}) lies left of the axis", what, p[0], p[1]),
          "the axis is at radius 0; draw the half section at positive radii only");
    if (p[0] < 1e-6 * size) p[0] = 0;
    if (clean.empty() || std::hypot(p[0] - clean.back()[0], p[1] - clean.back()[1]) > 1e-9 * size)
      clean.push_back(p);
  }
  while (clean.size() > 1 && std::hypot(clean.front()[0] - clean.back()[0],
                                        clean.front()[1] - clean.back()[1]) <= 1e-9 * size)
    clean.pop_back();
  if (clean.size() < 3)
    throw core::InputError(fmt::format("{}: a profile needs at least three points, this one has {}",
                                       what, clean.size()));
  refuse_crossings(clean, what);
  const double enclosed = polygon_area(clean);
  if (std::abs(enclosed) < 1e-9 * size * size)
    throw core::InputError(what + ": the profile encloses no area");
  if (enclosed < 0) std::reverse(clean.begin(), clean.end());
  const std::size_t n = clean.size();
  for (std::size_t i = 0; i < n; ++i)
    if (clean[i][0] == 0 && clean[(i + 1) % n][0] > 0 && clean[(i + n - 1) % n][0] > 0)
      throw core::InputError(
          fmt::format("{}: the outline meets the axis in the single point at height {:.4g} m", what,
                      clean[i][1]),
          "let it run along the axis (a solid body) or keep off it (a ring)");
  return clean;
}

}  // namespace carillon::solvers::families
