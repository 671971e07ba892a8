#pragma once

#include <array>
#include <string>
#include <vector>

namespace carillon::solvers::families {

/// Closed polygon of a turned profile: (radius, height) [m].
using ProfilePolygon = std::vector<std::array<double, 2>>;

/// Enclosed area [m^2], positive when counter-clockwise (radius to the right, height up).
double polygon_area(const ProfilePolygon& polygon);

/// A polygon that can be turned about the axis: neighbouring equal points dropped, radii within
/// rounding of the axis set to zero, counter-clockwise.
/// @throws InputError  fewer than three points, not finite, left of the axis, without area, an
///                     outline that crosses or touches itself (names where), or one that meets
///                     the axis in a single point
ProfilePolygon checked_profile(const ProfilePolygon& polygon, const std::string& what);

}  // namespace carillon::solvers::families
