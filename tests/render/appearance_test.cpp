// What a material does to a picture: colours in closed form, conductors, grain.
#include "render/looks/appearance.hpp"
#include "render/detail/studio.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/error.hpp"
#include "render/detail/studio.hpp"
#include "render/frame.hpp"
#include "tests/render/scenes.hpp"

namespace carillon::render {
namespace {

Vec3 pixel_of(const core::Image& image, int column, int row) {
  const auto* p =
      image.pixels.data() + (std::size_t(row) * std::size_t(image.width) + std::size_t(column)) * 3;
  return {double(p[0]), double(p[1]), double(p[2])};
}

double srgb_byte(double linear) {
  return 255 * (linear <= 0.0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1 / 2.4) - 0.055);
}

/// What a plate that faces the camera sends back along its normal, which is level: the studio's
/// light, scattered and mirrored.
Vec3 facing_plate(const Appearance& look) {
  const Studio studio =
      make_studio(Vec3(0.65, -0.55, 0.75).normalized(), Scene{}.light_radius, Vec3::Constant(0.24));
  const Eigen::Vector4d r = look.roughness * Eigen::Vector4d(-1, -0.0275, -0.572, 0.022) +
                            Eigen::Vector4d(1, 0.0425, 1.04, -0.04);
  const double a = std::min(r[0] * r[0], std::exp2(-9.28)) * r[0] + r[1];
  const double scale = -1.04 * a + r[2], offset = 1.04 * a + r[3];
  const Vec3 f0 = look.metallic * look.color + (1 - look.metallic) * Vec3::Constant(0.04);
  const Vec3 mirrored = (scale * f0 + Vec3::Constant(offset))
                            .cwiseProduct(Vec3::Ones() + (1 / (scale + offset) - 1) * f0);
  // Half of a level surface's light is the sky's, half the floor's.
  Vec3 scattered = 0.5 * (studio.sky + studio.floor), seen = scattered;
  const auto spread = [](double t) { return t / std::sqrt(1 + t * t); };
  const double blur = 2 * look.roughness * look.roughness + 0.03;
  for (const SoftBox& box : studio.boxes) {
    const Vec3 normal = box.axes.transpose() * Vec3::UnitX();
    // A wide box sets like a wide sun.
    const double wide = box.half.y(), up = std::clamp(normal.z() + wide, 0.0, 2 * wide);
    scattered += (normal.z() > wide ? normal.z() : up * up / (4 * wide)) * box.light;
    if (normal.z() <= 0) continue;
    double covered = 1;
    for (int k = 0; k < 2; ++k) {
      const double x = normal[k] / normal.z();
      covered *= 0.5 * (spread((box.half[k] - x) / blur) + spread((box.half[k] + x) / blur));
    }
    seen += covered * box.radiance();
  }
  const double solid = (1 - look.metallic) * (1 - mirrored.maxCoeff());
  // Straight through a thin plate: the middle of the backdrop.
  return mirrored.cwiseProduct(seen) +
         solid * ((1 - look.transmission) * look.color.cwiseProduct(scattered) +
                  look.transmission * Vec3::Constant(0.66));
}

TEST(Appearance, ColourOfAFacingPlateIsItsClosedForm) {
  const auto plate = box({-0.001, -1, -1}, {0.001, 1, 1});
  const Camera camera{
      .width = 65, .height = 65, .azimuth = 0, .elevation = 0, .field_of_view = 0.1};
  const auto expect_closed_form = [&](const Appearance& look, const char* name) {
    ASSERT_EQ(look.grain, looks::Grain::none) << name;
    const Vec3 expected = facing_plate(look);
    ASSERT_LT(expected.maxCoeff(), 0.7) << name << ": highlights are bent there";
    const Vec3 seen = pixel_of(render_frame(plate, camera, look), 32, 32);
    for (int k = 0; k < 3; ++k) EXPECT_NEAR(seen[k], srgb_byte(expected[k]), 1.01) << name << k;
  };
  for (const char* name : {"terracotta", "plastic", "gypsum", "neoprene", "pla", "copper", "brass",
                           "iron", "lead", "tungsten"}) {
    expect_closed_form(appearance_of(name), name);
  }
  expect_closed_form({.color = {0.4, 0.6, 0.5}, .roughness = 0.2, .transmission = 0.8}, "clear");
}

TEST(Appearance, ConductorsScatterNothing) {
  const auto plate = box({-0.001, -1, -1}, {0.001, 1, 1});
  const Camera camera{
      .width = 33, .height = 33, .azimuth = 0, .elevation = 0, .field_of_view = 0.1};
  const auto middle = [&](const Appearance& look) {
    return pixel_of(render_frame(plate, camera, look), 16, 16);
  };
  // Blue is mirrored by nothing here, so that what is left of it would be scattered.
  Appearance look{.color = {0.9, 0.5, 0}, .roughness = 0.05, .metallic = 1};
  EXPECT_LT(middle(look)[2], 30);
  look.metallic = 0;
  const Vec3 scattering = middle(look);
  EXPECT_GT(scattering[0], scattering[2] + 60);
  // A dielectric mirrors in white, a conductor in its colour.
  look = {.color = {0, 0, 0}, .roughness = 0.05};
  const Vec3 mirrored = middle(look);
  EXPECT_NEAR(mirrored[0], mirrored[2], 12);
}

std::vector<bool> mask_of(const core::Image& image) {
  std::vector<bool> body;
  for (int row = 0; row < image.height; ++row) {
    for (int column = 0; column < image.width; ++column) {
      body.push_back(pixel_of(image, column, row) != pixel_of(image, 0, row));
    }
  }
  return body;
}

TEST(Appearance, MaterialsChangeThePictureAndNotTheOutline) {
  const auto body = bowl(0.08, 0.006);
  const core::Image first = render_frame(body, {}, appearance_of("neoprene"));
  for (const char* name : {"copper", "walnut", "brick", "plastic"}) {
    const core::Image other = render_frame(body, {}, appearance_of(name));
    EXPECT_NE(other.pixels, first.pixels) << name;
    EXPECT_EQ(mask_of(other), mask_of(first)) << name;
  }
}

/// Mean differences of neighbours down the rows and along them, over the middle of a picture.
std::pair<double, double> roughness_of(const core::Image& image) {
  double down = 0, along = 0;
  int count = 0;
  for (int row = image.height / 2 - 20; row < image.height / 2 + 20; ++row) {
    for (int column = image.width / 2 - 20; column < image.width / 2 + 20; ++column) {
      const Vec3 here = pixel_of(image, column, row);
      down += (pixel_of(image, column, row + 1) - here).norm();
      along += (pixel_of(image, column + 1, row) - here).norm();
      ++count;
    }
  }
  return {down / count, along / count};
}

TEST(Grain, LiesAlongTheLongestAxis) {
  // Seen from above, y goes along rows and x down them.
  const Camera camera{.width = 160, .height = 160, .azimuth = 0, .elevation = 1.5707963};
  Appearance look = appearance_of("oak");
  for (look.piece = 0; look.piece < 4; ++look.piece) {
    const auto [down, across] =
        roughness_of(render_frame(box({0, 0, 0}, {0.3, 0.2, 0.1}), camera, look));
    EXPECT_GT(across, 2 * down) << "rings and fibres are crossed";
    const auto [over, along] =
        roughness_of(render_frame(box({0, 0, 0}, {0.2, 0.3, 0.1}), camera, look));
    EXPECT_GT(over, 2 * along);
  }
}

TEST(Grain, IsThatOfItsPiece) {
  const Camera camera{.width = 96, .height = 96};
  for (const char* name : {"oak", "granite", "marble"}) {
    Appearance look = appearance_of(name);
    const auto body = box({0, 0, 0}, {0.3, 0.2, 0.1});
    const core::Image first = render_frame(body, camera, look);
    EXPECT_EQ(render_frame(body, camera, look).pixels, first.pixels) << name;
    look.piece = 1;
    EXPECT_NE(render_frame(body, camera, look).pixels, first.pixels) << name;
    look.piece = 0;
    look.grain = looks::Grain::none;
    const auto [down, along] = roughness_of(render_frame(body, camera, look));
    const auto [grained_down, grained_along] = roughness_of(first);
    EXPECT_GT(grained_down + grained_along, 1.5 * (down + along)) << name;
  }
}

TEST(Grain, RingsGoThroughTheBody) {
  // The long beam's end, seen along the grain from +x: y to the right, z up.
  const Camera camera{.width = 201, .height = 201, .azimuth = 0, .elevation = 0};
  Appearance look = appearance_of("oak");
  look.grain_contrast = 1;
  const auto end = box({-0.04, -0.02, -0.02}, {0.04, 0.02, 0.02});
  // A section further along has nearly the same rings.
  const core::Image front = render_frame(end, camera, look);
  const core::Image back =
      render_frame(box({-0.04, -0.02, -0.02}, {0.0384, 0.02, 0.02}), camera, look);
  double difference = 0, spread = 0, mean = 0;
  int count = 0;
  for (int row = 80; row < 120; ++row) {
    for (int column = 80; column < 120; ++column) mean += pixel_of(front, column, row).sum();
  }
  mean /= 1600;
  for (int row = 80; row < 120; ++row) {
    for (int column = 80; column < 120; ++column, ++count) {
      spread += std::abs(pixel_of(front, column, row).sum() - mean);
      difference +=
          std::abs(pixel_of(front, column, row).sum() - pixel_of(back, column, row).sum());
    }
  }
  EXPECT_GT(spread / count, 15) << "rings show on the end";
  EXPECT_LT(difference, spread);
}

TEST(Grain, ShowsInScenesAndGivesWayToColours) {
  Scene scene;
  scene.bodies = {{.mesh = sphere(0.05, 64), .appearance = appearance_of("oak")}};
  scene.camera = {.width = 120, .height = 120, .eye = {0.3, 0, 0}, .target = {0, 0, 0}};
  const auto [down, along] = roughness_of(draw(scene, {ScenePose{}}).color);
  scene.bodies[0].appearance.grain = looks::Grain::none;
  const auto [smooth_down, smooth_along] = roughness_of(draw(scene, {ScenePose{}}).color);
  EXPECT_GT(down + along, 3 * (smooth_down + smooth_along));

  const auto ball = sphere(0.05, 48);
  Appearance painted = appearance_of("oak");
  painted.colours.assign(ball.vertices.size(), painted.color);
  Appearance plain = appearance_of("oak");
  plain.grain = looks::Grain::none;
  EXPECT_EQ(render_frame(ball, {}, painted).pixels, render_frame(ball, {}, plain).pixels);
}

TEST(Appearance, IsReadKeyByKey) {
  const auto read = [](const std::string& text, const Appearance& fallback) {
    return looks::read_appearance(core::ConfigNode::parse(text, "look.yaml"), fallback);
  };
  const Appearance steel = appearance_of("steel");
  const Appearance rough = read("roughness: 0.9", steel);
  EXPECT_EQ(rough.roughness, 0.9);
  EXPECT_EQ(rough.color, steel.color);
  EXPECT_EQ(rough.metallic, 1);
  const Appearance all = read(
      "{base_colour: [0.1, 0.2, 0.3], metallic: 0, transmission: 0.5, coat: 0.75, "
      "grain: veined, grain_contrast: 0.2}",
      steel);
  EXPECT_EQ(all.color, Vec3(0.1, 0.2, 0.3));
  EXPECT_EQ(all.grain, looks::Grain::veined);
  EXPECT_EQ(looks::to_json(all).dump(),
            R"({"base_colour":[0.1,0.2,0.3],"coat":0.75,"grain":"veined","grain_contrast":0.2,)"
            R"("metallic":0.0,"roughness":0.28,"transmission":0.5})");
  for (const char* wrong : {"{base_colour: [0.1, 0.2]}", "{base_colour: [0.1, 0.2, 3]}",
                            "{roughness: 2}", "{grain: zebra}", "{color: [0, 0, 0]}"}) {
    EXPECT_THROW(read(wrong, steel), core::ConfigError) << wrong;
  }
}

}  // namespace
}  // namespace carillon::render
