#include "render/frame.hpp"

#include <fmt/format.h>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "core/error.hpp"
#include "render/frame_shaders.hpp"
#include "render/offscreen.hpp"
#include "render/shading_mesh.hpp"

namespace carillon::render {

using solvers::Vec3;

namespace {

constexpr int kMaxSide = 4096;
constexpr int kSamples = 3;  ///< per pixel and direction
constexpr int kShadowSide = 1024;
constexpr double kCreaseAngle = 40 * std::numbers::pi / 180;
constexpr double kMargin = 1.08;  ///< room around the body's ball

/// A light fixed to the camera: to the right, up and towards the camera.
struct Light {
  Vec3 direction;
  Vec3 color;
};
const std::array<Light, 3> kLights = {{{{-0.55, 0.75, 0.65}, {0.62, 0.605, 0.575}},  // key
                                       {{0.80, 0.10, 0.60}, {0.13, 0.145, 0.17}},    // fill
                                       {{0.30, 0.60, -0.75}, {0.36, 0.36, 0.38}}}};  // rim

void check(const Camera& camera, const Appearance& appearance) {
  if (camera.width < 1 || camera.height < 1 || camera.width > kMaxSide ||
      camera.height > kMaxSide) {
    throw core::InputError(fmt::format("camera: picture must be 1 to {} pixels a side, not {} x {}",
                                       kMaxSide, camera.width, camera.height));
  }
  if (!std::isfinite(camera.azimuth) || !std::isfinite(camera.elevation)) {
    throw core::InputError("camera: azimuth and elevation must be finite");
  }
  if (!(camera.field_of_view > 0 && camera.field_of_view < std::numbers::pi)) {
    throw core::InputError(fmt::format(
        "camera: field of view must lie between 0 and pi, not {} rad", camera.field_of_view));
  }
  if (!(camera.distance >= 0) || !std::isfinite(camera.distance)) {
    throw core::InputError(
        fmt::format("camera: distance must not be negative, not {} m", camera.distance));
  }
  for (const double value : {appearance.color[0], appearance.color[1], appearance.color[2],
                             appearance.roughness, appearance.metallic}) {
    if (!(value >= 0 && value <= 1)) {
      throw core::InputError(fmt::format(
          "appearance: color, roughness and metallic lie between 0 and 1, not {}", value));
    }
  }
}

/// Where the camera stands and how it projects, in units of the body's ball about the origin.
struct View {
  Eigen::Matrix3d axes;  ///< rows: right, up, towards the camera
  double distance = 0;
  Eigen::Matrix4d clip_from_body;
};

View make_view(const Camera& camera, double radius) {
  View view;
  const double az = camera.azimuth;
  const double el = camera.elevation;
  const Vec3 back(std::cos(el) * std::cos(az), std::cos(el) * std::sin(az), std::sin(el));
  const Vec3 right(-std::sin(az), std::cos(az), 0);
  view.axes.row(0) = right;
  view.axes.row(1) = back.cross(right);
  view.axes.row(2) = back;

  const double aspect = static_cast<double>(camera.width) / camera.height;
  const double half_height = std::tan(camera.field_of_view / 2);
  const double half_narrow = std::atan(half_height * std::min(1.0, aspect));
  view.distance = camera.distance > 0 ? camera.distance / radius : kMargin / std::sin(half_narrow);

  // Clip planes hug the ball; a camera inside it still sees what lies ahead.
  const double near = std::max(view.distance - 1.01, 1e-3);
  const double far = view.distance + 1.01;
  Eigen::Matrix4d projection = Eigen::Matrix4d::Zero();
  projection(0, 0) = 1 / (half_height * aspect);
  projection(1, 1) = 1 / half_height;
  projection(2, 2) = -(far + near) / (far - near);
  projection(2, 3) = -2 * far * near / (far - near);
  projection(3, 2) = -1;
  Eigen::Matrix4d camera_from_body = Eigen::Matrix4d::Identity();
  camera_from_body.topLeftCorner<3, 3>() = view.axes;
  camera_from_body(2, 3) = -view.distance;
  view.clip_from_body = projection * camera_from_body;
  return view;
}

/// Orthographic view of the ball from a light.
Eigen::Matrix4d light_view(const Vec3& direction) {
  constexpr double kReach = 1.05;
  const Vec3 side = direction.unitOrthogonal();
  Eigen::Matrix4d light = Eigen::Matrix4d::Identity();
  light.block<1, 3>(0, 0) = side.transpose() / kReach;
  light.block<1, 3>(1, 0) = direction.cross(side).transpose() / kReach;
  light.block<1, 3>(2, 0) = -direction.transpose() / kReach;
  return light;
}

std::uint8_t srgb(double linear) {
  const double x = std::clamp(linear, 0.0, 1.0);
  const double encoded = x <= 0.0031308 ? 12.92 * x : 1.055 * std::pow(x, 1 / 2.4) - 0.055;
  return static_cast<std::uint8_t>(std::lround(255 * encoded));
}

void set_matrix(const Program& program, const char* name, const Eigen::Matrix4d& matrix) {
  const Eigen::Matrix4f values = matrix.cast<float>();
  glUniformMatrix4fv(glGetUniformLocation(program.get(), name), 1, GL_FALSE, values.data());
}

void set_vector(const Program& program, const std::string& name, const Vec3& value) {
  const Eigen::Vector3f values = value.cast<float>();
  glUniform3fv(glGetUniformLocation(program.get(), name.c_str()), 1, values.data());
}

void set_number(const Program& program, const char* name, double value) {
  glUniform1f(glGetUniformLocation(program.get(), name), static_cast<float>(value));
}

/// Texture of one level without filtering, where something is drawn to.
Texture make_target(GLint internal, GLenum format, GLenum type, int width, int height) {
  Texture texture;
  glGenTextures(1, texture.put());
  glBindTexture(GL_TEXTURE_2D, texture.get());
  glTexImage2D(GL_TEXTURE_2D, 0, internal, width, height, 0, format, type, nullptr);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
  return texture;
}

/// The body's buffers on the side of OpenGL.
class DrawableBody {
 public:
  explicit DrawableBody(const ShadingMesh& mesh)
      : count_(static_cast<GLsizei>(mesh.indices.size())) {
    glGenVertexArrays(1, array_.put());
    glBindVertexArray(array_.get());
    upload(positions_, mesh.positions, 0);
    upload(normals_, mesh.normals, 1);
    glGenBuffers(1, indices_.put());
    glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, indices_.get());
    glBufferData(GL_ELEMENT_ARRAY_BUFFER,
                 static_cast<GLsizeiptr>(mesh.indices.size() * sizeof(std::uint32_t)),
                 mesh.indices.data(), GL_STATIC_DRAW);
  }
  void draw() const {
    glBindVertexArray(array_.get());
    glDrawElements(GL_TRIANGLES, count_, GL_UNSIGNED_INT, nullptr);
  }

 private:
  static void upload(Buffer& buffer, const std::vector<float>& values, GLuint location) {
    glGenBuffers(1, buffer.put());
    glBindBuffer(GL_ARRAY_BUFFER, buffer.get());
    glBufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(values.size() * sizeof(float)),
                 values.data(), GL_STATIC_DRAW);
    glVertexAttribPointer(location, 3, GL_FLOAT, GL_FALSE, 0, nullptr);
    glEnableVertexAttribArray(location);
  }
  GLsizei count_;
  VertexArray array_;
  Buffer positions_;
  Buffer normals_;
  Buffer indices_;
};

/// Context, programs and shadow map, made once; pictures follow one after the other.
class FrameRenderer {
 public:
  FrameRenderer()
      : shadow_program_(make_program(kShadowVertex, kShadowFragment)),
        background_program_(make_program(kBackgroundVertex, kBackgroundFragment)),
        body_program_(make_program(kBodyVertex, kBodyFragment)),
        shadow_map_(make_target(GL_DEPTH_COMPONENT32F, GL_DEPTH_COMPONENT, GL_FLOAT, kShadowSide,
                                kShadowSide)) {
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_COMPARE_MODE, GL_COMPARE_REF_TO_TEXTURE);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_COMPARE_FUNC, GL_LEQUAL);
    glGenFramebuffers(1, shadow_target_.put());
    glBindFramebuffer(GL_FRAMEBUFFER, shadow_target_.get());
    glFramebufferTexture2D(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_TEXTURE_2D, shadow_map_.get(),
                           0);
    glDrawBuffer(GL_NONE);
    glReadBuffer(GL_NONE);
    glGenVertexArrays(1, no_vertices_.put());
    check_gl("setting up");
  }

  core::Image draw(const ShadingMesh& mesh, const View& view, const Camera& camera,
                   const Appearance& appearance) {
    const DrawableBody body(mesh);
    std::array<Vec3, 3> direction;
    for (std::size_t i = 0; i < 3; ++i) {
      direction[i] = view.axes.transpose() * kLights[i].direction.normalized();
    }
    const Eigen::Matrix4d light = light_view(direction[0]);
    draw_shadows(body, light);

    const int width = kSamples * camera.width;
    const int height = kSamples * camera.height;
    const Texture colors = make_target(GL_RGBA16F, GL_RGBA, GL_FLOAT, width, height);
    const Texture depths =
        make_target(GL_DEPTH_COMPONENT32F, GL_DEPTH_COMPONENT, GL_FLOAT, width, height);
    Framebuffer target;
    glGenFramebuffers(1, target.put());
    glBindFramebuffer(GL_FRAMEBUFFER, target.get());
    glFramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, colors.get(), 0);
    glFramebufferTexture2D(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_TEXTURE_2D, depths.get(), 0);
    if (glCheckFramebufferStatus(GL_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE) {
      throw core::Error(fmt::format("OSMesa cannot draw {} x {} samples", width, height));
    }
    glViewport(0, 0, width, height);
    glClear(GL_DEPTH_BUFFER_BIT);

    glDisable(GL_DEPTH_TEST);
    glUseProgram(background_program_.get());
    glBindVertexArray(no_vertices_.get());
    glDrawArrays(GL_TRIANGLES, 0, 3);

    glEnable(GL_DEPTH_TEST);
    glUseProgram(body_program_.get());
    set_matrix(body_program_, "clip_from_body", view.clip_from_body);
    set_matrix(body_program_, "light_from_body", light);
    set_vector(body_program_, "eye", view.distance * view.axes.row(2).transpose());
    set_vector(body_program_, "reflectance",
               {appearance.color[0], appearance.color[1], appearance.color[2]});
    set_number(body_program_, "roughness", appearance.roughness);
    set_number(body_program_, "metallic", appearance.metallic);
    for (std::size_t i = 0; i < 3; ++i) {
      set_vector(body_program_, fmt::format("light_direction[{}]", i), direction[i]);
      set_vector(body_program_, fmt::format("light_color[{}]", i), kLights[i].color);
    }
    glBindTexture(GL_TEXTURE_2D, shadow_map_.get());
    body.draw();
    core::Image image = read_picture(camera.width, camera.height);
    check_gl("drawing");
    return image;
  }

 private:
  void draw_shadows(const DrawableBody& body, const Eigen::Matrix4d& light) {
    glBindTexture(GL_TEXTURE_2D, 0);
    glBindFramebuffer(GL_FRAMEBUFFER, shadow_target_.get());
    glViewport(0, 0, kShadowSide, kShadowSide);
    glEnable(GL_DEPTH_TEST);
    glClear(GL_DEPTH_BUFFER_BIT);
    glUseProgram(shadow_program_.get());
    set_matrix(shadow_program_, "light_from_body", light);
    body.draw();
  }

  /// Means over each pixel's samples in linear light, then sRGB; rows from top to bottom.
  static core::Image read_picture(int width, int height) {
    const int fine_width = kSamples * width;
    std::vector<float> rows(static_cast<std::size_t>(fine_width) * kSamples * 4);
    core::Image image;
    image.width = width;
    image.height = height;
    image.channels = 3;
    image.pixels.resize(static_cast<std::size_t>(width) * static_cast<std::size_t>(height) * 3);
    auto* pixel = image.pixels.data();
    for (int row = 0; row < height; ++row) {
      glReadPixels(0, kSamples * (height - 1 - row), fine_width, kSamples, GL_RGBA, GL_FLOAT,
                   rows.data());
      for (int column = 0; column < width; ++column) {
        for (int channel = 0; channel < 3; ++channel) {
          double sum = 0;
          for (int j = 0; j < kSamples; ++j) {
            for (int i = 0; i < kSamples; ++i) {
              sum += rows[static_cast<std::size_t>((j * fine_width + kSamples * column + i) * 4 +
                                                   channel)];
            }
          }
          *pixel++ = srgb(sum / (kSamples * kSamples));
        }
      }
    }
    return image;
  }

  OffscreenContext context_;
  Program shadow_program_;
  Program background_program_;
  Program body_program_;
  Texture shadow_map_;
  Framebuffer shadow_target_;
  VertexArray no_vertices_;
};

}  // namespace

core::Image render_frame(const solvers::SurfaceMesh& mesh, const Camera& camera,
                         const Appearance& appearance) {
  check(camera, appearance);
  const BoundingBall ball = bounding_ball(mesh);
  const ShadingMesh body = shading_mesh(mesh, ball, kCreaseAngle);
  const View view = make_view(camera, ball.radius);
  // Compiling the shaders takes longer than a picture; a context belongs to its thread.
  thread_local FrameRenderer renderer;
  return renderer.draw(body, view, camera, appearance);
}

}  // namespace carillon::render
