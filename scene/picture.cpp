#include "scene/picture.hpp"

#include <fmt/format.h>

#include <numbers>

#include "render/frame.hpp"

namespace carillon::scene {

void read_picture(core::ConfigNode& node, int& width, int& height, double& field_of_view) {
  width = static_cast<int>(node.integer("width", 1, render::max_picture_side, width));
  height = static_cast<int>(node.integer("height", 1, render::max_picture_side, height));
  field_of_view = node.quantity("field_of_view", core::Dimension::angle, field_of_view);
  if (!(field_of_view > 0 && field_of_view < std::numbers::pi)) {
    node.fail("field_of_view", "must lie between 0 and 180 deg");
  }
}

void require_pictures(const core::ConfigNode& node, const std::string& key,
                      const std::string& effect) {
  if (render::offscreen() != "none") return;
  node.fail(key, "this program was built without pictures",
            fmt::format("build with -DCARILLON_RENDER=ON, or leave them out: --set effects.{}=off",
                        effect));
}

}  // namespace carillon::scene
