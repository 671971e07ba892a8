#include "render/frame.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>
#include <thread>

#include "core/error.hpp"
#include "render/shading_mesh.hpp"
#include "tests/render/bodies.hpp"

// Mesa keeps a few hundred bytes for each thread that drew; the address sanitizer's leak check is
// told so (the name is its own).
extern "C" const char* __lsan_default_suppressions();
extern "C" const char* __lsan_default_suppressions() {
  return "leak:libOSMesa\nleak:libLLVM\nleak:libEGL\nleak:libgallium\nleak:swrast_dri\n";
}

namespace carillon::render {
namespace {

const Appearance black = {{0, 0, 0}, 1, 0};

std::array<int, 3> pixel(const core::Image& image, int column, int row) {
  const auto* p =
      image.pixels.data() + (std::size_t(row) * std::size_t(image.width) + std::size_t(column)) * 3;
  return {p[0], p[1], p[2]};
}

int brightness(const core::Image& image, int column, int row) {
  const auto [r, g, b] = pixel(image, column, row);
  return r + g + b;
}

/// The backdrop is grey and its rows are uniform: what differs from the row's first pixel is body.
struct Silhouette {
  double pixels = 0;
  double column = 0;  ///< centroid
  double row = 0;
};

Silhouette silhouette(const core::Image& image) {
  Silhouette found;
  for (int row = 0; row < image.height; ++row) {
    for (int column = 0; column < image.width; ++column) {
      if (pixel(image, column, row) == pixel(image, 0, row)) continue;
      found.pixels += 1;
      found.column += column + 0.5;
      found.row += row + 0.5;
    }
  }
  found.column /= found.pixels;
  found.row /= found.pixels;
  return found;
}

TEST(Frame, SphereCoversItsDiscInTheMiddle) {
  for (const auto& [width, height] :
       {std::pair{200, 200}, std::pair{300, 180}, std::pair{160, 240}}) {
    Camera camera;
    camera.width = width;
    camera.height = height;
    camera.distance = 0.5;
    // The silhouette's cone has half-angle asin(R / D).
    const double tangent = std::tan(std::asin(0.05 / 0.5));
    const double radius = tangent / std::tan(camera.field_of_view / 2) * height / 2;
    const Silhouette disc = silhouette(render_frame(sphere(0.05, 96), camera, black));
    EXPECT_NEAR(std::sqrt(disc.pixels / std::numbers::pi), radius, 0.7) << width;
    EXPECT_NEAR(disc.column, width / 2.0, 0.1);
    EXPECT_NEAR(disc.row, height / 2.0, 0.1);
  }
}

TEST(Frame, AutomaticDistanceFitsTheBodyWhateverItsSizeAndPlace) {
  Camera camera;
  camera.width = 220;
  camera.height = 140;
  const Silhouette first = silhouette(render_frame(sphere(0.05, 96), camera, black));
  EXPECT_GT(first.pixels, 0.7 * std::numbers::pi * 70 * 70);
  for (const double scale : {1e-6, 1e3}) {
    auto ball = sphere(0.05 * scale, 96);
    transform(ball, Eigen::Matrix3d::Identity(), Vec3(3, -4, 5) * scale);
    const Silhouette other = silhouette(render_frame(ball, camera, black));
    EXPECT_NEAR(other.pixels, first.pixels, 0.002 * first.pixels);
    EXPECT_NEAR(other.column, 110, 0.1);
    EXPECT_NEAR(other.row, 70, 0.1);
  }
  // Nothing touches the border, from any side, even seen from straight above and below.
  auto rod = box({-1, -0.02, -0.02}, {1, 0.02, 0.02});
  transform(rod, Eigen::AngleAxisd(0.7, Vec3(1, 1, 1).normalized()).toRotationMatrix(),
            Vec3::Zero());
  for (const double elevation : {-std::numbers::pi / 2, -0.4, 0.0, std::numbers::pi / 2}) {
    for (const double azimuth : {0.0, 2.0, 4.0}) {
      camera.elevation = elevation;
      camera.azimuth = azimuth;
      const core::Image image = render_frame(rod, camera, black);
      EXPECT_GT(silhouette(image).pixels, 50);
      for (int column = 0; column < 220; ++column) {
        EXPECT_EQ(pixel(image, column, 0), pixel(image, 0, 0));
        EXPECT_EQ(pixel(image, column, 139), pixel(image, 0, 139));
      }
    }
  }
}

TEST(Frame, ColoursOfVerticesTakeTheAppearancesPlace) {
  const solvers::mesh::SurfaceMesh ball = sphere(0.05, 48);
  Appearance painted = black;
  painted.roughness = 0.5;
  painted.colours.assign(ball.vertices.size(), {0.3, 0.5, 0.1});
  const Appearance plain{{0.3, 0.5, 0.1}, 0.5, 0};
  const Camera camera{.width = 64, .height = 64};
  EXPECT_EQ(render_frame(ball, camera, painted).pixels, render_frame(ball, camera, plain).pixels);
  painted.colours.pop_back();
  EXPECT_THROW(render_frame(ball, camera, painted), core::InputError);
}

TEST(Frame, FacesOfOtherMaterialsLookLikeThese) {
  const auto mesh = sphere(1, 96);
  const Appearance red = {{0.8, 0, 0}, 1, 0};
  FaceLooks faces{{{{0, 0.8, 0}, 1, 0}, {{0, 0, 0.8}, 1, 0}}, {}};
  // Red above, blue below, green between: the look of no face is left out.
  for (const auto& triangle : mesh.triangles) {
    const double z = mesh.vertices[static_cast<std::size_t>(triangle[0])].z();
    faces.of_faces.push_back(z > 0.3 ? 0 : z < -0.3 ? 2 : 1);
  }
  const Camera camera{.width = 101, .height = 101, .azimuth = 0, .elevation = 0};
  const core::Image image = render_frame(mesh, camera, red, faces);
  const std::array<int, 3> rows = {30, 50, 70};
  for (std::size_t k = 0; k < 3; ++k) {
    const auto seen = pixel(image, 50, rows[k]);
    EXPECT_EQ(std::max_element(seen.begin(), seen.end()) - seen.begin(), std::ptrdiff_t(k));
  }
  // All faces of one look are the body of that look.
  faces.of_faces.assign(mesh.triangles.size(), 1);
  EXPECT_EQ(render_frame(mesh, camera, red, faces).pixels,
            render_frame(mesh, camera, faces.others[0]).pixels);
  faces.of_faces.back() = 3;
  EXPECT_THROW(render_frame(mesh, camera, red, faces), core::InputError);
  faces.of_faces.pop_back();
  EXPECT_THROW(render_frame(mesh, camera, red, faces), core::InputError);
}

TEST(Frame, IsLitFromTheUpperLeft) {
  Camera camera;
  const core::Image image = render_frame(sphere(1, 96), camera, Appearance{});
  const int lit = brightness(image, 128 - 40, 128 - 40);
  const int shaded = brightness(image, 128 + 40, 128 + 40);
  EXPECT_GT(lit, shaded + 60);
  EXPECT_LE(lit, 3 * 254) << "burnt out";
  EXPECT_GT(shaded, 3 * 30) << "lost in the dark";
  // Wherever the camera stands, the light stands with it.
  camera.azimuth += 2.5;
  const core::Image other = render_frame(sphere(1, 96), camera, Appearance{});
  EXPECT_NEAR(brightness(other, 88, 88), lit, 6);
}

TEST(Frame, GivesTheSameBytesTwiceAndInAnotherThread) {
  const auto body = bowl(0.08, 0.006);
  const Camera camera;
  const Appearance steel = appearance_of("steel");
  const core::Image first = render_frame(body, camera, steel);
  // Another picture in between leaves no trace.
  render_frame(sphere(3), {.width = 64, .height = 96}, appearance_of("wood"));
  EXPECT_EQ(render_frame(body, camera, steel).pixels, first.pixels);
  std::vector<std::uint8_t> elsewhere;
  std::thread([&] { elsewhere = render_frame(body, camera, steel).pixels; }).join();
  EXPECT_EQ(elsewhere, first.pixels);
}

TEST(Frame, AzimuthAndElevationMoveTheCameraAroundTheBody) {
  // A small ball at +x and a counterweight out of sight would hide nothing: two balls on a line.
  auto body = sphere(0.1, 32);
  transform(body, Eigen::Matrix3d::Identity(), Vec3(1, 0, 0));
  auto far = sphere(0.1, 32);
  transform(far, Eigen::Matrix3d::Identity(), Vec3(-1, 0, 0));
  append(body, far, false);
  Camera camera;
  camera.elevation = 0;
  camera.distance = 4;
  camera.width = camera.height = 240;
  const double focal = 120 / std::tan(camera.field_of_view / 2);
  for (const double azimuth : {0.2, -0.35}) {
    camera.azimuth = azimuth;
    const core::Image image = render_frame(body, camera, black);
    // The near ball at (1, 0, 0): right = -sin az, depth = 4 - cos az.
    const double near_column = 120 - focal * std::sin(azimuth) / (4 - std::cos(azimuth));
    const double far_column = 120 + focal * std::sin(azimuth) / (4 + std::cos(azimuth));
    EXPECT_NE(pixel(image, int(near_column), 120), pixel(image, 0, 120));
    EXPECT_NE(pixel(image, int(far_column), 120), pixel(image, 0, 120));
    EXPECT_EQ(pixel(image, 120, 120), pixel(image, 0, 120));
    // Mirror images hold nothing where nothing is (the two lie at different distances).
    const int mirrored = int(240 - near_column + (azimuth > 0 ? 12 : -12));
    EXPECT_EQ(pixel(image, mirrored, 120), pixel(image, 0, 120));
  }
  // From above, the near ball sinks.
  camera.azimuth = 0;
  camera.elevation = 0.3;
  const core::Image above = render_frame(body, camera, black);
  const double row = 120 + focal * std::sin(0.3) / (4 - std::cos(0.3));
  EXPECT_NE(pixel(above, 120, int(row)), pixel(above, 0, int(row)));
}

// An inside-out body looks like the body, not like a hole.
TEST(Frame, FacesAreLitFromBothSides) {
  auto ball = sphere(1, 64);
  const core::Image outward = render_frame(ball, {}, Appearance{});
  for (auto& triangle : ball.triangles) std::swap(triangle[1], triangle[2]);
  const core::Image inward = render_frame(ball, {}, Appearance{});
  EXPECT_NEAR(silhouette(inward).pixels, silhouette(outward).pixels, 40);
  EXPECT_NEAR(brightness(inward, 160, 100), brightness(outward, 160, 100), 60);
}

TEST(Frame, BowlShadesItsOwnInside) {
  Camera camera;
  camera.elevation = 0.9;
  const core::Image image = render_frame(bowl(1, 0.06), camera, {{0.7, 0.7, 0.7}, 1, 0});
  // Inside, the key light from the left reaches the right wall, the left one lies in its own
  // shadow.
  EXPECT_GT(brightness(image, 128 + 60, 115), brightness(image, 128 - 75, 115) + 30);
}

TEST(Frame, MaterialsLookDifferent) {
  std::set<std::string> pictures;
  const auto body = sphere(1);
  const std::vector<std::string> names = {"ceramic",
                                          "glass",
                                          "wood",
                                          "plastic",
                                          "iron",
                                          "polycarbonate",
                                          "steel",
                                          "sterling_porcelain",
                                          "sterling_travertine"};
  for (const std::string& name : names) {
    const auto image = render_frame(body, {.width = 32, .height = 32}, appearance_of(name));
    pictures.emplace(image.pixels.begin(), image.pixels.end());
  }
  EXPECT_EQ(pictures.size(), names.size());
  EXPECT_EQ(appearance_of("sterling_wood").color, appearance_of("wood").color);
  EXPECT_EQ(appearance_of("unobtainium").metallic, 0);
  EXPECT_EQ(appearance_of("unobtainium").color, Appearance{}.color);
  EXPECT_EQ(appearance_of("steel").metallic, 1);
}

TEST(Appearance, IsOfTheLastKnownWordElseOfTheGroup) {
  EXPECT_EQ(appearance_of("bell_bronze").color, appearance_of("phosphor_bronze").color);
  EXPECT_EQ(appearance_of("crown_glass").color, appearance_of("glass").color);
  EXPECT_EQ(appearance_of("sterling_steel_hybrid").color, appearance_of("steel").color);
  EXPECT_EQ(appearance_of("titanium_6al4v").metallic, 1);
  // Two words say more than one.
  EXPECT_EQ(appearance_of("glass_fibre").transmission, 0);
  EXPECT_EQ(appearance_of("nickel_silver").metallic, 1);
  EXPECT_NE(appearance_of("nickel_silver").color, appearance_of("silver").color);
  EXPECT_EQ(appearance_of("plywood", "wood").metallic, 0);
  EXPECT_NE(appearance_of("plywood", "wood").color, Appearance{}.color);
  EXPECT_EQ(appearance_of("zamak", "metal").metallic, 1);
  EXPECT_EQ(appearance_of("_").color, Appearance{}.color);
  // A list of numbers has no word that is known.
  EXPECT_EQ(appearance_of("youngs_modulus=7e10,poisson_ratio=0.2,density=2500").color,
            Appearance{}.color);
}

TEST(Frame, RefusesWhatCannotBe) {
  const auto ball = sphere(1, 8);
  EXPECT_THROW(render_frame({}, {}, {}), core::InputError);
  EXPECT_THROW(render_frame(ball, {.width = 0}, {}), core::InputError);
  EXPECT_THROW(render_frame(ball, {.height = 100000}, {}), core::InputError);
  EXPECT_THROW(render_frame(ball, {.azimuth = std::nan("")}, {}), core::InputError);
  EXPECT_THROW(render_frame(ball, {.field_of_view = 3.2}, {}), core::InputError);
  EXPECT_THROW(render_frame(ball, {.distance = -1}, {}), core::InputError);
  EXPECT_THROW(render_frame(ball, {}, {.roughness = 2}), core::InputError);
  auto broken = ball;
  broken.vertices[2].y() = INFINITY;
  EXPECT_THROW(render_frame(broken, {}, {}), core::InputError);
}

TEST(ShadingMesh, KeepsEdgesOfABoxAndSmoothsASphere) {
  constexpr double crease = 0.7;
  const auto cube = box({0, 0, 0}, {1, 1, 1});
  const ShadingMesh sharp = shading_mesh(cube, bounding_ball(cube), crease);
  EXPECT_EQ(sharp.positions.size(), 3u * 24u);  // four corners for each of six sides
  ASSERT_EQ(sharp.sources.size(), 24u);
  for (std::size_t i = 0; i < sharp.sources.size(); ++i) {
    const Vec3 place(sharp.positions[3 * i], sharp.positions[3 * i + 1],
                     sharp.positions[3 * i + 2]);
    const auto& corner = cube.vertices[static_cast<std::size_t>(sharp.sources[i])];
    EXPECT_LT((place - (corner - Vec3(0.5, 0.5, 0.5)) / std::sqrt(0.75)).norm(), 1e-6);
  }
  for (std::size_t i = 0; i < sharp.normals.size(); i += 3) {
    const float largest = std::max({std::abs(sharp.normals[i]), std::abs(sharp.normals[i + 1]),
                                    std::abs(sharp.normals[i + 2])});
    EXPECT_FLOAT_EQ(largest, 1);
  }
  const auto ball = sphere(2, 48);
  const ShadingMesh smooth = shading_mesh(ball, bounding_ball(ball), crease);
  std::set<std::int32_t> used;
  for (const auto& triangle : ball.triangles) used.insert(triangle.begin(), triangle.end());
  EXPECT_EQ(smooth.positions.size(), 3 * used.size());
  for (std::size_t i = 0; i < smooth.normals.size(); i += 3) {
    const Vec3 p(smooth.positions[i], smooth.positions[i + 1], smooth.positions[i + 2]);
    const Vec3 n(smooth.normals[i], smooth.normals[i + 1], smooth.normals[i + 2]);
    EXPECT_NEAR(p.norm(), 1, 1e-6);
    EXPECT_GT(n.dot(p), 0.999);
  }
}

TEST(ShadingMesh, TriangleSoupsAreAsSmooth) {
  const auto ball = sphere(1, 24);
  solvers::mesh::SurfaceMesh soup;
  for (const auto& triangle : ball.triangles) {
    const auto base = std::int32_t(soup.vertices.size());
    for (const std::int32_t vertex : triangle) {
      soup.vertices.push_back(ball.vertices[std::size_t(vertex)]);
    }
    soup.triangles.push_back({base, base + 1, base + 2});
  }
  const ShadingMesh whole = shading_mesh(ball, bounding_ball(ball), 0.7);
  const ShadingMesh pieces = shading_mesh(soup, bounding_ball(soup), 0.7);
  EXPECT_EQ(pieces.positions.size(), whole.positions.size());
}

TEST(ShadingMesh, SurvivesFacesWithoutArea) {
  auto cube = box({0, 0, 0}, {1, 1, 1});
  cube.triangles.push_back({0, 0, 1});
  cube.triangles.push_back({0, 1, 1});
  cube.triangles.push_back({2, 2, 2});
  const ShadingMesh mesh = shading_mesh(cube, bounding_ball(cube), 0.7);
  for (const float n : mesh.normals) EXPECT_TRUE(std::isfinite(n));
  EXPECT_EQ(mesh.indices.size(), 3 * cube.triangles.size());
}

}  // namespace
}  // namespace carillon::render
