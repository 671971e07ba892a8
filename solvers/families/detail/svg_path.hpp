#pragma once

#include <array>
#include <string>
#include <vector>

namespace carillon::solvers::families {

/// A cubic Bezier curve, or a straight line between its first and last points.
struct PathCurve {
  std::array<std::array<double, 2>, 4> points;
  bool straight = false;
};

/// Outline of an SVG path's data: M L H V C S Q T A Z, absolute and relative; quadratics and
/// elliptical arcs become cubics (an arc in parts of at most 45 degrees: right to 3e-6 of the
/// radius). The outline is closed whether or not the data say so.
/// @throws InputError  names the character where the data go wrong, or a second outline
std::vector<PathCurve> parse_svg_path(const std::string& data);

}  // namespace carillon::solvers::families
