#include "synth/room/wall_materials.hpp"

#include <fmt/format.h>

#include <string_view>

#include "core/config.hpp"
#include "core/did_you_mean.hpp"
#include "core/error.hpp"

namespace carillon::synth::room {

/// The text of share/carillon/walls.yaml; see carillon_embed() in synth/CMakeLists.txt.
extern const std::string_view walls_yaml;

namespace {

std::vector<WallMaterial> read_wall_materials() {
  core::ConfigNode root =
      core::ConfigNode::parse(std::string(walls_yaml), "share/carillon/walls.yaml");
  std::vector<WallMaterial> walls;
  for (const std::string& name : root.keys()) {
    core::ConfigNode node = root.child(name);
    WallMaterial wall;
    wall.name = name;
    wall.meaning = node.text("meaning");
    const auto values = node.quantities("absorption", core::Dimension::none);
    wall.absorption = core::at_key(node, "absorption", [&] { return octaves_of(values); });
    wall.source = node.text("citation");
    node.finish();
    walls.push_back(std::move(wall));
  }
  root.finish();
  return walls;
}

}  // namespace

const std::vector<WallMaterial>& wall_materials() {
  static const std::vector<WallMaterial> walls = read_wall_materials();
  return walls;
}

const WallMaterial& find_wall_material(const std::string& name) {
  std::vector<std::string> names;
  for (const WallMaterial& wall : wall_materials()) {
    if (wall.name == name) return wall;
    names.push_back(wall.name);
  }
  throw core::InputError(
      fmt::format("unknown wall \"{}\"{}", name, core::did_you_mean(name, names)),
      "carillon list walls [WORD ...] names them; or give the absorption, 0 to 1");
}

}  // namespace carillon::synth::room
