// Shells of revolution with a closed bottom. The middle of the wall follows the profiles below;
// its underside stands on z = 0 (a bell's mouth does), and radii are outer radii where the wall
// is upright.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "solvers/families/detail/shell.hpp"

namespace carillon::solvers::families {
namespace {

constexpr double quarter_turn = std::numbers::pi / 2;

Shell of_constant_wall(Profile profile, double wall) {
  return {std::move(profile), [wall](double) { return wall; }, wall, wall};
}

/// Flat well, a shoulder over a third of the way to the rim that gains three quarters of the
/// height, and a rim that rises gently.
Shell plate(const mesh::GeneratedShape& shape) {
  const double wall = parameter(shape, "wall"), well = parameter(shape, "well_radius");
  const double radius = parameter(shape, "radius") - wall / 2;
  const double rise = parameter(shape, "height") - wall, bottom = wall / 2;
  Profile profile;
  profile.rounded({{0, bottom},
                   {well, bottom},
                   {well + 0.35 * (radius - well), bottom + 0.75 * rise},
                   {radius, bottom + rise}},
                  0.4);
  return of_constant_wall(std::move(profile), wall);
}

void check_plate(const mesh::GeneratedShape& shape) {
  check_parameters(shape);
  require(parameter(shape, "well_radius") + parameter(shape, "wall") < parameter(shape, "radius"),
          shape, "well_radius must be smaller than radius by more than the wall");
  require(parameter(shape, "height") >= 1.5 * parameter(shape, "wall"), shape,
          "height must be at least one and a half walls");
  check_shell(shape, plate(shape));
}

/// Flat foot, then a quarter of an ellipse that is upright at the rim.
Shell bowl(const mesh::GeneratedShape& shape) {
  const double wall = parameter(shape, "wall"), base = parameter(shape, "base_radius");
  const double radius = parameter(shape, "radius") - wall / 2;
  const double rise = parameter(shape, "height") - wall / 2, bottom = wall / 2;
  Profile profile;
  profile.line({0, bottom}, {base, bottom});
  profile.arc({base, bottom + rise}, {radius - base, rise}, -quarter_turn, 0);
  return of_constant_wall(std::move(profile), wall);
}

void check_bowl(const mesh::GeneratedShape& shape) {
  check_parameters(shape);
  require(parameter(shape, "base_radius") + parameter(shape, "wall") < parameter(shape, "radius"),
          shape, "base_radius must be smaller than radius by more than the wall");
  require(parameter(shape, "height") > parameter(shape, "wall"), shape,
          "height must exceed the wall");
  check_shell(shape, bowl(shape));
}

/// Flat bottom, rounded edge, straight wall to the rim.
Shell cup(const mesh::GeneratedShape& shape) {
  const double wall = parameter(shape, "wall");
  const double bottom_radius = parameter(shape, "bottom_radius") - wall / 2;
  const double radius = parameter(shape, "radius") - wall / 2;
  Profile profile;
  profile.rounded({{0, wall / 2}, {bottom_radius, wall / 2}, {radius, parameter(shape, "height")}},
                  std::min(0.35, 0.6 * parameter(shape, "height") / bottom_radius));
  return of_constant_wall(std::move(profile), wall);
}

void check_cup(const mesh::GeneratedShape& shape) {
  check_parameters(shape);
  const double wall = parameter(shape, "wall");
  require(2 * wall < parameter(shape, "bottom_radius"), shape,
          "the wall must be thinner than half the bottom_radius");
  require(wall < parameter(shape, "radius"), shape, "the wall must be thinner than the radius");
  require(2 * wall < parameter(shape, "height"), shape,
          "the wall must be thinner than half the height");
  check_shell(shape, cup(shape));
}

/// Flat bottom with a rounded edge, then radii that swing from foot to belly (at 0.4 of the
/// height), to neck (at 0.78) and to lip, upright at each.
Shell vase(const mesh::GeneratedShape& shape) {
  const double wall = parameter(shape, "wall"), height = parameter(shape, "height");
  const double bottom = wall / 2;
  const double foot = parameter(shape, "foot_radius") - bottom;
  const double belly = parameter(shape, "belly_radius") - bottom;
  const double neck = parameter(shape, "neck_radius") - bottom;
  const double lip = parameter(shape, "lip_radius") - bottom;
  const double edge = std::min(0.35 * foot, 0.2 * height);
  Profile profile;
  profile.line({0, bottom}, {foot - edge, bottom});
  profile.arc({foot - edge, bottom + edge}, {edge, edge}, -quarter_turn, 0);
  profile.swing({foot, bottom + edge}, {belly, 0.4 * height});
  profile.swing({belly, 0.4 * height}, {neck, 0.78 * height});
  profile.swing({neck, 0.78 * height}, {lip, height});
  return of_constant_wall(std::move(profile), wall);
}

void check_vase(const mesh::GeneratedShape& shape) {
  check_parameters(shape);
  const double wall = parameter(shape, "wall");
  for (const char* name : {"foot_radius", "belly_radius", "neck_radius", "lip_radius"})
    require(parameter(shape, name) > 1.5 * wall, shape,
            std::string(name) + " must exceed one and a half walls");
  require(parameter(shape, "height") > 6 * wall, shape, "height must exceed six walls");
  check_shell(shape, vase(shape));
}

/// Flat crown, rounded shoulder, and a waist whose radius grows with the cube of the way down to
/// the mouth; towards the mouth (the last 40 % of the profile) the wall swells to the sound bow.
Shell bell(const mesh::GeneratedShape& shape) {
  const double wall = parameter(shape, "wall"), lip = parameter(shape, "lip_wall");
  const double top = parameter(shape, "height") - wall / 2;
  const double shoulder = parameter(shape, "shoulder_radius") - wall / 2;
  const double mouth = parameter(shape, "radius") - lip / 2;
  const double edge = std::min(0.4 * shoulder, 0.3 * top);
  Profile profile;
  profile.line({0, top}, {shoulder - edge, top});
  profile.arc({shoulder - edge, top - edge}, {edge, edge}, quarter_turn, 0);
  profile.swing({shoulder, top - edge}, {mouth, 0}, true);
  const double length = profile.length();
  const auto thickness = [=](double s) {
    const double u = std::clamp((s / length - 0.6) / 0.4, 0.0, 1.0);
    return wall + (lip - wall) * u * u * (3 - 2 * u);
  };
  return {std::move(profile), thickness, std::min(wall, lip), std::max(wall, lip), {0.6 * length}};
}

void check_bell(const mesh::GeneratedShape& shape) {
  check_parameters(shape);
  const double wall = std::max(parameter(shape, "wall"), parameter(shape, "lip_wall"));
  require(parameter(shape, "shoulder_radius") > 2 * wall, shape,
          "shoulder_radius must exceed two walls");
  require(parameter(shape, "radius") >= parameter(shape, "shoulder_radius"), shape,
          "radius (of the mouth) must not be smaller than shoulder_radius");
  require(parameter(shape, "height") > 4 * wall, shape, "height must exceed four walls");
  check_shell(shape, bell(shape));
}

template <Shell (*make)(const mesh::GeneratedShape&), void (*check)(const mesh::GeneratedShape&)>
mesh::MeshResult mesh(const mesh::GeneratedShape& shape, const mesh::MeshOptions& options) {
  check(shape);
  return mesh_shell(make(shape), options);
}

template <Shell (*make)(const mesh::GeneratedShape&), void (*check)(const mesh::GeneratedShape&)>
mesh::Meridian meridian(const mesh::GeneratedShape& shape) {
  check(shape);
  return shell_meridian(make(shape));
}

}  // namespace

std::vector<Family> vessel_families() {
  return {{"plate",
           "dinner plate: flat well, shoulder and raised rim",
           {{"radius", 0.09, 0.14, "outer radius of the rim [m]"},
            {"well_radius", 0.045, 0.065, "radius of the flat middle [m]"},
            {"height", 0.016, 0.032, "from the underside to the top of the rim [m]"},
            {"wall", 0.003, 0.006, "thickness [m]"}},
           check_plate,
           mesh<plate, check_plate>,
           meridian<plate, check_plate>,
           nullptr,
           300},
          {"bowl",
           "bowl: flat foot and an elliptical wall, upright at the rim",
           {{"radius", 0.06, 0.12, "outer radius of the rim [m]"},
            {"base_radius", 0.02, 0.035, "radius of the flat foot [m]"},
            {"height", 0.04, 0.08, "from the underside to the rim [m]"},
            {"wall", 0.002, 0.005, "thickness [m]"}},
           check_bowl,
           mesh<bowl, check_bowl>,
           meridian<bowl, check_bowl>,
           nullptr,
           200},
          {"cup",
           "cup or drinking glass: flat bottom and a straight wall",
           {{"radius", 0.033, 0.05, "outer radius of the rim [m]"},
            {"bottom_radius", 0.025, 0.035, "outer radius at the bottom [m]"},
            {"height", 0.07, 0.14, "from the underside to the rim [m]"},
            {"wall", 0.002, 0.004, "thickness [m]"}},
           check_cup,
           mesh<cup, check_cup>,
           meridian<cup, check_cup>,
           nullptr,
           150},
          {"vase",
           "vase: foot, belly, neck and lip joined by smooth curves, closed at the bottom",
           {{"foot_radius", 0.03, 0.045, "outer radius above the bottom [m]"},
            {"belly_radius", 0.05, 0.08, "outer radius at 0.4 of the height [m]"},
            {"neck_radius", 0.02, 0.03, "outer radius at 0.78 of the height [m]"},
            {"lip_radius", 0.03, 0.04, "outer radius at the rim [m]"},
            {"height", 0.16, 0.3, "from the underside to the rim [m]"},
            {"wall", 0.003, 0.006, "thickness [m]"}},
           check_vase,
           mesh<vase, check_vase>,
           meridian<vase, check_vase>,
           nullptr,
           150},
          {"bell",
           "bell: closed crown, waist that widens to the mouth, thicker at the sound bow",
           {{"radius", 0.045, 0.08, "outer radius of the mouth [m]"},
            {"shoulder_radius", 0.025, 0.04, "outer radius below the crown [m]"},
            {"height", 0.06, 0.14, "from the mouth to the top of the crown [m]"},
            {"wall", 0.003, 0.005, "thickness of crown and waist [m]"},
            {"lip_wall", 0.005, 0.009, "thickness at the mouth [m]"}},
           check_bell,
           mesh<bell, check_bell>,
           meridian<bell, check_bell>,
           nullptr,
           150,
           "bell_bronze"}};
}

}  // namespace carillon::solvers::families
