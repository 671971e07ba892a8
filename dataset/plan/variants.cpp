#include "dataset/plan/variants.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "core/random.hpp"
#include "dataset/plan/plan.hpp"

namespace carillon::dataset::plan {

std::string size_name(const Variant& variant) {
  if (variant.tune == 0) return fmt::format("{}", variant.size);
  const std::string pitch = fmt::format("{}Hz", variant.tune);
  return variant.tune_mode == 1 ? pitch : fmt::format("{}-mode-{}", pitch, variant.tune_mode);
}

std::string object_name(const std::string& shape, const Variant& variant) {
  return fmt::format("{}/{}/{}", shape, variant.material, size_name(variant));
}

namespace {

/// An instance's own size, drawn within three deviations; six digits, for its key. Not one of
/// those that are given: equal variants would be the same samples twice.
double draw_size(const configuration::BuildConfig& config,
                 const configuration::ObjectSource& source, const std::string& id) {
  core::RandomStream random(config.seed, core::stable_hash(id), "shape.size");
  const std::vector<double>& given = source.sizes;
  for (;;) {
    const double away = random.normal();
    if (std::abs(away) > 3) continue;
    const double drawn = source.drawn_size->mean + away * source.drawn_size->deviation;
    const double size = std::stod(fmt::format("{:.6g}", drawn));
    if (std::find(given.begin(), given.end(), size) == given.end()) return size;
  }
}

/// Materials that a shape has of those that its entry names.
std::vector<std::string> draw_materials(const configuration::BuildConfig& config,
                                        const configuration::ObjectSource& source,
                                        const std::string& id) {
  const auto wanted = static_cast<std::size_t>(config.sounding.materials_per_group);
  if (wanted == 0) return source.object.materials;
  std::map<std::string, std::vector<std::string>> by_group;
  for (const std::string& name : source.object.materials)
    by_group[scene::object_material(source.object, name, config.own_materials).group].push_back(
        name);
  core::RandomStream random(config.seed, core::stable_hash(id), "shape.materials");
  std::vector<std::string> drawn;
  for (auto& [group, names] : by_group) {
    for (std::size_t k = 0; k < wanted && !names.empty(); ++k) {
      const auto one = names.begin() + static_cast<std::ptrdiff_t>(random.index(names.size()));
      drawn.push_back(*one);
      names.erase(one);
    }
  }
  return drawn;
}

}  // namespace

std::vector<Variant> make_variants(const configuration::BuildConfig& config,
                                   const configuration::ObjectSource& source,
                                   const std::string& id) {
  std::vector<std::string> materials = draw_materials(config, source, id);
  if (!source.object.groups.empty()) {
    std::vector<std::string> parts;
    for (const auto& [group, name] : source.object.groups)
      parts.push_back(fmt::format("{}={}", group, name));
    materials = {fmt::format("{}", fmt::join(parts, ","))};
  }
  std::vector<double> sizes = source.sizes;
  if (source.drawn_size) sizes.push_back(draw_size(config, source, id));
  const auto chosen = [](configuration::Which which, std::size_t i, std::size_t count) {
    return which == configuration::Which::all ||
           i == (which == configuration::Which::first ? 0 : count - 1);
  };
  const bool tuned = !source.tune.empty();
  const std::size_t count = tuned ? source.tune.size() : sizes.size();
  std::vector<Variant> variants;
  for (std::size_t m = 0; m < materials.size(); ++m) {
    for (std::size_t s = 0; s < count; ++s) {
      variants.push_back({materials[m], tuned ? 1 : sizes[s],
                          chosen(config.sounding.materials, m, materials.size()) &&
                              chosen(config.sounding.sizes, s, count),
                          tuned ? source.tune[s] : 0, source.tune_mode});
    }
  }
  return variants;
}

scene::RegionMaterials region_materials(const configuration::BuildConfig& config,
                                        const Shape& shape, const Variant& variant) {
  scene::RegionMaterials materials = scene::region_materials(
      config.objects[shape.source].object, variant.material, config.own_materials);
  if (config.spread == configuration::MaterialSpread{}) return materials;
  for (auto& [region, material] : materials) {
    core::RandomStream random(config.seed,
                              core::stable_hash(fmt::format("{}/{}", shape.id, material.name)),
                              "material.spread");
    const auto factor = [&](const core::Range& range) {
      return random.log_uniform(range.low, range.high);
    };
    material.elastic.youngs_modulus *= factor(config.spread.youngs_modulus);
    material.elastic.density *= factor(config.spread.density);
    material.damping =
        synth::damping::scaled(std::move(material.damping), factor(config.spread.damping));
  }
  return materials;
}

std::vector<synth::material::Material> variant_materials(const configuration::BuildConfig& config,
                                                         const Shape& shape, const Variant& variant,
                                                         const std::vector<std::string>& regions) {
  return scene::assign_materials(region_materials(config, shape, variant), regions);
}

}  // namespace carillon::dataset::plan
