// The light of pictures against closed forms: energy, shadows, what is seen through glass, and
// normals.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "render/detail/drawing.hpp"
#include "render/detail/shading_code.hpp"
#include "render/detail/studio.hpp"
#include "render/shading_mesh.hpp"
#include "tests/render/scenes.hpp"

namespace carillon::render {
namespace {

/// A ball that a camera far away sees, in even light of radiance 1 from everywhere and no other.
constexpr const char* furnace_vertex = R"(#version 330 core
out vec2 place;
void main() {
  place = vec2(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0);
  gl_Position = vec4(place, 0.0, 1.0);
}
)";
constexpr const char* furnace_fragment = R"(
in vec2 place;
out vec4 color;
uniform vec3 reflectance;
void main() {
  float rr = dot(place, place);
  if (rr >= 0.999) discard;
  vec3 n = vec3(place, sqrt(1.0 - rr));
  color = vec4(shade(n, vec3(0.0, 0.0, 1.0), reflectance, roughness, 1.0, 1.0, vec3(1.0)), 1.0);
}
)";

/// Colours of the ball's pixels; the first channel is that of the middle at [side / 2 side / 2].
class Furnace {
 public:
  static constexpr int side = 65;

  std::vector<float> draw(const Appearance& look) {
    glBindFramebuffer(GL_FRAMEBUFFER, target_.get());
    glViewport(0, 0, side, side);
    glDisable(GL_DEPTH_TEST);
    const std::array<float, 4> nothing = {-1, -1, -1, 0};
    glClearBufferfv(GL_COLOR, 0, nothing.data());
    glUseProgram(program_.get());
    set_vector(program_, "reflectance", look.color);
    set_number(program_, "roughness", look.roughness);
    set_number(program_, "metallic", look.metallic);
    set_number(program_, "transmission", look.transmission);
    set_number(program_, "coat", look.coat);
    Studio even = make_studio(Vec3(0.6, 0, 0.8), 0.1, Vec3::Ones());
    even.sky = even.floor = Vec3::Ones();
    for (SoftBox& box : even.boxes) box.light = Vec3::Zero();
    set_studio(program_, even);
    glBindVertexArray(array_.get());
    glDrawArrays(GL_TRIANGLES, 0, 3);
    std::vector<float> colours(3 * side * side);
    glReadPixels(0, 0, side, side, GL_RGB, GL_FLOAT, colours.data());
    check_gl("drawing in a furnace");
    return colours;
  }

  Furnace()
      : program_(
            make_program(furnace_vertex, std::string(glsl_version) + shading + furnace_fragment)),
        colours_(make_target(GL_RGB32F, GL_RGB, GL_FLOAT, side, side)) {
    glGenVertexArrays(1, array_.put());
    glGenFramebuffers(1, target_.put());
    glBindFramebuffer(GL_FRAMEBUFFER, target_.get());
    glFramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, colours_.get(), 0);
  }

 private:
  OffscreenContext& context_ = offscreen_context();
  Program program_;
  Texture colours_;
  Framebuffer target_;
  VertexArray array_;
};

TEST(Light, WhiteBallsAreNotSeenInEvenLight) {
  Furnace furnace;
  for (const double metallic : {0.0, 1.0}) {
    for (const double roughness : {0.1, 0.4, 0.7, 1.0}) {
      const std::vector<float> seen =
          furnace.draw({.color = Vec3::Ones(), .roughness = roughness, .metallic = metallic});
      int pixels = 0;
      for (const float value : seen) {
        if (value < 0) continue;
        EXPECT_NEAR(value, 1, 0.01) << metallic << " " << roughness;
        ++pixels;
      }
      EXPECT_GT(pixels, 9000);
    }
  }
}

TEST(Light, NoSurfaceSendsBackMoreThanItGets) {
  Furnace furnace;
  for (const Vec3& color : {Vec3(0, 0, 0), Vec3(0.5, 0.9, 0.1), Vec3(1, 1, 1)}) {
    for (const double metallic : {0.0, 0.5, 1.0}) {
      for (const double transmission : {0.0, 0.9}) {
        for (const double coat : {0.0, 1.0}) {
          const Appearance look{.color = color,
                                .roughness = 0.3,
                                .metallic = metallic,
                                .transmission = transmission,
                                .coat = coat};
          for (const float value : furnace.draw(look)) EXPECT_LT(value, 1.001);
        }
      }
    }
  }
}

// What a black body mirrors of even light along its normal: Fresnel's ((n - 1) / (n + 1))^2 of
// glass with an index of 1.5, and twice that, less what the first layer keeps, under a glaze of the
// same.
TEST(Light, MirrorsAsFresnelSaysAtNormalIncidence) {
  Furnace furnace;
  const std::size_t middle = 3 * (Furnace::side / 2 * Furnace::side + Furnace::side / 2);
  Appearance look{.color = Vec3::Zero(), .roughness = 0.05};
  const double fresnel = std::pow(0.5 / 2.5, 2);
  EXPECT_NEAR(furnace.draw(look)[middle], fresnel, 0.15 * fresnel);
  look.coat = 1;
  EXPECT_NEAR(furnace.draw(look)[middle], 2 * fresnel - fresnel * fresnel, 0.3 * fresnel);
  look = {.color = {0.9, 0.6, 0.3}, .roughness = 0.05, .metallic = 1};
  const std::vector<float> metal = furnace.draw(look);
  for (std::size_t k = 0; k < 3; ++k)
    EXPECT_NEAR(metal[middle + k], look.color[static_cast<Eigen::Index>(k)], 0.02);
}

/// Linear light of a pixel's red channel, below where highlights bend.
double linear(const SceneFrame& frame, int column, int row) {
  const double byte = frame.color.pixels[3 * at(frame, column, row)] / 255.0;
  return byte <= 0.04045 ? byte / 12.92 : std::pow((byte + 0.055) / 1.055, 2.4);
}

// The edge of a plate far above the ground: the lamp's disc is half hidden where the ray from its
// middle passes the edge, and hidden and free one radius of the lamp's image to either side.
TEST(Light, PenumbraGrowsWithTheLampAndTheDistance) {
  Scene scene;
  scene.camera = {.width = 900,
                  .height = 40,
                  .eye = {0, 0, 4},
                  .target = {0, 0, 0},
                  .up = Vec3::UnitY(),
                  .field_of_view = 0.012};
  scene.light = {-1, 0, 1};
  scene.ground = SceneGround{.appearance = {{0.3, 0.3, 0.3}, 1, 0}};
  scene.bodies.push_back({box({-0.4, -0.3, 0}, {0, 0.3, 0.002}), {}, {}, {}});
  for (const double height : {0.15, 0.3}) {
    for (const double radius : {0.05, 0.1}) {
      scene.light_radius = radius;
      // Its right edge's shadow ends below the camera.
      const SceneFrame frame = draw(scene, {{.origin = {-height, 0, height}}});
      const Pinhole pinhole(scene.camera);
      const auto light_at = [&](double x) {
        return linear(frame, int(pinhole.pixel({x, 0, 0}).x()), 20);
      };
      // Along x the lamp's image is wider by 1 / cos^2 of its slant.
      const double image = 2 * height * std::tan(radius);
      const double dark = light_at(-1.6 * image), lit = light_at(1.6 * image);
      ASSERT_GT(lit, dark + 0.05);
      const auto place_of = [&](double part) {
        double x = -1.6 * image;
        while (light_at(x) < dark + part * (lit - dark)) x += 0.01 * image;
        return x;
      };
      // A disc is covered to a tenth where a chord is 0.687 of the radius from its middle. The
      // filter takes some of what hardly hides the lamp for free: its penumbra is the narrower.
      const double width = place_of(0.9) - place_of(0.1), expected = 2 * 0.687 * image;
      EXPECT_GT(width, 0.45 * expected) << height << " " << radius;
      EXPECT_LT(width, 1.1 * expected) << height << " " << radius;
      EXPECT_NEAR(place_of(0.5), 0, 0.15 * image + 0.004) << height << " " << radius;
    }
  }
}

// Where a ball touches the ground it is dark, and the darkness is gone at some distance.
TEST(Light, GroundIsDarkWhereABallTouchesIt) {
  Scene scene;
  scene.camera = {.width = 300, .height = 200, .eye = {0, -0.5, 0.2}, .target = {0, 0, 0}};
  scene.light = {0, 1, 1};
  scene.ground = SceneGround{};
  scene.bodies.push_back({sphere(0.03, 64), {}, {}, {}});
  const SceneFrame with = draw(scene, {{.origin = {0, 0, 0.03}}});
  const SceneFrame without = draw(scene, {{.origin = {0, 0, -5}}});
  const Pinhole pinhole(scene.camera);
  const auto part_at = [&](double x, double y) {
    const Eigen::Vector2d pixel = pinhole.pixel({x, y, 0});
    return linear(with, int(pixel.x()), int(pixel.y())) /
           linear(without, int(pixel.x()), int(pixel.y()));
  };
  // To the side, where the key's shadow, which falls towards the camera, is not.
  EXPECT_LT(part_at(0.031, 0.0), part_at(0.05, 0.0));
  EXPECT_LT(part_at(0.031, 0.0), 0.99);
  EXPECT_NEAR(part_at(0.12, 0.01), 1, 0.01);
}

// A slab of glass aslant moves what is behind it sideways, by t sin(a) (1 - cos(a) / sqrt(n^2 -
// sin^2(a))).
TEST(Light, ASlabOfGlassMovesWhatIsBehindItAsSnellSays) {
  Scene scene;
  scene.camera = {
      .width = 401, .height = 41, .eye = {0, -4, 0}, .target = {0, 0, 0}, .field_of_view = 0.008};
  // Black to the right of x = 0.
  scene.bodies.push_back({box({-0.5, 0.3, -0.3}, {0, 0.31, 0.3}), {{0.5, 0.5, 0.5}, 1, 0}, {}, {}});
  scene.bodies.push_back({box({0, 0.3, -0.3}, {0.5, 0.31, 0.3}), {{0, 0, 0}, 1, 0}, {}, {}});
  Appearance glass{.color = Vec3::Ones(), .roughness = 0.05, .transmission = 1};
  const double thickness = 0.06;
  scene.bodies.push_back(
      {box({-0.25, -thickness / 2, -0.2}, {0.25, thickness / 2, 0.2}), glass, {}, {}});
  const Pinhole pinhole(scene.camera);
  const auto edge = [&](double angle, bool there) {
    const Eigen::Quaterniond turn(Eigen::AngleAxisd(angle, Vec3::UnitZ()));
    const SceneFrame frame =
        draw(scene, {{}, {}, {.turn = turn, .origin = {0, there ? 0.0 : 9.0, 0}}});
    const double left = linear(frame, 100, 20), right = linear(frame, 380, 20);
    int column = 100;
    while (linear(frame, column, 20) > (left + right) / 2) ++column;
    return (column - 200.0) * 4.3 / pinhole.focal;
  };
  EXPECT_NEAR(edge(0.5, false), 0, 2e-4);
  for (const double angle : {0.5, -0.5, 0.9}) {
    const double sine = std::sin(angle);
    const double moved =
        thickness * sine * (1 - std::cos(angle) / std::sqrt(1.5 * 1.5 - sine * sine));
    EXPECT_NEAR(std::abs(edge(angle, true)), std::abs(moved), 0.08 * std::abs(moved)) << angle;
    EXPECT_EQ(std::signbit(edge(angle, true)), std::signbit(-edge(-angle, true))) << angle;
  }
}

// A ball of glass turns what is far behind it around.
TEST(Light, ABallOfGlassTurnsThePictureAround) {
  Scene scene;
  scene.camera = {
      .width = 201, .height = 201, .eye = {0, -1, 0}, .target = {0, 0, 0}, .field_of_view = 0.15};
  scene.bodies.push_back({box({-0.4, 0.3, -0.3}, {0, 0.31, 0.3}), {{0.5, 0.5, 0.5}, 1, 0}, {}, {}});
  scene.bodies.push_back({box({0, 0.3, -0.3}, {0.4, 0.31, 0.3}), {{0, 0, 0}, 1, 0}, {}, {}});
  Appearance glass{.color = Vec3::Ones(), .roughness = 0.05, .transmission = 1};
  scene.bodies.push_back({sphere(0.04, 128), glass, {}, {}});
  const SceneFrame frame = draw(scene, {{}, {}, {}});
  ASSERT_EQ(frame.mask[at(frame, 85, 100)], 3);
  EXPECT_GT(linear(frame, 115, 100), linear(frame, 85, 100) + 0.1);
  EXPECT_GT(linear(frame, 10, 100), linear(frame, 190, 100) + 0.1) << "beside the ball";
}

// Coarse balls and tubes are shaded as round, and keep their edges.
TEST(Light, NormalsOfCoarseBallsAndTubesAreThoseOfTheSmoothOnes) {
  const auto ball = sphere(1, 16);
  const ShadingMesh round = shading_mesh(ball, bounding_ball(ball), default_crease_angle);
  for (std::size_t i = 0; i < round.normals.size(); i += 3) {
    const Eigen::Map<const Eigen::Vector3f> p(round.positions.data() + i);
    const Eigen::Map<const Eigen::Vector3f> n(round.normals.data() + i);
    EXPECT_GT(n.dot(p.normalized()), std::cos(0.04));
  }
  const auto rod = turned_object({{0, -1}, {0.2, -1}, {0.2, 1}, {0, 1}}, 12);
  const ShadingMesh tube = shading_mesh(rod, bounding_ball(rod), default_crease_angle);
  int sides = 0, ends = 0;
  for (std::size_t i = 0; i < tube.normals.size(); i += 3) {
    const Eigen::Map<const Eigen::Vector3f> p(tube.positions.data() + i);
    const Eigen::Map<const Eigen::Vector3f> n(tube.normals.data() + i);
    const Eigen::Vector3f out = Eigen::Vector3f(p.x(), p.y(), 0).normalized();
    const bool end = std::abs(n.z()) > 0.5F;
    EXPECT_GT(end ? std::abs(n.z()) : n.dot(out), std::cos(0.02));
    ++(end ? ends : sides);
  }
  EXPECT_EQ(sides, 24);
  EXPECT_GE(ends, 24);
}

}  // namespace
}  // namespace carillon::render
