#include <numbers>
#include <thread>

#include "core/error.hpp"
#include "tests/render/scenes.hpp"

namespace carillon::render {
namespace {

Scene ball_over_ground() {
  Scene scene;
  scene.camera = {.width = 160, .height = 120, .eye = {0.5, -0.7, 0.6}, .target = {0, 0.05, 0.02}};
  scene.ground = SceneGround{};
  scene.bodies.push_back({sphere(0.05, 96), {}, {}, {}});
  return scene;
}

TEST(SceneFrame, DepthOfAPlaneIsTheClosedForm) {
  Scene scene = ball_over_ground();
  scene.bodies.clear();
  scene.ground->reach = 5;
  const SceneFrame frame = draw(scene, {});
  const Pinhole pinhole(scene.camera);
  for (int row = 0; row < 120; row += 3) {
    for (int column = 0; column < 160; column += 3) {
      const Vec3 ray = pinhole.ray(column, row);
      const double depth = -scene.camera.eye.z() / ray.z();
      EXPECT_NEAR(frame.depth[at(frame, column, row)], depth, 2e-6 * depth);
      EXPECT_EQ(frame.mask[at(frame, column, row)], 0);
    }
  }
  // Nothing at all above the horizon.
  scene.camera.target = scene.camera.eye + Vec3(0, 1, 1);
  const SceneFrame sky = draw(scene, {});
  for (const float depth : sky.depth) EXPECT_TRUE(std::isinf(depth));
}

TEST(SceneFrame, MaskOfASphereIsItsDiscAndItsDepthTheClosedForm) {
  Scene scene;
  scene.camera = {.width = 301, .height = 241, .eye = {0.6, 0, 0.2}, .target = {0, 0, 0.2}};
  for (int i = 0; i < 3; ++i) scene.bodies.push_back({sphere(0.05, 192), {}, {}, {}});
  // One in the middle of the picture, one to the side and behind, one far behind the camera.
  const std::vector<ScenePose> poses = {
      {Eigen::Quaterniond(Eigen::AngleAxisd(1, Vec3(1, 2, 3).normalized())), {0, 0, 0.2}},
      {.origin = {-0.3, 0.06, 0.2}},
      {.origin = {2, 0, 0}}};
  const SceneFrame frame = draw(scene, poses);
  const double focal = Pinhole(scene.camera).focal;
  const double radius = focal * std::tan(std::asin(0.05 / 0.6));
  const auto count = [&](int body) {
    return std::count(frame.mask.begin(), frame.mask.end(), body);
  };
  EXPECT_NEAR(count(1), std::numbers::pi * radius * radius, 2 * radius);
  EXPECT_GT(count(2), 100);
  EXPECT_EQ(count(3), 0);
  const Pinhole pinhole(scene.camera);
  for (int row = 0; row < 241; row += 2) {
    for (int column = 0; column < 301; column += 2) {
      // Nearest of both spheres along the ray.
      const Vec3 ray = pinhole.ray(column, row);
      double nearest = INFINITY;
      int body = 0;
      for (int i = 0; i < 2; ++i) {
        const Vec3 off = scene.camera.eye - poses[std::size_t(i)].origin;
        const double b = off.dot(ray), a = ray.squaredNorm();
        const double root = b * b - a * (off.squaredNorm() - 0.0025);
        if (root < 0) continue;
        const double depth = (-b - std::sqrt(root)) / a;
        if (depth < nearest) nearest = depth, body = i + 1;
      }
      const auto pixel = at(frame, column, row);
      if (frame.mask[pixel] != body) continue;  // edges of the mesh's facets
      if (body == 0) {
        EXPECT_TRUE(std::isinf(frame.depth[pixel]));
      } else if (std::isfinite(nearest)) {
        // Facets lie up to 0.05 (1 - cos(pi / 192)) = 7 um below the sphere, seen at a slant.
        EXPECT_NEAR(frame.depth[pixel], nearest, 1e-3);
      }
    }
  }
  EXPECT_NEAR(frame.depth[at(frame, 150, 120)], 0.55, 2e-5);
}

// The shadow of a ball lies where the light's rays through its middle meet the ground, and is an
// ellipse of its radius and of its radius over the sine of the light's elevation.
TEST(SceneFrame, ColoursOfVerticesStandWhereTheyAre) {
  Scene scene;
  scene.camera = {.width = 121, .height = 121, .eye = {0.6, 0, 0}, .target = {0, 0, 0}};
  SceneBody ball{sphere(0.05, 96), {}, {}, {}};
  // Red above, green below.
  for (const Vec3& v : ball.mesh.vertices)
    ball.appearance.colours.emplace_back(v.z() > 0 ? Vec3(0.8, 0, 0) : Vec3(0, 0.8, 0));
  scene.bodies.push_back(ball);
  const core::Image picture = draw(scene, {{}}).color;
  const auto channel = [&](int column, int row, std::size_t k) {
    return int{picture.pixels[std::size_t(row * picture.width + column) * 3 + k]};
  };
  EXPECT_GT(channel(60, 52, 0), channel(60, 52, 1) + 40);
  EXPECT_GT(channel(60, 68, 1), channel(60, 68, 0) + 40);
  scene.bodies[0].appearance.colours.pop_back();
  EXPECT_THROW(draw(scene, {{}}), core::InputError);
}

TEST(SceneFrame, FacesOfOtherMaterialsLookLikeThese) {
  Scene scene;
  scene.camera = {.width = 121, .height = 121, .eye = {0.6, 0, 0}, .target = {0, 0, 0}};
  SceneBody ball{sphere(0.05, 96), {{0.8, 0, 0}, 1, 0}, {}, {}};
  ball.faces.others = {{{0, 0.8, 0}, 1, 0}};
  // Red above, green below.
  for (const auto& triangle : ball.mesh.triangles) {
    const Vec3& corner = ball.mesh.vertices[static_cast<std::size_t>(triangle[0])];
    ball.faces.of_faces.push_back(corner.z() > 0 ? 0 : 1);
  }
  scene.bodies.push_back(ball);
  const SceneFrame frame = draw(scene, {{}});
  const auto channel = [&](int column, int row, std::size_t k) {
    return int{frame.color.pixels[std::size_t(row * 121 + column) * 3 + k]};
  };
  EXPECT_GT(channel(60, 52, 0), channel(60, 52, 1) + 40);
  EXPECT_GT(channel(60, 68, 1), channel(60, 68, 0) + 40);
  EXPECT_EQ(frame.mask[at(frame, 60, 52)], 1);
  EXPECT_EQ(frame.mask[at(frame, 60, 68)], 1);
  scene.bodies[0].faces.of_faces.pop_back();
  EXPECT_THROW(draw(scene, {{}}), core::InputError);
}

TEST(SceneFrame, ShadowOfABallLiesWhereTheLightPutsIt) {
  Scene scene = ball_over_ground();
  scene.camera = {.width = 300,
                  .height = 300,
                  .eye = {0.1, 0.05, 2},
                  .target = {0.1, 0.05, 0},
                  .up = Vec3::UnitY(),
                  .field_of_view = 0.35};
  scene.light = {-1, -0.5, 1.2};
  scene.light_radius = 0.01;
  const SceneFrame with = draw(scene, {{{.origin = {0, 0, 0.15}}}});
  const SceneFrame without = draw(scene, {{{.origin = {0, 0, -9}}}});
  const Pinhole pinhole(scene.camera);
  // Half of the lamp is seen at the edge of the shadow that its middle casts.
  const Eigen::Vector2d core = pinhole.pixel({0.125, 0.0625, 0});
  const int darkest = brightness(without, int(core.x()), int(core.y())) -
                      brightness(with, int(core.x()), int(core.y()));
  ASSERT_GT(darkest, 100);
  Eigen::Vector2d middle(0, 0);
  double area = 0;
  for (int row = 0; row < 300; ++row) {
    for (int column = 0; column < 300; ++column) {
      if (with.mask[at(with, column, row)] != 0) continue;
      const int dark = brightness(without, column, row) - brightness(with, column, row);
      if (2 * dark < darkest) continue;
      middle += pinhole.place(column, row, 2).head<2>();
      area += 1;
    }
  }
  middle /= area;
  EXPECT_NEAR(middle.x(), 0.15 * 1 / 1.2, 0.002);
  EXPECT_NEAR(middle.y(), 0.15 * 0.5 / 1.2, 0.002);
  const double pixel = 2 / pinhole.focal;
  const double sine = 1.2 / scene.light.norm();
  EXPECT_NEAR(area * pixel * pixel, std::numbers::pi * 0.0025 / sine, 0.0004);
}

TEST(SceneFrame, BodiesShadeEachOther) {
  Scene scene = ball_over_ground();
  scene.light = {0, 0, 1};
  scene.bodies.push_back({sphere(0.03, 48), {}, {}, {}});
  const Vec3 above(0, 0, 0.5);
  const Pinhole pinhole(scene.camera);
  const SceneFrame shaded = draw(scene, {{}, {.origin = above}});
  const SceneFrame lit = draw(scene, {{}, {.origin = {1, 1, 9}}});
  const Eigen::Vector2d top = pinhole.pixel({0.005, -0.005, 0.049});
  EXPECT_LT(brightness(shaded, int(top.x()), int(top.y())),
            brightness(lit, int(top.x()), int(top.y())) - 80);
}

// A wide floor among the bodies leaves small ones their shadows, down to where they touch it; what
// stands between the light and the picture has its own.
TEST(SceneFrame, SmallBodiesOnAWideFloorHaveShadows) {
  Scene scene;
  scene.camera = {.width = 200, .height = 150, .eye = {0.0, -0.2, 0.2}, .target = {0, 0, 0}};
  scene.light = {-1, 0, 1};
  scene.bodies.push_back({box({-4, -4, -0.1}, {4, 4, 0}), {}, {}, {}});
  scene.bodies.push_back({sphere(0.01, 96), {}, {}, {}});
  const Pinhole pinhole(scene.camera);
  const auto at_place = [&](const SceneFrame& frame, double x, double y) {
    const Eigen::Vector2d pixel = pinhole.pixel({x, y, 0});
    return brightness(frame, int(pixel.x()), int(pixel.y()));
  };
  const SceneFrame near = draw(scene, {{}, {.origin = {0, 0, 0.01}}});
  const SceneFrame none = draw(scene, {{}, {.origin = {3, 3, 0.01}}});
  // Light falls along +x: the shadow's ellipse reaches from 0.01 (1 - sqrt 2) to 0.01 (1 + sqrt 2).
  EXPECT_GT(at_place(none, 0.02, 0) - at_place(near, 0.02, 0), 80);
  EXPECT_GT(at_place(none, 0.01, 0.005) - at_place(near, 0.01, 0.005), 80);
  EXPECT_NEAR(at_place(near, 0.028, 0), at_place(none, 0.028, 0), 5);
  EXPECT_NEAR(at_place(near, -0.02, 0), at_place(none, -0.02, 0), 5);
  // One that hangs far outside of the picture, on the light's way to its middle.
  scene.light_radius = 0.001;  // a wider lamp is not hidden from there
  const SceneFrame above = draw(scene, {{}, {.origin = {-1.5, 0, 1.5}}});
  EXPECT_GT(at_place(none, 0, 0) - at_place(above, 0, 0), 80);
}

TEST(SceneFrame, GivesTheSameBytesAgain) {
  const Scene scene = ball_over_ground();
  const std::vector<ScenePose> here = {{.origin = {0, 0, 0.05}}},
                               there = {{.origin = {0.1, 0, 0.3}}};
  SceneRenderer renderer(scene);
  const SceneFrame first = renderer.draw(here);
  // Other frames, scenes and pictures in between leave no trace.
  EXPECT_NE(renderer.draw(there).color.pixels, first.color.pixels);
  const core::Image bowl_before = render_frame(bowl(1, 0.1), {}, {});
  draw(ball_over_ground(), there);
  const SceneFrame second = renderer.draw(here);
  EXPECT_EQ(render_frame(bowl(1, 0.1), {}, {}).pixels, bowl_before.pixels);
  EXPECT_EQ(second.color.pixels, first.color.pixels);
  EXPECT_EQ(second.depth, first.depth);
  EXPECT_EQ(second.mask, first.mask);
  std::thread([&] { EXPECT_EQ(draw(scene, here).color.pixels, first.color.pixels); }).join();
}

TEST(SceneFrame, RefusesWhatCannotBe) {
  const auto refuses = [](auto change) {
    Scene scene = ball_over_ground();
    change(scene);
    EXPECT_THROW(SceneRenderer{scene}, core::InputError);
  };
  refuses([](Scene& s) { s.camera.width = 0; });
  refuses([](Scene& s) { s.camera.height = 5000; });
  refuses([](Scene& s) { s.camera.samples = 2; });
  refuses([](Scene& s) { s.camera.field_of_view = 4; });
  refuses([](Scene& s) { s.camera.target = s.camera.eye; });
  refuses([](Scene& s) { s.camera.up = s.camera.target - s.camera.eye; });
  refuses([](Scene& s) { s.light = Vec3::Zero(); });
  refuses([](Scene& s) { s.light.x() = NAN; });
  refuses([](Scene& s) { s.bodies[0].mesh = {}; });
  refuses([](Scene& s) { s.bodies[0].appearance.roughness = 2; });
  refuses([](Scene& s) { s.bodies[0].deep_color = Vec3(0, 2, 0); });
  refuses([](Scene& s) { s.bodies.resize(256, s.bodies[0]); });
  refuses([](Scene& s) { s.ground->reach = 0; });
  refuses([](Scene& s) { s.ground->map = std::make_shared<const maps::SurfaceMap>(); });
  refuses([](Scene& s) {
    s.bodies[0].texture = maps::TexturedFace{};
    s.bodies[0].texture->size = {1, 1};
  });
  SceneRenderer renderer(ball_over_ground());
  EXPECT_THROW(renderer.draw({}), core::InputError);
  const std::vector<ScenePose> lost = {{.origin = {NAN, 0, 0}}};
  EXPECT_THROW(renderer.draw(lost), core::InputError);
}

}  // namespace
}  // namespace carillon::render
