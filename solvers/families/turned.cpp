#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "solvers/families/families.hpp"
#include "solvers/families/family.hpp"
#include "solvers/families/polygon_meridian.hpp"

namespace carillon::solvers::families {
namespace {

void check_turned(const mesh::GeneratedShape& shape) {
  check_parameters(shape);
  checked_profile(shape.profile, "turned");
}

mesh::Meridian turned_meridian(const mesh::GeneratedShape& shape) {
  check_parameters(shape);
  return polygon_meridian(checked_profile(shape.profile, "turned"));
}

}  // namespace

Family turned_family() {
  return {"turned",
          "any closed profile (radius, height) turned about z: solid where it runs along the axis, "
          "a ring where it keeps off it",
          {},
          check_turned,
          nullptr,
          turned_meridian,
          nullptr,
          60};
}

std::string bore_warning(const mesh::GeneratedShape& shape) {
  constexpr double usual_bore = 0.05;
  if (shape.family != "turned" || shape.profile.empty()) return "";
  double inner = std::numeric_limits<double>::infinity(), outer = 0;
  for (const auto& point : shape.profile) {
    inner = std::min(inner, point[0]);
    outer = std::max(outer, point[0]);
  }
  if (!(inner > 0) || inner > usual_bore * outer) return "";
  return fmt::format(
      "the profile keeps {:.3g} mm away from its axis, which leaves a bore of {:.3g} mm through "
      "the body; if it is meant to be solid, let the outline run along the axis",
      1e3 * inner, 2e3 * inner);
}

}  // namespace carillon::solvers::families
