#include <algorithm>
#include <numbers>

#include "render/maps/detail/displaced_mesh.hpp"
#include "render/maps/generated_maps.hpp"
#include "tests/render/scenes.hpp"

namespace carillon::render {
namespace {

using maps::SurfaceMap;

SurfaceMap brick() {
  return maps::generate_map("brick", {{"unevenness", 0}, {"columns", 1}, {"rows", 2}}, 256, 0);
}

/// How many of the pixels tried show the relief elsewhere than where their rays first meet it, by
/// more than a texel.
struct Misses {
  int tried = 0, wrong = 0;
};
Misses count_misses(const Scene& scene, const SurfaceMap& map, const ScenePose& pose = {}) {
  const SceneFrame frame = draw(scene, {pose});
  const Pinhole pinhole(scene.camera);
  Misses misses;
  for (int row = 0; row < scene.camera.height; row += 3) {
    for (int column = 0; column < scene.camera.width; column += 3) {
      const Vec3 eye = pose.turn.conjugate() * (scene.camera.eye - pose.origin);
      const Vec3 ray = pose.turn.conjugate() * pinhole.ray(column, row);
      const double truth = first_hit(map, eye, ray);
      if (!std::isfinite(truth)) continue;
      ++misses.tried;
      const double seen = frame.depth[at(frame, column, row)];
      EXPECT_FALSE(std::isnan(seen));
      if (!(std::abs(seen - truth) * ray.norm() < map.texel)) ++misses.wrong;
    }
  }
  return misses;
}

TEST(SceneRelief, ShowsWhereRaysFirstMeetIt) {
  const SurfaceMap map = brick();
  Scene scene;
  scene.bodies.push_back(slab(map, 0.02));
  struct View {
    const char* name;
    Vec3 eye, target;
    double wrong;  // part of the pixels, where a ray touches an edge
  };
  for (const View& view : {View{"from above", {0.11, 0.07, 0.5}, {0.11, 0.0751, 0}, 0.002},
                           View{"aslant", {0.05, -0.2, 0.15}, {0.11, 0.08, 0}, 0.01},
                           View{"grazing", {0.11, -0.15, 0.012}, {0.11, 0.08, 0}, 0.03},
                           View{"near", {0.11, 0.06, 0.005}, {0.11, 0.09, -0.002}, 0.02}}) {
    scene.camera = {
        .width = 240, .height = 180, .eye = view.eye, .target = view.target, .samples = 1};
    const Misses misses = count_misses(scene, map);
    EXPECT_GT(misses.tried, 300) << view.name;
    EXPECT_LE(misses.wrong, view.wrong * misses.tried) << view.name << misses.tried;
  }
}

TEST(SceneRelief, ShowsItOnABodyThatIsTurnedAndInsideTheSlab) {
  const SurfaceMap map = brick();
  Scene scene;
  scene.bodies.push_back(slab(map, 0.02));
  scene.camera = {
      .width = 200, .height = 150, .eye = {0.4, 0.5, 0.3}, .target = {0, 0, 0.1}, .samples = 1};
  const ScenePose pose = {Eigen::Quaterniond(Eigen::AngleAxisd(1.1, Vec3(-1, 1, 0.5).normalized())),
                          {0.0, -0.1, 0.1}};
  const Misses turned = count_misses(scene, map, pose);
  EXPECT_GT(turned.tried, 200);
  EXPECT_LE(turned.wrong, 0.01 * turned.tried);
  // The joint between the rows, seen from within.
  const double v = map.size().y() / 2;
  ASSERT_LT(maps::height_at(map, {0.03, v}), -0.0035);
  scene.camera.eye = {0.03, v, -0.002};
  scene.camera.target = {0.2, v, -0.0025};
  const Misses inside = count_misses(scene, map);
  EXPECT_GT(inside.tried, 500);
  EXPECT_LE(inside.wrong, 0.03 * inside.tried);
}

// A step of a relief, from the face down: the spline makes a slope of two texels of it.
TEST(SceneRelief, ShowsAVerticalEdge) {
  SurfaceMap map{"step", 64, 64, 0.001, false, std::vector<float>(64 * 64), {}, {}};
  for (int i = 0; i < 64 * 64; ++i) map.heights[std::size_t(i)] = i % 64 < 32 ? 0.0F : -0.012F;
  Scene scene;
  scene.bodies.push_back(slab(map, 0.03));
  for (const Vec3& eye : {Vec3(0.15, -0.1, 0.1), Vec3(-0.1, 0.02, 0.1), Vec3(0.032, 0.03, 0.3)}) {
    scene.camera = {.width = 200,
                    .height = 150,
                    .eye = eye,
                    .target = {0.032, 0.032, 0},
                    .field_of_view = 0.4,
                    .samples = 1};
    const Misses misses = count_misses(scene, map);
    EXPECT_GT(misses.tried, 300);
    EXPECT_LE(misses.wrong, 0.01 * misses.tried) << eye.transpose();
  }
}

TEST(SceneRelief, OfNoDepthIsTheFlatFace) {
  SurfaceMap map = brick();
  std::fill(map.heights.begin(), map.heights.end(), 0.0F);
  Scene scene;
  scene.camera = {.width = 160, .height = 120, .eye = {0.1, -0.2, 0.1}, .target = {0.11, 0.07, 0}};
  scene.bodies.push_back(slab(map, 0.02));
  scene.bodies.push_back({sphere(0.02), {}, {}, {}});
  const std::vector<ScenePose> poses = {{}, {.origin = {0.1, 0.07, 0.02}}};
  const SceneFrame relief = draw(scene, poses);
  scene.bodies[0].texture.reset();
  const SceneFrame flat = draw(scene, poses);
  int different = 0;
  for (std::size_t i = 0; i < flat.depth.size(); ++i) {
    if (std::isfinite(flat.depth[i]) && std::isfinite(relief.depth[i])) {
      if (std::abs(relief.depth[i] - flat.depth[i]) > 1e-6) ++different;
    }
    if (relief.mask[i] != flat.mask[i]) ++different;
    for (std::size_t c = 0; c < 3; ++c) {
      if (std::abs(relief.color.pixels[3 * i + c] - flat.color.pixels[3 * i + c]) > 2) ++different;
    }
  }
  EXPECT_LE(different, 40);  // along the edges
}

// Lines of the picture and of the map: colours tell bricks from joints.
TEST(SceneRelief, JointsAreSeenWhereTheMapHasThem) {
  const SurfaceMap map = brick();
  Scene scene;
  scene.camera = {.width = 450,
                  .height = 300,
                  .eye = {0.1125, 0.075, 1.5},
                  .target = {0.1125, 0.075, 0},
                  .up = Vec3::UnitY(),
                  .field_of_view = 0.1,
                  .samples = 1};
  scene.light = Vec3::UnitZ();
  scene.bodies.push_back(slab(map, 0.02));
  scene.bodies[0].appearance = {{0.6, 0.05, 0.05}, 1, 0};
  scene.bodies[0].deep_color = Vec3(0.05, 0.05, 0.6);
  const SceneFrame frame = draw(scene, {{}});
  const Pinhole pinhole(scene.camera);
  int bricks = 0, joints = 0;
  for (int row = 0; row < 300; ++row) {
    for (int column = 0; column < 450; ++column) {
      const auto pixel = at(frame, column, row);
      if (frame.mask[pixel] != 1) continue;
      const Vec3 place = pinhole.place(column, row, frame.depth[pixel]);
      // Where the map is all high or all low within a texel, the picture says which.
      double low = 0, high = -1;
      for (int k = 0; k < 9; ++k) {
        const Eigen::Vector2d off(k % 3 - 1, k / 3 - 1);
        const double height = maps::height_at(map, place.head<2>() + off * map.texel);
        low = std::min(low, height);
        high = std::max(high, height);
      }
      const auto* color = frame.color.pixels.data() + 3 * pixel;
      if (low > -0.001) {
        EXPECT_GT(color[0], color[2] + 40) << column << " " << row;
        ++bricks;
      } else if (high < -0.003) {
        EXPECT_GT(color[2], color[0] + 40) << column << " " << row;
        ++joints;
      }
    }
  }
  EXPECT_GT(bricks, 50000);
  EXPECT_GT(joints, 5000);
}

// A trench lit from the side: its wall's shadow reaches depth times the tangent of the light's
// angle to the normal.
TEST(SceneRelief, ShadowInATrenchIsAsWideAsGeometryHasIt) {
  const int n = 128;
  const double texel = 0.0005, depth = 0.008;
  SurfaceMap map{"trench", n, n, texel, false, std::vector<float>(n * n), {}, {}};
  for (int i = 0; i < n * n; ++i) {
    map.heights[std::size_t(i)] = i % n >= 40 && i % n < 100 ? float(-depth) : 0.0F;
  }
  Scene scene;
  scene.bodies.push_back(slab(map, 0.02));
  scene.bodies[0].appearance = {{0.5, 0.5, 0.5}, 1, 0};
  scene.camera = {.width = 400,
                  .height = 40,
                  .eye = {0.032, 0.032, 2},
                  .target = {0.032, 0.032, 0},
                  .up = Vec3::UnitY(),
                  .field_of_view = 0.003};
  const Pinhole pinhole(scene.camera);
  for (const double tangent : {0.8, 1.5, 2.5}) {
    scene.light = {-tangent, 0, 1};
    scene.light_radius = 0;
    const SceneFrame frame = draw(scene, {{}});
    const auto column = [&](double x) { return int(pinhole.pixel({x, 0.032, -depth}).x()); };
    const int lit = brightness(frame, column(0.0485), 20);
    const int dark = brightness(frame, column(0.0215), 20);
    ASSERT_GT(lit, dark + 60);
    // The last dark place on the floor, from the left wall at 40 texels on.
    int edge = column(0.0215);
    while (brightness(frame, edge, 20) < (lit + dark) / 2) ++edge;
    const double x = pinhole.place(edge, 20, 2 + depth).x() - 0.5 * (2 + depth) / pinhole.focal;
    // The wall's rim is the spline's: within two texels of the step's, exactly where a ray of light
    // touches it.
    double touched = 0;
    for (int k = 0; k < 1000; ++k) {
      const double rim = (37 + k * 0.006) * texel;
      touched = std::max(touched, rim + tangent * (maps::height_at(map, {rim, 0.032}) + depth));
    }
    EXPECT_NEAR(x - 40 * texel, depth * tangent, 2 * texel) << tangent;
    EXPECT_NEAR(x, touched, 0.6 * texel) << tangent;
  }
}

// A ball within a trench, below the face, has a shadow on its floor.
TEST(SceneRelief, WhatLiesInItCastsItsShadow) {
  SurfaceMap map{"trench", 64, 64, 0.001, false, std::vector<float>(64 * 64, -0.01F), {}, {}};
  for (std::size_t i = 0; i < map.heights.size(); ++i) {
    if (i % 64 < 16 || i % 64 >= 48) map.heights[i] = 0;
  }
  Scene scene;
  scene.camera = {.width = 200,
                  .height = 200,
                  .eye = {0.032, 0.032, 0.4},
                  .target = {0.032, 0.032, 0},
                  .up = Vec3::UnitY(),
                  .field_of_view = 0.15};
  scene.light = {0, -1, 1};
  scene.bodies.push_back(slab(map, 0.02));
  scene.bodies.push_back({sphere(0.0015, 64), {}, {}, {}});
  const SceneFrame with = draw(scene, {{}, {.origin = {0.032, 0.03, -0.005}}});
  const SceneFrame without = draw(scene, {{}, {.origin = {9, 9, 9}}});
  const Pinhole pinhole(scene.camera);
  // The light falls along +y and down: 5 mm below the ball, and 5 mm on.
  const auto darker = [&](double x, double y) {
    const Eigen::Vector2d pixel = pinhole.pixel({x, y, -0.01});
    return brightness(without, int(pixel.x()), int(pixel.y())) -
           brightness(with, int(pixel.x()), int(pixel.y()));
  };
  EXPECT_GT(darker(0.032, 0.035), 60);
  EXPECT_LT(darker(0.032, 0.0385), 5);
  EXPECT_LT(darker(0.036, 0.035), 5);
}

TEST(SceneRelief, LooksLikeTheMeshOfTheSameDetail) {
  SurfaceMap map = brick();
  maps::TexturedFace face;
  face.map = std::make_shared<const SurfaceMap>(map);
  face.size = map.size();
  Scene scene;
  scene.camera = {
      .width = 320, .height = 240, .eye = {0.05, -0.12, 0.1}, .target = {0.11, 0.07, 0}};
  scene.light = {-0.6, -0.3, 0.7};
  const solvers::mesh::SurfaceMesh mesh = maps::displaced_mesh(face, 2 * map.width, 2 * map.height);
  scene.bodies.push_back({mesh, {{0.5, 0.4, 0.3}, 0.9, 0}, {}, {}});
  const SceneFrame fine = draw(scene, {{}});
  scene.bodies[0].mesh = sheet(face.size.x(), face.size.y());
  scene.bodies[0].texture = face;
  const SceneFrame relief = draw(scene, {{}});
  scene.bodies[0].texture.reset();
  const SceneFrame flat = draw(scene, {{}});
  double of_relief = 0, of_flat = 0;
  int masks = 0, depths = 0;
  for (std::size_t i = 0; i < fine.depth.size(); ++i) {
    masks += fine.mask[i] != relief.mask[i];
    if (std::isfinite(fine.depth[i]) && std::isfinite(relief.depth[i])) {
      depths += std::abs(fine.depth[i] - relief.depth[i]) > map.texel;
    }
    for (std::size_t c = 3 * i; c < 3 * i + 3; ++c) {
      of_relief += std::abs(fine.color.pixels[c] - relief.color.pixels[c]);
      of_flat += std::abs(fine.color.pixels[c] - flat.color.pixels[c]);
    }
  }
  EXPECT_LT(of_relief, 0.25 * of_flat);
  EXPECT_LT(masks, 0.002 * double(fine.depth.size()));
  EXPECT_LT(depths, 0.005 * double(fine.depth.size()));
}

// A map larger than a round face ends with it; in one that is larger than the map, it is a pit with
// walls.
TEST(SceneRelief, EndsWithItsFaceAndHasWallsWithinIt) {
  const SurfaceMap map = maps::generate_map("pebbles", {}, 256, 1);
  SceneBody disc{turned_object({{0, -0.03}, {0.05, -0.03}, {0.05, 0}, {0, 0}}, 256), {}, {}, {}};
  SceneBody plate{box({-0.08, -0.08, -0.03}, {0.08, 0.08, 0}), {}, {}, {}};
  const maps::TexturedFace face{std::make_shared<const SurfaceMap>(map),
                                {-0.06, -0.06, 0},
                                Vec3::UnitX(),
                                Vec3::UnitY(),
                                {0.12, 0.12}};
  Scene scene;
  scene.camera = {
      .width = 240, .height = 180, .eye = {0.1, -0.25, 0.15}, .target = {0, 0, 0}, .samples = 1};
  for (SceneBody* body : {&disc, &plate}) {
    scene.bodies = {*body};
    const SceneFrame flat = draw(scene, {{}});
    scene.bodies[0].texture = face;
    const SceneFrame relief = draw(scene, {{}});
    int beyond = 0, holes = 0, deep = 0, all = 0;
    for (std::size_t i = 0; i < flat.mask.size(); ++i) {
      all += flat.mask[i];
      beyond += flat.mask[i] < relief.mask[i];
      holes += flat.mask[i] > relief.mask[i];
      deep += flat.mask[i] == 1 && relief.mask[i] == 1 && relief.depth[i] > flat.depth[i] + 1e-3;
    }
    EXPECT_EQ(beyond, 0);
    // Between the pebbles at the far edge of the disc, one sees past it; in a pit, never.
    EXPECT_LE(holes, body == &disc ? 0.05 * all : 5);
    EXPECT_GT(deep, 0.3 * all);
  }
  // From above, the disc is as large as ever, but for its rim.
  scene.bodies = {disc};
  scene.bodies[0].texture = face;
  scene.camera.eye = {0, 0, 1};
  scene.camera.up = Vec3::UnitY();
  scene.camera.field_of_view = 0.2;
  const SceneFrame above = draw(scene, {{}});
  const double focal = Pinhole(scene.camera).focal;
  EXPECT_NEAR(double(std::count(above.mask.begin(), above.mask.end(), 1)),
              std::numbers::pi * std::pow(0.05 * focal, 2), 2 * std::numbers::pi * 0.05 * focal);
}

// A ball deep in a joint: bricks before it hide it, and it hides the joint behind it.
TEST(SceneRelief, ABallDipsIntoIt) {
  const SurfaceMap map = brick();
  Scene scene;
  scene.camera = {.width = 240,
                  .height = 180,
                  .eye = {0.11, -0.1, 0.05},
                  .target = {0.11, 0.075, 0},
                  .field_of_view = 0.25,
                  .samples = 1};
  scene.bodies.push_back(slab(map, 0.02));
  scene.bodies.push_back({sphere(0.004, 128), {}, {}, {}});
  const Vec3 middle(0.11, map.size().y() / 2, -0.0005);
  const SceneFrame frame = draw(scene, {{}, {.origin = middle}});
  const Pinhole pinhole(scene.camera);
  int seen = 0, hidden = 0, wrong = 0;
  for (int row = 0; row < 180; ++row) {
    for (int column = 0; column < 240; ++column) {
      const Vec3 ray = pinhole.ray(column, row), off = scene.camera.eye - middle;
      const double a = ray.squaredNorm(), b = off.dot(ray);
      const double root = b * b - a * (off.squaredNorm() - 0.004 * 0.004);
      if (root < 0) continue;
      const double ball = (-b - std::sqrt(root)) / a;
      const bool visible = ball < first_hit(map, scene.camera.eye, ray);
      (visible ? seen : hidden) += 1;
      wrong += frame.mask[at(frame, column, row)] != (visible ? 2 : 1);
    }
  }
  EXPECT_GT(seen, 100);
  EXPECT_GT(hidden, 10);
  EXPECT_LE(wrong, 0.05 * (seen + hidden));
}

// A sheet whose normal map tilts it everywhere looks like a sheet that is tilted, from afar.
TEST(SceneRelief, NormalMapsShadeLikeTheSlopesThatTheyMean) {
  SurfaceMap map{
      "slope", 8, 8, 0.01, true, {}, std::vector<float>(64, 0.3F), std::vector<float>(64, -0.2F)};
  Scene scene;
  scene.camera = {
      .width = 20, .height = 20, .eye = {10, -20, 15}, .target = {0, 0, 0}, .field_of_view = 0.001};
  scene.bodies.push_back({sheet(0.08, 0.08), {{0.5, 0.4, 0.3}, 0.5, 0}, {}, {}});
  scene.bodies[0].texture = maps::TexturedFace{std::make_shared<const SurfaceMap>(map),
                                               Vec3::Zero(),
                                               Vec3::UnitX(),
                                               Vec3::UnitY(),
                                               {0.08, 0.08}};
  scene.light = {0.7, 0.2, 0.5};  // away from which the slopes lean
  const std::vector<ScenePose> here = {{.origin = {-0.04, -0.04, 0}}};
  const SceneFrame mapped = draw(scene, here);
  scene.bodies[0].texture.reset();
  const SceneFrame flat = draw(scene, here);
  const Eigen::Quaterniond tilt =
      Eigen::Quaterniond::FromTwoVectors(Vec3::UnitZ(), maps::normal_of({0.3, -0.2}));
  const SceneFrame tilted = draw(scene, {{tilt, tilt * Vec3(-0.04, -0.04, 0)}});
  ASSERT_EQ(mapped.mask[210], 1);
  EXPECT_NEAR(brightness(mapped, 10, 10), brightness(tilted, 10, 10), 3);
  EXPECT_GT(std::abs(brightness(mapped, 10, 10) - brightness(flat, 10, 10)), 10);
}

}  // namespace
}  // namespace carillon::render
