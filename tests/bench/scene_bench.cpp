// Time of a frame of a moving scene: a ball on a face with a normal map, a relief, and meshes of
// the same detail. Prints the table of docs/scenes.md. With a folder, writes a frame of each there.
#include <fmt/core.h>

#include <chrono>
#include <cstdlib>
#include <filesystem>

#include "render/scene_frame.hpp"
#include "solvers/textures/displaced_mesh.hpp"
#include "solvers/textures/generated_maps.hpp"
#include "tests/bench/ball_mesh.hpp"

namespace carillon::bench {
namespace {

using render::Scene;
using solvers::Vec3;

/// A plate 450 x 300 mm of bricks, drawn one way or another, and a ball on it.
Scene scene_of(const solvers::TexturedFace& face, const solvers::SurfaceMesh& mesh, bool textured) {
  Scene scene;
  scene.camera = {.width = 512,
                  .height = 384,
                  .eye = {0.225, -0.35, 0.3},
                  .target = {0.225, 0.14, 0},
                  .field_of_view = 0.8};
  scene.light = {-0.7, 0.2, 0.5};
  scene.bodies.push_back({mesh, {{0.42, 0.17, 0.11}, 0.8, 0}, {}, {{0.45, 0.43, 0.40}}});
  if (textured) scene.bodies[0].texture = face;
  scene.bodies.push_back({ball(0.015, 48), render::appearance_of("steel"), {}, {}});
  return scene;
}

double milliseconds(const std::string& name, const Scene& scene,
                    const std::filesystem::path& folder) {
  using Clock = std::chrono::steady_clock;
  const auto ms = [](Clock::duration time) {
    return std::chrono::duration<double, std::milli>(time).count();
  };
  const auto begin = Clock::now();
  render::SceneRenderer renderer(scene);
  const double set_up = ms(Clock::now() - begin);
  double least = 1e9;
  render::SceneFrame frame;
  for (int i = 0; i < 5; ++i) {
    const std::vector<render::ScenePose> poses = {
        {}, {Eigen::Quaterniond::Identity(), Vec3(0.15 + 0.01 * i, 0.15, 0.0135)}};
    const auto start = Clock::now();
    frame = renderer.draw(poses);
    least = std::min(least, ms(Clock::now() - start));
  }
  fmt::print("{:24} {:8.1f} ms to set up, {:8.1f} ms a frame\n", name, set_up, least);
  if (!folder.empty()) write_png(folder / (name + ".png"), frame.color);
  return least;
}

void run(const std::filesystem::path& folder) {
  solvers::TexturedFace face;
  face.map = solvers::generate_map("brick", {}, 512, 1);
  face.size = face.map.size();
  solvers::SurfaceMesh plate;
  for (int i = 0; i < 4; ++i) {
    plate.vertices.emplace_back(i % 2 * face.size.x(), i / 2 * face.size.y(), 0);
  }
  plate.triangles = {{0, 1, 3}, {0, 3, 2}};
  milliseconds("flat", scene_of(face, plate, false), folder);
  milliseconds("relief", scene_of(face, plate, true), folder);
  milliseconds("mesh 66500", scene_of(face, displaced_mesh(face, 265, 249), false), folder);
  milliseconds("mesh 264200", scene_of(face, displaced_mesh(face, 599, 439), false), folder);
  face.map = normal_map_of(face.map);
  milliseconds("normal map", scene_of(face, plate, true), folder);
}

}  // namespace
}  // namespace carillon::bench

int main(int argc, char** argv) {
  carillon::bench::run(argc > 1 ? argv[1] : "");
  return EXIT_SUCCESS;
}
