// Pictures of the generated maps, with balls that rest on them: docs/textures.png.
// usage: carillon-texture-pictures FILE.png
#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "render/maps/generated_maps.hpp"
#include "render/scene_frame.hpp"
#include "tests/bench/ball_mesh.hpp"

namespace carillon::bench {
namespace {

using render::Scene;
using render::maps::SurfaceMap;

struct Tile {
  const char* map;
  bool as_normals;
  Vec3 color, deep;
  double view;    ///< part of the map that the picture shows
  double radius;  ///< of the balls, as part of that
};

core::Image picture_of(const Tile& tile, int width, int height) {
  const SurfaceMap relief = render::maps::generate_map(tile.map, {}, 512, 1);
  const double across = tile.view * relief.size().x();
  const Eigen::Vector2d middle = 0.5 * relief.size();
  const double radius = tile.radius * across;
  Scene scene;
  scene.camera = {.width = width,
                  .height = height,
                  .eye = {middle.x() - 0.35 * across, middle.y() - 1.1 * across, 0.75 * across},
                  .target = {middle.x(), middle.y(), 0},
                  .field_of_view = 0.5};
  scene.light = {-0.8, 0.25, 0.55};
  // Whole repetitions reach from the ground's corner to the middle of the picture.
  const double reach = std::ceil(5 * across / relief.size().x()) * relief.size().x();
  scene.ground = render::SceneGround{{0, 0, 0}, reach, {tile.color, 0.85, 0}, {}, tile.deep};
  scene.ground->map = std::make_shared<const SurfaceMap>(
      tile.as_normals ? render::maps::normal_map_of(relief) : relief);
  std::vector<render::ScenePose> poses;
  const char* materials[] = {"steel", "porcelain", "glass"};
  for (int i = 0; i < 3; ++i) {
    scene.bodies.push_back({ball(radius, 64), render::appearance_of(materials[i]), {}, {}});
    const Eigen::Vector2d place = middle + across * Eigen::Vector2d(0.2 * (i - 1), 0.13 * (1 - i));
    const double low = tile.as_normals ? 0
                                       : render::maps::traced_height(
                                             relief, place + Eigen::Vector2d(reach, reach), radius);
    poses.push_back({.origin = {place.x(), place.y(), low + radius}});
  }
  return render::SceneRenderer(scene).draw(poses).color;
}

void run(const char* file) {
  constexpr int width = 320, height = 240;
  const Tile tiles[] = {{"brick", false, {0.42, 0.16, 0.10}, {0.42, 0.40, 0.37}, 0.7, 0.05},
                        {"tiles", false, {0.55, 0.57, 0.55}, {0.16, 0.15, 0.14}, 0.9, 0.06},
                        {"grooves", false, {0.45, 0.30, 0.16}, {0.45, 0.30, 0.16}, 0.7, 0.05},
                        {"pebbles", false, {0.40, 0.38, 0.35}, {0.12, 0.09, 0.07}, 0.8, 0.05},
                        {"noise", false, {0.50, 0.42, 0.33}, {0.50, 0.42, 0.33}, 0.8, 0.05},
                        {"brick", true, {0.42, 0.16, 0.10}, {0.42, 0.16, 0.10}, 0.7, 0.05}};
  core::Image sheet{3 * width, 2 * height, 3, {}};
  sheet.pixels.resize(std::size_t(3 * 3 * width) * std::size_t(2 * height));
  for (int k = 0; k < 6; ++k) {
    const core::Image picture = picture_of(tiles[k], width, height);
    for (int row = 0; row < height; ++row) {
      std::copy_n(picture.pixels.begin() + 3 * row * width, 3 * width,
                  sheet.pixels.begin() + 3 * ((k / 3 * height + row) * 3 * width + k % 3 * width));
    }
  }
  write_png(file, sheet);
}

}  // namespace
}  // namespace carillon::bench

int main(int argc, char** argv) {
  if (argc != 2) {
    fmt::print(stderr, "usage: {} FILE.png\n", argv[0]);
    return 2;
  }
  carillon::bench::run(argv[1]);
  return EXIT_SUCCESS;
}
