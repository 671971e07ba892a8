// What the detail of a face costs each sense, as a normal map, as a relief and as meshes
// (dissertation Table 5.1): memory, and the time of a step of the motion, a frame and a tick of
// touch. Prints the table of docs/scenes.md, all measured in one run. With a folder, writes a frame
// of each there.
#include <btBulletDynamicsCommon.h>
#include <fmt/core.h>
#include <malloc.h>

#include <chrono>
#include <cstdlib>
#include <filesystem>

#include "render/maps/detail/displaced_mesh.hpp"
#include "render/maps/generated_maps.hpp"
#include "render/scene_frame.hpp"
#include "synth/motion/detail/relief_peaks.hpp"
#include "synth/touch/stylus.hpp"
#include "tests/bench/ball_mesh.hpp"
#include "tests/synth/moving_bodies.hpp"

namespace carillon::bench {
namespace {

using render::Scene;

/// A plate 450 x 300 mm of bricks, drawn one way or another, and a ball on it.
Scene scene_of(const render::maps::TexturedFace& face, const solvers::mesh::SurfaceMesh& mesh,
               bool textured) {
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

using Clock = std::chrono::steady_clock;

/// Least seconds of some calls.
template <class Call>
double min_seconds(int calls, const Call& call) {
  double minimum = 1e9;
  for (int i = 0; i < calls; ++i) {
    const auto start = Clock::now();
    call(i);
    minimum = std::min(minimum, std::chrono::duration<double>(Clock::now() - start).count());
  }
  return minimum;
}

/// Bytes that are allocated at this moment.
double allocated() {
  const struct mallinfo2 info = mallinfo2();
  return static_cast<double>(info.uordblks + info.hblkhd);
}

struct Costs {
  std::string name;
  double memory = 0;       ///< of the detail and what finds contacts in it [byte]
  double motion = 0;       ///< a step of a ball that rolls on it [s]
  double frame = 0;        ///< 512 x 384 pixels [s]
  double plain_frame = 0;  ///< the same with one colour sample a pixel [s]
  double touch = 0;        ///< a tick [s]
};

void time_frames(Scene scene, const std::filesystem::path& folder, Costs& costs) {
  render::SceneFrame frame;
  const auto draw = [&](render::SceneRenderer& renderer, int i) {
    const std::vector<render::ScenePose> poses = {
        {}, {Eigen::Quaterniond::Identity(), Vec3(0.15 + 0.01 * i, 0.15, 0.0135)}};
    frame = renderer.draw(poses);
  };
  render::SceneRenderer renderer(scene);
  costs.frame = min_seconds(5, [&](int i) { draw(renderer, i); });
  if (!folder.empty()) write_png(folder / (costs.name + ".png"), frame.color);
  scene.camera.samples = 1;
  render::SceneRenderer plain(scene);
  costs.plain_frame = min_seconds(5, [&](int i) { draw(plain, i); });
}

/// A ball that rolls over the textured face for half a second: what a step takes more than without
/// the texture is small against the step, so the whole step is told.
double seconds_a_step(const render::maps::TexturedFace& face) {
  std::vector<synth::motion::MovingBody> bodies = {
      synth::box_body({face.size.x(), face.size.y(), 0.02}), synth::ball_body(0.015)};
  bodies[0].fixed = true;
  bodies[0].start.pose.origin = {face.size.x() / 2, face.size.y() / 2, -0.01};
  bodies[0].texture = face;
  bodies[0].texture->origin = {-face.size.x() / 2, -face.size.y() / 2, 0.01};
  bodies[1].start.pose.origin = {0.1, 0.15, 0.0155};
  bodies[1].start.velocity = {0.4, 0.02, 0};
  synth::motion::MotionOptions options;
  const auto seconds_of = [&](double steps) {
    options.seconds = steps * options.time_step;
    return min_seconds(5, [&](int) { synth::motion::simulate_motion(bodies, {}, options); });
  };
  // What is prepared once is not a step's.
  return (seconds_of(501) - seconds_of(1)) / 500;
}

/// Bullet's triangles, with the tree that finds them.
struct Triangles {
  btTriangleIndexVertexArray array;
  std::unique_ptr<btBvhTriangleMeshShape> shape;

  explicit Triangles(const solvers::mesh::SurfaceMesh& mesh)
      : array(static_cast<int>(mesh.triangles.size()),
              const_cast<int*>(mesh.triangles.front().data()), sizeof(solvers::mesh::Triangle),
              static_cast<int>(mesh.vertices.size()),
              const_cast<double*>(mesh.vertices.front().data()), sizeof(Vec3)),
        shape(std::make_unique<btBvhTriangleMeshShape>(&array, true)) {}
};

/// The same ball on a mesh, in Bullet alone; and a ray down onto the mesh, which is the least that
/// touch needs of it.
void time_triangles(const Triangles& triangles, Costs& costs) {
  btDefaultCollisionConfiguration configuration;
  btCollisionDispatcher dispatcher(&configuration);
  btDbvtBroadphase broadphase;
  btSequentialImpulseConstraintSolver solver;
  btDiscreteDynamicsWorld world(&dispatcher, &broadphase, &solver, &configuration);
  world.setGravity({0, 0, -9.80665});
  btRigidBody floor(0, nullptr, triangles.shape.get());
  world.addRigidBody(&floor);
  btSphereShape sphere(0.015);
  const double mass = synth::ball_body(0.015).rigid.mass;
  btVector3 inertia;
  sphere.calculateLocalInertia(mass, inertia);
  btRigidBody ball(mass, nullptr, &sphere, inertia);
  ball.setActivationState(DISABLE_DEACTIVATION);
  world.addRigidBody(&ball);
  costs.motion = min_seconds(5,
                             [&](int) {
                               btTransform start = btTransform::getIdentity();
                               start.setOrigin({0.1, 0.15, 0.0155});
                               ball.setWorldTransform(start);
                               ball.setLinearVelocity({0.4, 0.02, 0});
                               ball.setAngularVelocity({0, 0, 0});
                               for (int k = 0; k < 500; ++k) world.stepSimulation(1e-3, 0);
                             }) /
                 500;
  costs.touch =
      min_seconds(5,
                  [&](int) {
                    for (int k = 0; k < 1000; ++k) {
                      const btVector3 from(0.1 + 2e-4 * k, 0.15, 0.01),
                          to = from - btVector3(0, 0, 0.1);
                      btCollisionWorld::ClosestRayResultCallback hit(from, to);
                      btTransform begin = btTransform::getIdentity(), end = begin;
                      begin.setOrigin(from);
                      end.setOrigin(to);
                      btCollisionWorld::rayTestSingle(begin, end, &floor, triangles.shape.get(),
                                                      floor.getWorldTransform(), hit);
                    }
                  }) /
      1000;
  world.removeRigidBody(&ball);
  world.removeRigidBody(&floor);
}

/// A plate whose detail is its map.
Costs of_map(const std::string& name, const render::maps::TexturedFace& face,
             const solvers::mesh::SurfaceMesh& plate, const std::filesystem::path& folder) {
  Costs costs;
  costs.name = name;
  const double before = allocated();
  render::maps::TexturedFace copy = face;
  copy.map = std::make_shared<const render::maps::SurfaceMap>(*face.map);
  std::optional<synth::motion::ReliefPeaks> peaks;
  if (copy.map->relief()) peaks.emplace(copy.map);
  costs.memory = allocated() - before;
  costs.motion = seconds_a_step(copy);
  const std::vector<Vec3> corners = {{0.05, 0.15, 0}, {0.35, 0.15, 0}};
  const std::vector<Vec3> hand = synth::touch::drawn_path(corners, 0.2, 1000);
  const synth::touch::TouchOptions options{1000, std::make_shared<synth::motion::TracedMaps>()};
  costs.touch = min_seconds(5, [&](int) { synth::touch::draw_stylus(copy, hand, {}, options); }) /
                static_cast<double>(hand.size());
  time_frames(scene_of(copy, plate, true), folder, costs);
  return costs;
}

Costs of_mesh(const std::string& name, const render::maps::TexturedFace& face, int columns,
              int rows, const std::filesystem::path& folder) {
  Costs costs;
  costs.name = name;
  const double before = allocated();
  const solvers::mesh::SurfaceMesh mesh = render::maps::displaced_mesh(face, columns, rows);
  const Triangles triangles(mesh);
  costs.memory = allocated() - before;
  time_triangles(triangles, costs);
  time_frames(scene_of(face, mesh, false), folder, costs);
  return costs;
}

void run(const std::filesystem::path& folder) {
  render::maps::TexturedFace face;
  face.map = std::make_shared<const render::maps::SurfaceMap>(
      render::maps::generate_map("brick", {}, 512, 1));
  face.size = face.map->size();
  solvers::mesh::SurfaceMesh plate;
  for (int i = 0; i < 4; ++i) {
    plate.vertices.emplace_back(i % 2 * face.size.x(), i / 2 * face.size.y(), 0);
  }
  plate.triangles = {{0, 1, 3}, {0, 3, 2}};
  render::maps::TexturedFace normals = face;
  normals.map =
      std::make_shared<const render::maps::SurfaceMap>(render::maps::normal_map_of(*face.map));
  const Costs all[] = {of_map("normal map", normals, plate, folder),
                       of_map("relief", face, plate, folder),
                       of_mesh("mesh 66500", face, 265, 249, folder),
                       of_mesh("mesh 264200", face, 599, 439, folder)};
  fmt::print(
      "| detail | memory | motion, a step | picture, a frame (one sample) | touch, a tick |\n");
  fmt::print("| --- | --- | --- | --- | --- |\n");
  for (const Costs& costs : all) {
    fmt::print("| {} | {:.1f} MB | {:.1f} us | {:.0f} ms ({:.0f}) | {:.2f} us |\n", costs.name,
               1e-6 * costs.memory, 1e6 * costs.motion, 1e3 * costs.frame, 1e3 * costs.plain_frame,
               1e6 * costs.touch);
  }
}

}  // namespace
}  // namespace carillon::bench

int main(int argc, char** argv) {
  carillon::bench::run(argc > 1 ? argv[1] : "");
  return EXIT_SUCCESS;
}
