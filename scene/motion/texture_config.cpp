#include "scene/motion/texture_config.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <vector>

#include "render/maps/generated_maps.hpp"

namespace carillon::scene::motion {

using core::at_key;
using core::ConfigNode;
using core::Dimension;

namespace {

void read_generated(ConfigNode& node, TextureConfig& texture) {
  texture.map = node.text("map");
  const auto& maps = render::maps::generated_maps();
  const auto found = std::find_if(maps.begin(), maps.end(),
                                  [&](const auto& map) { return map.name == texture.map; });
  if (found == maps.end()) {
    std::vector<std::string> names;
    for (const auto& map : maps) names.push_back(map.name);
    const std::string near = core::nearest_name(texture.map, names);
    node.fail(
        "map", fmt::format("no generated map \"{}\"", texture.map),
        (near.empty() ? "" : fmt::format("did you mean \"{}\"? ", near)) +
            fmt::format("there are {}; an image is `image: FILE.png`", fmt::join(names, ", ")));
  }
  ConfigNode parameters = node.child("parameters");
  for (const auto& [name, value] : found->defaults) {
    // Lengths, but for counts and exponents, which are plain numbers: both are SI as they stand.
    texture.parameters[name] = parameters.quantity(name, Dimension::length, value);
  }
  texture.texels = static_cast<int>(node.integer("texels", 16, 4096, 512));
  at_key(node, "parameters", [&] {
    render::maps::generate_map(texture.map, texture.parameters, texture.texels, 0);
    return 0;
  });
}

void read_image(ConfigNode& node, TextureConfig& texture, const std::string& file_name) {
  texture.image = core::path_beside(file_name, node.text("image"));
  texture.options.width = node.quantity("image_width", Dimension::length);
  texture.options.depth = node.quantity("depth", Dimension::length, 0);
  texture.options.repeats = node.flag("periodic", true);
  texture.options.green_down = node.choice("green", {"up", "down"}, "up") == "down";
  at_key(node, "image", [&] {
    render::maps::read_map(texture.image, texture.options);
    return 0;
  });
}

}  // namespace

std::optional<TextureConfig> read_texture(ConfigNode& parent, const std::string& file_name,
                                          bool has_faces) {
  if (!parent.has("texture")) return {};
  ConfigNode node = parent.child("texture");
  TextureConfig texture;
  if (node.has("map") == node.has("image")) {
    node.fail("", "a texture is either a `map:` (generated) or an `image:` (a PNG)");
  }
  if (node.has("map")) {
    read_generated(node, texture);
  } else {
    read_image(node, texture, file_name);
  }
  texture.normals = node.choice("as", {"relief", "normals"}, "relief") == "normals";
  if (!has_faces) return texture;
  const std::string face = node.choice("face", {"+x", "-x", "+y", "-y", "+z", "-z"}, "+z");
  texture.towards_plus = face[0] == '+';
  texture.axis = face[1];
  return texture;
}

}  // namespace carillon::scene::motion
