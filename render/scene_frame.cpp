#include "render/scene_frame.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/error.hpp"
#include "core/numbers.hpp"
#include "render/detail/frame_shaders.hpp"
#include "render/detail/grain_code.hpp"
#include "render/detail/scene_checks.hpp"
#include "render/detail/scene_parts.hpp"
#include "render/detail/scene_shaders.hpp"
#include "render/detail/shading_code.hpp"

namespace carillon::render {
namespace {

constexpr int scene_shadow_side = 2048;
using core::infinity;

/// Units that textures are bound to.
constexpr int shadow_unit = 0, slopes_unit = 1, heights_unit = 2, footprint_unit = 3;

void bind(int unit, GLuint texture) {
  glActiveTexture(static_cast<GLenum>(GL_TEXTURE0 + unit));
  glBindTexture(GL_TEXTURE_2D, texture);
}

/// A fragment shader by the key light and a weak one from the camera's side.
std::string lit(const char* definitions, const char* fragment) {
  return std::string(glsl_version) + "#define LIGHTS 2\n" + definitions + shading + grain_code +
         scene_common + fragment;
}

/// Programs of all scenes; compiling them takes longer than a frame.
struct ScenePrograms {
  OffscreenContext& context = offscreen_context();
  Program shadow = make_program(scene_shadow_vertex, scene_shadow_fragment);
  Program background = make_program(background_vertex, background_fragment);
  Program body = make_program(scene_vertex, lit("", scene_fragment));
  Program relief = make_program(relief_vertex, lit("", relief_fragment));
  Program cut_out_relief = make_program(relief_vertex, lit("#define CUT_OUT\n", relief_fragment));
  FootprintPainter footprints;
};

ScenePrograms& scene_programs() {
  thread_local ScenePrograms programs;
  return programs;
}

Eigen::Affine3d world_from_body(const ScenePose& pose) {
  Eigen::Affine3d world = Eigen::Affine3d::Identity();
  world.translate(pose.origin).rotate(pose.turn.normalized());
  return world;
}

}  // namespace

struct SceneRenderer::Parts {
  ScenePrograms& programs = scene_programs();
  SceneCamera camera;
  Vec3 light;
  Vec3 fade_middle = Vec3::Zero();
  SceneView view;
  std::vector<Drawn> bodies;
  std::optional<Drawn> ground;
  ShadowMap shadows{scene_shadow_side};
  Texture colors, places, depths;
  Framebuffer target;
  VertexArray no_vertices;
  Eigen::Matrix4d light_from_world;
  double shadow_radius = 1;

  Parts(const Scene& scene, double reach_of_all)
      : camera(scene.camera),
        light(scene.light.normalized()),
        view(scene_view(scene.camera, reach_of_all)) {
    for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
      bodies.push_back(make_drawn(scene.bodies[i], static_cast<int>(i) + 1, programs.footprints));
    }
    if (scene.ground) {
      ground = make_drawn(*scene.ground, programs.footprints);
      fade_middle = scene.ground->middle;
    }
    const int width = camera.samples * camera.width, height = camera.samples * camera.height;
    colors = make_target(GL_RGBA16F, GL_RGBA, GL_FLOAT, width, height);
    places = make_target(GL_RG32F, GL_RG, GL_FLOAT, width, height);
    depths = make_target(GL_DEPTH_COMPONENT32F, GL_DEPTH_COMPONENT, GL_FLOAT, width, height);
    glGenFramebuffers(1, target.put());
    glBindFramebuffer(GL_FRAMEBUFFER, target.get());
    glFramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, colors.get(), 0);
    glFramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT1, GL_TEXTURE_2D, places.get(), 0);
    glFramebufferTexture2D(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_TEXTURE_2D, depths.get(), 0);
    if (glCheckFramebufferStatus(GL_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE) {
      throw core::Error(fmt::format("OpenGL cannot draw {} x {} samples", width, height));
    }
    glGenVertexArrays(1, no_vertices.put());
    check_gl("setting up a scene");
  }

  void draw_shadows(std::span<const ScenePose> poses);
  void draw_background();
  void set_common(const Program& program, const Drawn& drawn);
  void draw_mesh(const Drawn& drawn, const Eigen::Affine3d& world_from_body);
  void draw_relief(const Drawn& drawn, const Eigen::Affine3d& world_from_body);
  SceneFrame read() const;
};

/// All bodies near enough to be seen share the shadow map.
void SceneRenderer::Parts::draw_shadows(std::span<const ScenePose> poses) {
  const double near = 4 * (camera.target - camera.eye).norm();
  solvers::mesh::Box box{Vec3::Constant(infinity), Vec3::Constant(-infinity)};
  std::vector<Vec3> centres;
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    centres.emplace_back(world_from_body(poses[i]) * bodies[i].ball.centre);
    if ((centres[i] - camera.target).norm() > near + bodies[i].ball.radius) continue;
    box.low = box.low.cwiseMin(centres[i] - Vec3::Constant(bodies[i].ball.radius));
    box.high = box.high.cwiseMax(centres[i] + Vec3::Constant(bodies[i].ball.radius));
  }
  const bool any = (box.high.array() > box.low.array()).all();
  Vec3 middle = any ? Vec3((box.low + box.high) / 2) : camera.target;
  shadow_radius = near * 1e-6;
  for (std::size_t i = 0; i < bodies.size() && any; ++i) {
    if ((centres[i] - camera.target).norm() > near + bodies[i].ball.radius) continue;
    shadow_radius = std::max(shadow_radius, (centres[i] - middle).norm() + bodies[i].ball.radius);
  }
  // No larger than what the camera sees about its target: a wide floor would leave no detail.
  const double aspect = static_cast<double>(camera.width) / camera.height;
  const double seen = 1.5 * (camera.target - camera.eye).norm() *
                      std::tan(camera.field_of_view / 2) * std::hypot(1, aspect);
  if (shadow_radius > seen) {
    shadow_radius = seen;
    middle = camera.target;
  }
  shadow_radius *= 1.02;
  const Vec3 side = light.unitOrthogonal();
  light_from_world = Eigen::Matrix4d::Identity();
  light_from_world.block<1, 3>(0, 0) = side.transpose() / shadow_radius;
  light_from_world.block<1, 3>(1, 0) = light.cross(side).transpose() / shadow_radius;
  light_from_world.block<1, 3>(2, 0) = -light.transpose() / shadow_radius;
  light_from_world.block<3, 1>(0, 3) = -light_from_world.topLeftCorner<3, 3>() * middle;

  shadows.begin();
  glEnable(GL_DEPTH_CLAMP);  // bodies between the light and what it shows count, too
  glUseProgram(programs.shadow.get());
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const Eigen::Affine3d world = world_from_body(poses[i]) * bodies[i].body_from_mesh;
    set_matrix(programs.shadow, "light_from_mesh", light_from_world * world.matrix());
    const Drawn& body = bodies[i];
    set_matrix(programs.shadow, "face_from_mesh",
               (body.body_from_face.inverse() * body.body_from_mesh).matrix());
    set_vector(programs.shadow, "slab",
               {body.face_size.x(), body.face_size.y(), body.detail ? body.detail->deepest : 0});
    set_number(programs.shadow, "face_tolerance", body.tolerance());
    bodies[i].mesh.draw();
  }
  glDisable(GL_DEPTH_CLAMP);
}

void SceneRenderer::Parts::draw_background() {
  glBindFramebuffer(GL_FRAMEBUFFER, target.get());
  glViewport(0, 0, camera.samples * camera.width, camera.samples * camera.height);
  glClear(GL_DEPTH_BUFFER_BIT);
  const std::array<GLenum, 2> both = {GL_COLOR_ATTACHMENT0, GL_COLOR_ATTACHMENT1};
  glDrawBuffers(2, both.data());
  const std::array<float, 4> nothing = {std::numeric_limits<float>::infinity(), 0, 0, 0};
  glClearBufferfv(GL_COLOR, 1, nothing.data());
  glDrawBuffers(1, both.data());
  glDisable(GL_DEPTH_TEST);
  glUseProgram(programs.background.get());
  glBindVertexArray(no_vertices.get());
  glDrawArrays(GL_TRIANGLES, 0, 3);
  glEnable(GL_DEPTH_TEST);
  glDrawBuffers(2, both.data());
}

void SceneRenderer::Parts::set_common(const Program& program, const Drawn& drawn) {
  glUseProgram(program.get());
  set_matrix(program, "clip_from_world", view.clip_from_world);
  set_matrix(program, "light_from_world", light_from_world);
  set_vector(program, "eye", view.eye);
  set_vector(program, "forward", view.forward);
  set_appearance(program, drawn.looks.front().appearance, drawn.looks.front().grain);
  set_vector(program, "deep_reflectance", drawn.deep_color);
  set_number(program, "body_number", drawn.number);
  const std::array<Vec3, 2> directions = {light, (Vec3(0, 0, 0.3) - view.forward).normalized()};
  const std::array<Vec3, 2> light_colors = {Vec3(0.66, 0.645, 0.615), Vec3(0.05, 0.055, 0.06)};
  for (std::size_t i = 0; i < directions.size(); ++i) {
    set_vector(program, fmt::format("light_direction[{}]", i), directions[i]);
    set_vector(program, fmt::format("light_color[{}]", i), light_colors[i]);
  }
  // A step off the surface and one towards the light keep a face out of its own shadow.
  const double sample = 2 * shadow_radius / scene_shadow_side;
  set_vector(program, "shadow_steps",
             {1.5 * sample, 1.0 / scene_shadow_side, 1.0 * sample / (2 * shadow_radius)});
  set_vector(program, "fade_middle", fade_middle);
  set_number(program, "fade_reach", drawn.fade_reach);
  set_integer(program, "shadow_map", shadow_unit);
  set_integer(program, "slopes", slopes_unit);
  set_integer(program, "heights", heights_unit);
  set_number(program, "pixel_angle", view.pixel_angle);
  bind(shadow_unit, shadows.texture());
  if (!drawn.detail) return;
  const FaceDetail& detail = *drawn.detail;
  bind(slopes_unit, detail.slopes.get());
  if (detail.relief()) bind(heights_unit, detail.heights.get());
  glUniform2f(glGetUniformLocation(program.get(), "map_size"), float(detail.map_size.x()),
              float(detail.map_size.y()));
  glUniform2f(glGetUniformLocation(program.get(), "face_size"), float(drawn.face_size.x()),
              float(drawn.face_size.y()));
  set_number(program, "texel", detail.grain);
  set_number(program, "deepest", detail.deepest);
}

void SceneRenderer::Parts::draw_mesh(const Drawn& drawn, const Eigen::Affine3d& world_from_body) {
  const Program& program = programs.body;
  set_common(program, drawn);
  const Eigen::Affine3d world_from_face = world_from_body * drawn.body_from_face;
  set_matrix(program, "world_from_mesh", (world_from_body * drawn.body_from_mesh).matrix());
  set_matrix(program, "face_from_world", world_from_face.inverse().matrix());
  const Eigen::Matrix3f turn = world_from_body.linear().cast<float>();
  const Eigen::Matrix3f face = world_from_face.linear().cast<float>();
  glUniformMatrix3fv(glGetUniformLocation(program.get(), "world_from_normal"), 1, GL_FALSE,
                     turn.data());
  glUniformMatrix3fv(glGetUniformLocation(program.get(), "world_from_face"), 1, GL_FALSE,
                     face.data());
  set_integer(program, "detail", !drawn.detail ? 0 : drawn.detail->relief() ? 2 : 1);
  set_number(program, "face_tolerance", drawn.tolerance());
  for (std::size_t part = 0; part < drawn.mesh.parts(); ++part) {
    if (part > 0) set_appearance(program, drawn.looks[part].appearance, drawn.looks[part].grain);
    drawn.mesh.draw_part(part);
  }
}

void SceneRenderer::Parts::draw_relief(const Drawn& drawn, const Eigen::Affine3d& world_from_body) {
  const Program& program = drawn.footprint->whole ? programs.relief : programs.cut_out_relief;
  set_common(program, drawn);
  const Eigen::Affine3d world_from_face = world_from_body * drawn.body_from_face;
  const Eigen::Matrix3f face = world_from_face.linear().cast<float>();
  set_matrix(program, "world_from_box", world_from_face.matrix());
  glUniformMatrix3fv(glGetUniformLocation(program.get(), "world_from_face"), 1, GL_FALSE,
                     face.data());
  set_vector(program, "eye_place", world_from_face.inverse() * view.eye);
  set_vector(program, "light_place", world_from_face.linear().transpose() * light);
  set_integer(program, "goes_on", drawn.footprint->goes_on ? 1 : 0);
  set_integer(program, "footprint", footprint_unit);
  glUniform2f(glGetUniformLocation(program.get(), "margin"), float(drawn.footprint->margin.x()),
              float(drawn.footprint->margin.y()));
  bind(footprint_unit, drawn.footprint->inside.get());
  glEnable(GL_CULL_FACE);
  glCullFace(GL_FRONT);
  glBindVertexArray(no_vertices.get());
  glDrawArrays(GL_TRIANGLES, 0, 36);
  glDisable(GL_CULL_FACE);
}

SceneFrame SceneRenderer::Parts::read() const {
  SceneFrame frame;
  glReadBuffer(GL_COLOR_ATTACHMENT0);
  frame.color = read_picture(camera.width, camera.height, camera.samples);
  glReadBuffer(GL_COLOR_ATTACHMENT1);
  const int samples = camera.samples;
  std::vector<float> row(2 * std::size_t(samples) * std::size_t(camera.width));
  for (int j = 0; j < camera.height; ++j) {
    glReadPixels(0, samples * (camera.height - 1 - j) + samples / 2, samples * camera.width, 1,
                 GL_RG, GL_FLOAT, row.data());
    for (int i = 0; i < camera.width; ++i) {
      const auto at = 2 * static_cast<std::size_t>(samples * i + samples / 2);
      frame.depth.push_back(row[at]);
      frame.mask.push_back(static_cast<std::uint8_t>(std::lround(row[at + 1])));
    }
  }
  return frame;
}

SceneRenderer::SceneRenderer(const Scene& scene) {
  check(scene);
  double reach = (scene.camera.target - scene.camera.eye).norm();
  if (scene.ground) {
    reach += 2 * scene.ground->reach + (scene.ground->middle - scene.camera.eye).norm();
  }
  for (const SceneBody& body : scene.bodies) reach += 2 * bounding_ball(body.mesh).radius;
  offscreen_context();  // before anything of OpenGL
  parts_ = std::make_unique<Parts>(scene, reach);
}

SceneRenderer::~SceneRenderer() = default;
SceneRenderer::SceneRenderer(SceneRenderer&&) noexcept = default;

SceneFrame SceneRenderer::draw(std::span<const ScenePose> poses) {
  Parts& parts = *parts_;
  check_poses(poses, parts.bodies.size());
  parts.draw_shadows(poses);
  parts.draw_background();
  for (std::size_t i = 0; i < parts.bodies.size(); ++i) {
    const Drawn& body = parts.bodies[i];
    const Eigen::Affine3d world = world_from_body(poses[i]);
    parts.draw_mesh(body, world);
    if (body.detail && body.detail->relief()) parts.draw_relief(body, world);
  }
  // The ground last: most of it lies behind bodies, and need not be shaded.
  glEnablei(GL_BLEND, 0);
  glBlendFunc(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA);
  if (parts.ground) {
    const Eigen::Affine3d still = Eigen::Affine3d::Identity();
    const bool relief = parts.ground->detail && parts.ground->detail->relief();
    relief ? parts.draw_relief(*parts.ground, still) : parts.draw_mesh(*parts.ground, still);
  }
  glDisablei(GL_BLEND, 0);
  glActiveTexture(GL_TEXTURE0);
  SceneFrame frame = parts.read();
  check_gl("drawing a scene");
  return frame;
}

}  // namespace carillon::render
