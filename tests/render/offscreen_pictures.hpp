#pragma once

#include <memory>
#include <vector>

#include "render/maps/generated_maps.hpp"
#include "tests/render/scenes.hpp"

namespace carillon::render {

/// What is drawn alike whatever makes the context: smooth and flat faces, mirrors, shadows, colours
/// of vertices, and a relief among bodies on the ground.
inline std::vector<core::Image> offscreen_pictures() {
  std::vector<core::Image> pictures;
  for (const char* material : {"steel", "wood", "glass"}) {
    pictures.push_back(render_frame(bowl(0.08, 0.006), Camera{}, appearance_of(material)));
  }
  solvers::mesh::SurfaceMesh ball = sphere(0.05, 96);
  Appearance painted{.roughness = 0.5};
  for (const Vec3& vertex : ball.vertices) {
    painted.colours.emplace_back((vertex / 0.05 + Vec3::Ones()) / 2);
  }
  pictures.push_back(render_frame(ball, Camera{.width = 200, .height = 120}, painted));

  const maps::SurfaceMap bricks = maps::generate_map("brick", {}, 256, 0);
  Scene scene;
  scene.bodies = {slab(bricks, 0.02),
                  {.mesh = sphere(0.03, 64), .appearance = appearance_of("brass")}};
  scene.bodies[0].deep_color = Vec3(0.6, 0.58, 0.55);
  scene.ground = SceneGround{.middle = {0, 0, -0.02}, .reach = 2};
  scene.camera = {.width = 240, .height = 180, .eye = {0.4, -0.3, 0.3}, .target = {0.1, 0.08, 0}};
  const SceneFrame frame = draw(scene, {ScenePose{}, ScenePose{.origin = {0.1, 0.07, 0.03}}});
  pictures.push_back(frame.color);
  return pictures;
}

}  // namespace carillon::render
