#include "solvers/families/families.hpp"

#include <fmt/format.h>

#include <cmath>
#include <utility>

#include "core/error.hpp"
#include "core/units.hpp"
#include "solvers/families/family.hpp"

namespace carillon::solvers::families {
namespace {

std::vector<Family> register_families() {
  std::vector<Family> all;
  const auto add = [&all](std::vector<Family> some) {
    for (auto& family : some) all.push_back(std::move(family));
  };
  add(box_families());     // bar, block, tile
  add(round_families());   // disc, cylinder, tube, ring
  add(vessel_families());  // plate, bowl, cup, vase, bell
  add(hollow_families());  // box, can, bauble
  add(ball_families());    // sphere, pebble
  add({torus_family(), cone_family(), wrench_family(), turned_family()});
  return all;
}

}  // namespace

std::span<const Family> families() {
  static const std::vector<Family> all = register_families();
  return all;
}

const Family& find_family(const std::string& name) {
  std::vector<std::string> names;
  for (const Family& family : families()) {
    if (family.name == name) return family;
    names.push_back(family.name);
  }
  const std::string nearest = core::nearest_name(name, names);
  throw core::InputError(fmt::format("there is no shape family \"{}\"", name),
                         nearest.empty() ? fmt::format("families: {}", fmt::join(names, ", "))
                                         : fmt::format("did you mean \"{}\"?", nearest));
}

mesh::ShapeExtent extent_of(const mesh::GeneratedShape& shape) {
  const Family& family = find_family(shape.family);
  if (family.extent) return family.extent(shape);
  const mesh::MeridianSize size = mesh::measure(family.meridian(shape));
  return {size.volume, 2 * size.volume / size.surface, size.longest_side()};
}

void scale_to(mesh::GeneratedShape& shape, double length) {
  const double factor = length / extent_of(shape).longest_side;
  for (auto& [name, value] : shape.parameters) value *= factor;
  for (auto& point : shape.profile) {
    for (double& value : point) value *= factor;
  }
}

mesh::ShapeExtent box_extent(const Vec3& sides, double fraction) {
  const double x = sides.x(), y = sides.y(), z = sides.z();
  return {fraction * x * y * z, x * y * z / (x * y + y * z + z * x), sides.maxCoeff()};
}

double parameter(const mesh::GeneratedShape& shape, const std::string& name) {
  return shape.parameters.at(name);
}

void check_parameters(const mesh::GeneratedShape& shape) {
  const Family& family = find_family(shape.family);
  std::vector<std::string> names;
  for (const auto& known : family.parameters) {
    names.push_back(known.name);
    const auto given = shape.parameters.find(known.name);
    if (given == shape.parameters.end())
      throw core::InputError(fmt::format("{}: {} is missing", family.name, known.name),
                             fmt::format("{}: {}", known.name, known.meaning));
    const bool positive = given->second > 0 || (known.may_be_zero && given->second == 0);
    if (!positive || !std::isfinite(given->second))
      throw core::InputError(fmt::format("{}: {} must be a positive length, not {} m", family.name,
                                         known.name, given->second));
  }
  for (const auto& [name, value] : shape.parameters) {
    bool known = false;
    for (const auto& candidate : names) known = known || candidate == name;
    if (known) continue;
    const std::string nearest = core::nearest_name(name, names);
    throw core::InputError(fmt::format("{}: there is no parameter \"{}\"", family.name, name),
                           nearest.empty() ? fmt::format("parameters: {}", fmt::join(names, ", "))
                                           : fmt::format("did you mean \"{}\"?", nearest));
  }
}

void require(bool holds, const mesh::GeneratedShape& shape, const std::string& rule) {
  if (!holds) throw core::InputError(fmt::format("{}: {}", shape.family, rule));
}

mesh::MeshResult finish(mesh::TetMesh mesh, std::int64_t straightened) {
  mesh::MeshResult result;
  result.quality = mesh::measure_quality(mesh);
  result.quality.straightened = straightened;
  result.mesh = std::move(mesh);
  return result;
}

}  // namespace carillon::solvers::families
