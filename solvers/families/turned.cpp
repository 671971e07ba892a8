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

}  // namespace carillon::solvers::families
