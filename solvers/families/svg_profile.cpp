#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "core/error.hpp"
#include "core/files.hpp"
#include "core/units.hpp"
#include "core/vectors.hpp"
#include "solvers/families/detail/svg_outlines.hpp"
#include "solvers/families/families.hpp"
#include "solvers/families/outline.hpp"

namespace carillon::solvers::families {
namespace {

std::array<double, 2> point_of(const PathCurve& curve, double t) {
  const double s = 1 - t;
  const std::array<double, 4> b{s * s * s, 3 * s * s * t, 3 * s * t * t, t * t * t};
  std::array<double, 2> p{0, 0};
  for (std::size_t i = 0; i < 4; ++i)
    for (std::size_t k = 0; k < 2; ++k) p[k] += b[i] * curve.points[i][k];
  return p;
}

/// Points of an outline, each of which is held against all others for crossings.
constexpr double max_points = 1e4;

/// Equal steps in t whose chords stay within `tolerance`: |B''| / (8 n^2) bounds their distance.
/// Without end for a curve that reaches without end to the side.
double steps_of(const PathCurve& curve, double tolerance) {
  if (curve.straight) return 1;
  double second = 0;
  for (std::size_t i = 0; i < 2; ++i)
    second = std::max(
        second,
        6 * std::hypot(curve.points[i][0] - 2 * curve.points[i + 1][0] + curve.points[i + 2][0],
                       curve.points[i][1] - 2 * curve.points[i + 1][1] + curve.points[i + 2][1]));
  return std::max(1.0, std::ceil(std::sqrt(second / (8 * tolerance))));
}

ProfilePolygon flattened(const SvgOutline& outline) {
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (const auto& curve : outline.curves)
    for (int k = 0; k <= 64; ++k) {
      const double y = point_of(curve, k / 64.0)[1];
      low = std::min(low, y);
      high = std::max(high, y);
    }
  ProfilePolygon polygon;
  for (const auto& curve : outline.curves) {
    const double steps = steps_of(curve, 1e-4 * (high - low));
    if (!(static_cast<double>(polygon.size()) + steps <= max_points))
      throw core::InputError(
          outline.name +
              ": an outline that is true to a ten thousandth of its height has more than 10000 "
              "points",
          "draw the half section alone, as one outline with few curves, none far wider than it is "
          "high");
    for (int k = 0; k < static_cast<int>(steps); ++k) {
      const auto p = point_of(curve, k / steps);
      polygon.push_back({p[0], -p[1]});
    }
  }
  return polygon;
}

Vec2 size_of(const ProfilePolygon& polygon) {
  Eigen::AlignedBox2d box;
  for (const auto& p : polygon) box.extend(Vec2(p[0], p[1]));
  return box.isEmpty() ? Vec2(0, 0) : Vec2(box.sizes());
}

/// Whether all points lie on one line. One that crosses itself can have no area and is none.
bool is_straight(const ProfilePolygon& polygon) {
  if (polygon.empty()) return true;
  const auto from_first = [&polygon](std::size_t i) {
    return Vec2(polygon[i][0] - polygon[0][0], polygon[i][1] - polygon[0][1]);
  };
  Vec2 farthest(0, 0);
  for (std::size_t i = 0; i < polygon.size(); ++i)
    if (from_first(i).squaredNorm() > farthest.squaredNorm()) farthest = from_first(i);
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Vec2 p = from_first(i);
    if (std::abs(farthest.x() * p.y() - farthest.y() * p.x()) > 1e-9 * farthest.squaredNorm())
      return false;
  }
  return true;
}

/// The one outline of a drawing that encloses an area, or the one that is named.
ProfilePolygon chosen_outline(const SvgDrawing& drawing, const std::string& id) {
  std::vector<ProfilePolygon> solid;
  std::vector<std::string> names, ids;
  for (const SvgOutline& outline : drawing.outlines) {
    if (!outline.id.empty()) ids.push_back(outline.id);
    if (!id.empty() && outline.id != id) continue;
    ProfilePolygon polygon = flattened(outline);
    if (is_straight(polygon)) continue;
    solid.push_back(std::move(polygon));
    names.push_back(outline.name);
  }
  if (solid.size() == 1) return std::move(solid.front());
  if (!solid.empty())
    throw core::InputError(
        fmt::format("it has {} outlines: {}", solid.size(), fmt::join(names, ", ")),
        "a profile is one of them: name it as profile_id, or leave the others out");
  if (!id.empty())
    throw core::InputError(
        fmt::format("it has no outline \"{}\" with an area", id),
        ids.empty() ? std::string() : fmt::format("it has {}", fmt::join(ids, ", ")));
  throw core::InputError("no outline in it encloses an area",
                         "draw the half section as one closed outline, walls included");
}

/// Radii from where the axis is, on whichever side of it the outline lies.
void put_on_axis(const std::string& axis, ProfilePolygon& polygon) {
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (const auto& p : polygon) {
    low = std::min(low, p[0]);
    high = std::max(high, p[0]);
  }
  double at = 0;
  if (axis.empty()) {
    const double near = 1e-6 * std::max(std::abs(low), std::abs(high));
    if (low > near || high < -near)
      throw core::InputError(
          fmt::format("the outline reaches from x = {:.6g} to {:.6g}, and its axis is not given",
                      low, high),
          "give it as profile_axis (left or right where that side lies on it, x=0 where a bore is "
          "meant)");
  } else if (axis == "left") {
    at = low;
  } else if (axis == "right") {
    at = high;
  } else if (axis.rfind("x=", 0) == 0) {
    at = core::parse_quantity(axis.substr(2), core::Dimension::none);
  } else {
    throw core::InputError(fmt::format("\"{}\" is no axis", axis),
                           "left, right, or x=NUMBER in the drawing's coordinates");
  }
  const double slack = 1e-6 * (high - low);
  const bool is_left = high <= at + slack && low < at - slack;
  if (!is_left && low < at - slack)
    throw core::InputError(
        fmt::format("the outline reaches from {:.6g} to {:.6g} across the axis at x = {:.6g}", low,
                    high, at),
        "draw half of the section, or give the axis as profile_axis, such as x=12");
  for (auto& p : polygon) p[0] = is_left ? at - p[0] : p[0] - at;
}

}  // namespace

std::vector<std::array<double, 2>> profile_from_svg(const std::string& path,
                                                    const SvgProfileOptions& options) {
  if (!(options.height >= 0) || !std::isfinite(options.height))
    throw core::InputError(
        fmt::format("the height of a profile must be positive, not {}", options.height));
  const std::string text = core::read_file(path);
  try {
    const SvgDrawing drawing = read_svg(text);
    ProfilePolygon polygon = chosen_outline(drawing, options.id);
    put_on_axis(options.axis, polygon);
    const double tall = size_of(polygon).y();
    if (!(tall > 0)) throw core::InputError("the outline has no height");
    double scale = drawing.unit;
    if (options.height > 0) scale = options.height / tall;
    if (!(scale > 0))
      throw core::InputError("the drawing has no size on paper (width and height in mm, cm or in)",
                             "say how long the object is, as in length: 20 cm");
    double bottom = std::numeric_limits<double>::infinity();
    for (const auto& p : polygon) bottom = std::min(bottom, p[1]);
    for (auto& p : polygon) p = {p[0] * scale, (p[1] - bottom) * scale};
    return checked_profile(polygon, path);
  } catch (const core::InputError& error) {
    if (error.message().rfind(path, 0) == 0) throw;
    throw core::InputError(path + ": " + error.message(), error.hint());
  }
}

}  // namespace carillon::solvers::families
