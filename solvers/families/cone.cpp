#include "solvers/families/cone.hpp"

#include "solvers/families/family.hpp"
#include "solvers/families/polygon_meridian.hpp"

namespace carillon::solvers::families {

ProfilePolygon cone_profile(const mesh::GeneratedShape& shape) {
  check_parameters(shape);
  const double radius = parameter(shape, "radius"), top = parameter(shape, "top_radius");
  const double height = parameter(shape, "height");
  require(top < radius, shape, "top_radius must be smaller than radius");
  ProfilePolygon profile = {{0, 0}, {radius, 0}, {top, height}, {0, height}};
  if (top == 0) profile.pop_back();
  return checked_profile(profile, "cone");
}

namespace {

void check_cone(const mesh::GeneratedShape& shape) {
  cone_profile(shape);
}

mesh::Meridian cone_meridian(const mesh::GeneratedShape& shape) {
  return polygon_meridian(cone_profile(shape));
}

}  // namespace

Family cone_family() {
  return {"cone",
          "solid cone on its base, cut off at the top or (top_radius 0) with a tip",
          {{"radius", 0.03, 0.07, "of the base [m]"},
           {"top_radius", 0.005, 0.02, "0: a tip [m]", true},
           {"height", 0.05, 0.15, "along z [m]"}},
          check_cone,
          nullptr,
          cone_meridian};
}

}  // namespace carillon::solvers::families
