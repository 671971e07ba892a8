#include "render/looks/appearance.hpp"

#include <fmt/format.h>

#include <array>
#include <map>
#include <nlohmann/json.hpp>
#include <string_view>

#include "core/error.hpp"

namespace carillon::render::looks {

/// The text of share/carillon/appearances.yaml; see carillon_embed() in render/CMakeLists.txt.
extern const std::string_view appearances_yaml;

namespace {

constexpr std::array grains = {Grain::none, Grain::wood, Grain::speckled, Grain::veined,
                               Grain::brushed};

using Looks = std::map<std::string, Appearance, std::less<>>;

struct Table {
  Looks names, groups;
};

Looks read_looks(core::ConfigNode node) {
  Looks looks;
  for (const std::string& name : node.keys()) {
    looks[name] = read_appearance(node.child(name), {});
  }
  return looks;
}

const Table& table() {
  static const Table read = [] {
    core::ConfigNode root =
        core::ConfigNode::parse(std::string(appearances_yaml), "share/carillon/appearances.yaml");
    Table looks{read_looks(root.child("names")), read_looks(root.child("groups"))};
    root.finish();
    return looks;
  }();
  return read;
}

/// Of the longest ending in whole words.
const Appearance* find_ending(const Looks& looks, std::string_view name) {
  while (true) {
    const auto found = looks.find(name);
    if (found != looks.end()) return &found->second;
    const std::size_t underscore = name.find('_');
    if (underscore == std::string_view::npos) return nullptr;
    name.remove_prefix(underscore + 1);
  }
}

double fraction(core::ConfigNode& node, const char* key, double fallback) {
  const double value = node.quantity(key, core::Dimension::none, fallback);
  if (!(value >= 0 && value <= 1)) {
    node.fail(key, fmt::format("must lie between 0 and 1, not {}", value));
  }
  return value;
}

Vec3 read_base_colour(core::ConfigNode& node, const Vec3& fallback) {
  const std::vector<double> values =
      node.quantities("base_colour", core::Dimension::none, 3,
                      std::vector<double>{fallback.x(), fallback.y(), fallback.z()});
  for (const double value : values) {
    if (value >= 0 && value <= 1) continue;
    node.fail("base_colour", fmt::format("must lie between 0 and 1, not {}", value),
              "red, green and blue as linear reflectance: (c / 255)^2.2 of an sRGB byte c");
  }
  return {values[0], values[1], values[2]};
}

}  // namespace

const char* name_of(Grain grain) {
  switch (grain) {
    case Grain::none:
      return "none";
    case Grain::wood:
      return "wood";
    case Grain::speckled:
      return "speckled";
    case Grain::veined:
      return "veined";
    case Grain::brushed:
      return "brushed";
  }
  return "";
}

void check(const Appearance& appearance) {
  for (const double value :
       {appearance.color[0], appearance.color[1], appearance.color[2], appearance.roughness,
        appearance.metallic, appearance.transmission, appearance.coat, appearance.grain_contrast}) {
    if (!(value >= 0 && value <= 1)) {
      throw core::InputError(fmt::format(
          "appearance: color, roughness, metallic, transmission, coat and grain_contrast "
          "lie between 0 and 1, not {}",
          value));
    }
  }
}

Appearance read_appearance(core::ConfigNode node, const Appearance& fallback) {
  Appearance appearance = fallback;
  appearance.color = read_base_colour(node, fallback.color);
  appearance.roughness = fraction(node, "roughness", fallback.roughness);
  appearance.metallic = fraction(node, "metallic", fallback.metallic);
  appearance.transmission = fraction(node, "transmission", fallback.transmission);
  appearance.coat = fraction(node, "coat", fallback.coat);
  std::vector<std::string> names;
  for (const Grain grain : grains) names.emplace_back(name_of(grain));
  const std::string chosen = node.choice("grain", names, name_of(fallback.grain));
  for (const Grain grain : grains) {
    if (chosen == name_of(grain)) appearance.grain = grain;
  }
  appearance.grain_contrast = fraction(node, "grain_contrast", fallback.grain_contrast);
  node.finish();
  return appearance;
}

nlohmann::json to_json(const Appearance& appearance) {
  return {{"base_colour", {appearance.color.x(), appearance.color.y(), appearance.color.z()}},
          {"roughness", appearance.roughness},
          {"metallic", appearance.metallic},
          {"transmission", appearance.transmission},
          {"coat", appearance.coat},
          {"grain", name_of(appearance.grain)},
          {"grain_contrast", appearance.grain_contrast}};
}

Appearance appearance_of(const std::string& material, const std::string& group) {
  // What a thing is comes last, and what tells its rows of a table apart after that.
  std::string_view rest = material;
  while (!rest.empty()) {
    if (const Appearance* look = find_ending(table().names, rest)) return *look;
    const std::size_t underscore = rest.rfind('_');
    rest = underscore == std::string_view::npos ? std::string_view() : rest.substr(0, underscore);
  }
  const auto found = table().groups.find(group);
  return found != table().groups.end() ? found->second : Appearance{};
}

}  // namespace carillon::render::looks
