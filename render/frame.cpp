#include "render/frame.hpp"

#include <fmt/format.h>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <vector>

#include "core/error.hpp"
#include "render/detail/drawing.hpp"
#include "render/detail/frame_shaders.hpp"
#include "render/detail/grain_code.hpp"
#include "render/detail/offscreen.hpp"
#include "render/detail/shading_code.hpp"
#include "render/shading_mesh.hpp"

namespace carillon::render {

namespace {

constexpr int samples = 3;  ///< per pixel and direction
constexpr int shadow_side = 1024;
constexpr double room_around = 1.08;  ///< room around the body's ball

/// A light fixed to the camera: to the right, up and towards the camera.
struct Light {
  Vec3 direction;
  Vec3 color;
};
const std::array<Light, 3> lights = {{{{-0.55, 0.75, 0.65}, {0.62, 0.605, 0.575}},  // key
                                      {{0.80, 0.10, 0.60}, {0.13, 0.145, 0.17}},    // fill
                                      {{0.30, 0.60, -0.75}, {0.36, 0.36, 0.38}}}};  // rim

void check_camera(const Camera& camera) {
  check_picture(camera.width, camera.height, camera.field_of_view);
  if (!std::isfinite(camera.azimuth) || !std::isfinite(camera.elevation)) {
    throw core::InputError("camera: azimuth and elevation must be finite");
  }
  if (!(camera.distance >= 0) || !std::isfinite(camera.distance)) {
    throw core::InputError(
        fmt::format("camera: distance must not be negative, not {} m", camera.distance));
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
  view.distance =
      camera.distance > 0 ? camera.distance / radius : room_around / std::sin(half_narrow);

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
  constexpr double reach_factor = 1.05;
  const Vec3 side = direction.unitOrthogonal();
  Eigen::Matrix4d light = Eigen::Matrix4d::Identity();
  light.block<1, 3>(0, 0) = side.transpose() / reach_factor;
  light.block<1, 3>(1, 0) = direction.cross(side).transpose() / reach_factor;
  light.block<1, 3>(2, 0) = -direction.transpose() / reach_factor;
  return light;
}

/// Context, programs and shadow map, made once; pictures follow one after the other.
class FrameRenderer {
 public:
  FrameRenderer()
      : shadow_program_(make_program(shadow_vertex, shadow_fragment)),
        background_program_(make_program(background_vertex, background_fragment)),
        body_program_(make_program(
            body_vertex, std::string(glsl_version) + shading + grain_code + body_fragment)),
        shadows_(shadow_side) {
    glGenVertexArrays(1, no_vertices_.put());
    check_gl("setting up");
  }

  core::Image draw(const ShadingMesh& mesh, const View& view, const Camera& camera,
                   const Appearance& appearance, const FaceLooks& faces) {
    const DrawableMesh body(mesh, appearance.colours, faces.of_faces);
    std::array<Vec3, 3> direction;
    for (std::size_t i = 0; i < 3; ++i) {
      direction[i] = view.axes.transpose() * lights[i].direction.normalized();
    }
    const Eigen::Matrix4d light = light_view(direction[0]);
    draw_shadows(body, light);

    const int width = samples * camera.width;
    const int height = samples * camera.height;
    const Texture colors = make_target(GL_RGBA16F, GL_RGBA, GL_FLOAT, width, height);
    const Texture depths =
        make_target(GL_DEPTH_COMPONENT32F, GL_DEPTH_COMPONENT, GL_FLOAT, width, height);
    Framebuffer target;
    glGenFramebuffers(1, target.put());
    glBindFramebuffer(GL_FRAMEBUFFER, target.get());
    glFramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, colors.get(), 0);
    glFramebufferTexture2D(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_TEXTURE_2D, depths.get(), 0);
    if (glCheckFramebufferStatus(GL_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE) {
      throw core::Error(fmt::format("OpenGL cannot draw {} x {} samples", width, height));
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
    for (std::size_t i = 0; i < 3; ++i) {
      set_vector(body_program_, fmt::format("light_direction[{}]", i), direction[i]);
      set_vector(body_program_, fmt::format("light_color[{}]", i), lights[i].color);
    }
    glBindTexture(GL_TEXTURE_2D, shadows_.texture());
    for (std::size_t part = 0; part < body.parts(); ++part) {
      const Appearance& look = part == 0 ? appearance : faces.others[part - 1];
      set_appearance(body_program_, look, grain_place(mesh, look));
      body.draw_part(part);
    }
    core::Image image = read_picture(camera.width, camera.height, samples);
    check_gl("drawing");
    return image;
  }

 private:
  void draw_shadows(const DrawableMesh& body, const Eigen::Matrix4d& light) {
    shadows_.begin();
    glUseProgram(shadow_program_.get());
    set_matrix(shadow_program_, "light_from_body", light);
    body.draw();
  }

  OffscreenContext& context_ = offscreen_context();
  Program shadow_program_;
  Program background_program_;
  Program body_program_;
  ShadowMap shadows_;
  VertexArray no_vertices_;
};

}  // namespace

std::vector<core::Image> render_frames(const solvers::mesh::SurfaceMesh& mesh,
                                       std::span<const Camera> cameras,
                                       const Appearance& appearance, const FaceLooks& faces) {
  for (const Camera& camera : cameras) check_camera(camera);
  const BoundingBall ball = bounding_ball(mesh);
  check_looks(appearance, faces, mesh);
  const ShadingMesh body = shading_mesh(mesh, ball, default_crease_angle);
  // Compiling the shaders takes longer than a picture; a context belongs to its thread.
  thread_local FrameRenderer renderer;
  std::vector<core::Image> images;
  for (const Camera& camera : cameras) {
    images.push_back(
        renderer.draw(body, make_view(camera, ball.radius), camera, appearance, faces));
  }
  return images;
}

core::Image render_frame(const solvers::mesh::SurfaceMesh& mesh, const Camera& camera,
                         const Appearance& appearance, const FaceLooks& faces) {
  return render_frames(mesh, {&camera, 1}, appearance, faces).front();
}

}  // namespace carillon::render
