#include "dataset/regenerate/strike_object.hpp"

#include <fmt/format.h>

#include <optional>
#include <utility>

#include "core/error.hpp"
#include "dataset/samples/shape_modes.hpp"

namespace carillon::dataset::regenerate {

namespace {

struct PlannedObject {
  const plan::Shape* shape;
  std::size_t variant;
};

/// The one whose name this is, or begins with it.
PlannedObject find_object(const plan::BuildPlan& plan, const std::string& name) {
  std::optional<PlannedObject> found;
  std::string first, other;
  for (const plan::Shape& shape : plan.shapes) {
    for (std::size_t v = 0; v < shape.variants.size(); ++v) {
      if (!shape.variants[v].sounds) continue;
      const std::string own = plan::object_name(shape.id, shape.variants[v]);
      if (own == name) return {&shape, v};
      if (!own.starts_with(name + "/")) continue;
      (found ? other : first) = own;
      found = PlannedObject{&shape, v};
    }
  }
  if (!found) {
    throw core::InputError(fmt::format("there is no object \"{}\"", name),
                           "as keys of samples begin: bowl-003/glass/1");
  }
  if (!other.empty()) {
    throw core::InputError(fmt::format("several objects begin with \"{}\"", name),
                           fmt::format("there are {} and {}", first, other));
  }
  return *found;
}

}  // namespace

scene::StruckSound strike_object(const stored::StoredDataset& dataset, const std::string& object,
                                 const scene::SingleStrike& strike) {
  const auto [shape, variant] = find_object(dataset.build.plan, object);
  const samples::ShapeModes modes(dataset.build.config, *shape, {dataset.folder, {}});
  scene::SolvedObject solved;
  solved.materials = modes.materials(variant);
  solved.modes = modes.of(variant);
  return scene::strike_once(dataset.build.config.scene, shape->id, solved, strike, {});
}

}  // namespace carillon::dataset::regenerate
