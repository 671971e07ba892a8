#include "render/scene_frame.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <initializer_list>
#include <limits>

#include "core/error.hpp"
#include "core/numbers.hpp"
#include "render/detail/glass_code.hpp"
#include "render/detail/grain_code.hpp"
#include "render/detail/light_code.hpp"
#include "render/detail/scene_checks.hpp"
#include "render/detail/scene_parts.hpp"
#include "render/detail/scene_shaders.hpp"
#include "render/detail/shading_code.hpp"
#include "render/detail/studio.hpp"

namespace carillon::render {
namespace {

constexpr int shadow_side = 2048;
constexpr int columns_side = 512;
constexpr int all_shadow_taps = 54;      ///< of a pixel, shared by its samples
constexpr int smallest_shadow_taps = 4;  ///< of a sample
constexpr int largest_shadow_taps = 20;
constexpr double fade_from_camera = 7;  ///< no ground beyond so many distances of camera and target
using core::infinity;

/// Units that textures are bound to.
constexpr int shadow_unit = 0, slopes_unit = 1, heights_unit = 2, footprint_unit = 3,
              shadow_depths_unit = 4, columns_unit = 5, back_unit = 6, behind_color_unit = 7,
              behind_places_unit = 8;

void bind(int unit, GLuint texture) {
  glActiveTexture(static_cast<GLenum>(GL_TEXTURE0 + unit));
  glBindTexture(GL_TEXTURE_2D, texture);
}

std::string lit(const char* definitions, const char* more, const char* fragment) {
  return std::string(glsl_version) + definitions + shading + light_code + grain_code +
         scene_common + more + fragment;
}

/// What is drawn through clear bodies: their back faces, and all that is not clear.
struct Behind {
  Texture backs, back_depths, color, places;
  Framebuffer target;
};

/// Programs of all scenes; compiling them takes longer than a frame.
struct ScenePrograms {
  OffscreenContext& context = offscreen_context();
  Program shadow = make_program(scene_shadow_vertex, scene_shadow_fragment);
  Program background = make_program(background_vertex, background_fragment);
  Program body = make_program(scene_vertex, lit("", "", scene_fragment));
  Program clear = make_program(scene_vertex, lit("#define CLEAR\n", glass_code, scene_fragment));
  Program backs = make_program(scene_vertex, back_fragment);
  Program columns = make_program(scene_vertex, columns_fragment);
  Program relief = make_program(relief_vertex, lit("", "", relief_fragment));
  Program cut_out_relief =
      make_program(relief_vertex, lit("#define CUT_OUT\n", "", relief_fragment));
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
  double reach = 0;  ///< of all there is, from the camera [m]
  Vec3 light;
  double light_radius;
  Vec3 floor_color = Vec3::Constant(0.24);  ///< where there is no ground to say it
  Vec3 fade_middle = Vec3::Zero();
  SceneView view;
  Studio studio;
  std::vector<Drawn> bodies;
  std::optional<Drawn> ground;
  ShadowMap shadows{shadow_side};
  ColumnMap columns{columns_side};
  Texture colors, places, depths;
  Framebuffer target;
  std::optional<Behind> behind;  ///< of scenes with clear bodies
  VertexArray no_vertices;
  Eigen::Matrix4d light_from_world;
  double shadow_radius = 1, shadow_search = 1;
  Vec3 columns_place = Vec3::Zero();
  double columns_middle = 0, columns_height = 1;  ///< of what they tell apart, from its middle
  double cover_distance = 1;

  explicit Parts(const Scene& scene) : light_radius(scene.light_radius) {
    for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
      bodies.push_back(make_drawn(scene.bodies[i], static_cast<int>(i) + 1, programs.footprints));
    }
    if (scene.ground) {
      ground = make_drawn(*scene.ground, programs.footprints);
      fade_middle = scene.ground->middle;
      floor_color = scene.ground->appearance.color;
    }
    glGenVertexArrays(1, no_vertices.put());
    look_from(scene.camera, scene.light);
    check_gl("setting up a scene");
  }

  void look_from(const SceneCamera& from, const Vec3& key) {
    const bool same_size = colors.get() != 0 && from.width == camera.width &&
                           from.height == camera.height && from.samples == camera.samples;
    camera = from;
    light = key.normalized();
    studio = make_studio(light, light_radius, floor_color);
    reach = (camera.target - camera.eye).norm();
    if (ground) reach += 2 * ground->ball.radius + (fade_middle - camera.eye).norm();
    for (const Drawn& body : bodies) reach += 2 * body.ball.radius;
    view = scene_view(camera, reach);
    if (!same_size) make_targets();
  }

  void make_targets();
  bool clear(const Drawn& drawn) const { return behind && drawn.transmission() > 0; }
  void draw_shadows(std::span<const ScenePose> poses);
  void draw_columns(std::span<const ScenePose> poses);
  void draw_background();
  void draw_backs(std::span<const ScenePose> poses);
  void set_place(const Program& program, const Drawn& drawn,
                 const Eigen::Affine3d& world_from_body);
  void set_common(const Program& program, const Drawn& drawn);
  void draw_mesh(const Drawn& drawn, const Eigen::Affine3d& world_from_body);
  void draw_relief(const Drawn& drawn, const Eigen::Affine3d& world_from_body);
  SceneFrame read() const;
};

void SceneRenderer::Parts::make_targets() {
  const int width = camera.samples * camera.width, height = camera.samples * camera.height;
  const auto framebuffer = [&](Framebuffer& target, std::initializer_list<GLuint> textures,
                               GLuint depth) {
    glGenFramebuffers(1, target.put());
    glBindFramebuffer(GL_FRAMEBUFFER, target.get());
    GLenum attachment = GL_COLOR_ATTACHMENT0;
    for (const GLuint texture : textures)
      glFramebufferTexture2D(GL_FRAMEBUFFER, attachment++, GL_TEXTURE_2D, texture, 0);
    glFramebufferTexture2D(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_TEXTURE_2D, depth, 0);
    if (glCheckFramebufferStatus(GL_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE) {
      throw core::Error(fmt::format("OpenGL cannot draw {} x {} samples", width, height));
    }
  };
  const auto depth_target = [&] {
    return make_target(GL_DEPTH_COMPONENT32F, GL_DEPTH_COMPONENT, GL_FLOAT, width, height);
  };
  colors = make_target(GL_RGBA16F, GL_RGBA, GL_FLOAT, width, height);
  places = make_target(GL_RG32F, GL_RG, GL_FLOAT, width, height);
  depths = depth_target();
  framebuffer(target, {colors.get(), places.get()}, depths.get());
  behind.reset();
  if (std::none_of(bodies.begin(), bodies.end(),
                   [](const Drawn& body) { return body.transmission() > 0; })) {
    return;
  }
  behind.emplace();
  behind->backs = make_target(GL_RGBA32F, GL_RGBA, GL_FLOAT, width, height);
  behind->back_depths = depth_target();
  behind->color = make_target(GL_RGBA16F, GL_RGBA, GL_FLOAT, width, height);
  behind->places = make_target(GL_RG32F, GL_RG, GL_FLOAT, width, height);
  framebuffer(behind->target, {behind->backs.get()}, behind->back_depths.get());
}

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
  // The lamp's cone from the lowest place to the highest, within what the map can tell apart.
  const double low = std::min(box.low.z(), ground ? fade_middle.z() : infinity);
  const double way =
      any && ground ? (box.high.z() - low) / std::max(light.z(), 0.1) : 2 * shadow_radius;
  shadow_search = std::tan(light_radius) * std::min(1.0, way / (2 * shadow_radius));
  // The columns' square, about the same bodies; what shades one is within the size of most.
  const double side = 2 * shadow_radius;
  columns_middle = middle.z();
  columns_height = any ? std::max(box.high.z() - box.low.z(), shadow_radius) : shadow_radius;
  columns_place = {middle.x() - side / 2, middle.y() - side / 2, side};
  std::vector<double> sizes;
  for (const Drawn& body : bodies) sizes.push_back(body.ball.radius);
  std::sort(sizes.begin(), sizes.end());
  cover_distance = std::min(sizes.empty() ? shadow_radius : 1.2 * sizes[(sizes.size() - 1) / 2],
                            0.5 * shadow_radius);
  const Vec3 sideways = light.unitOrthogonal();
  light_from_world = Eigen::Matrix4d::Identity();
  light_from_world.block<1, 3>(0, 0) = sideways.transpose() / shadow_radius;
  light_from_world.block<1, 3>(1, 0) = light.cross(sideways).transpose() / shadow_radius;
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
    set_number(programs.shadow, "let_through", 0.6 * body.transmission());
    bodies[i].mesh.draw();
  }
  glDisable(GL_DEPTH_CLAMP);
}

void SceneRenderer::Parts::draw_columns(std::span<const ScenePose> poses) {
  columns.begin();
  glEnable(GL_DEPTH_CLAMP);
  glUseProgram(programs.columns.get());
  Eigen::Matrix4d from_above = Eigen::Matrix4d::Zero();
  from_above.diagonal() << 2 / columns_place.z(), 2 / columns_place.z(), -1 / columns_height, 1;
  from_above(2, 3) = columns_middle / columns_height;
  from_above.block<2, 1>(0, 3) =
      -2 * columns_place.head<2>() / columns_place.z() - Eigen::Vector2d::Ones();
  set_matrix(programs.columns, "clip_from_world", from_above);
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const Eigen::Affine3d world = world_from_body(poses[i]);
    set_place(programs.columns, bodies[i], world);
    set_number(programs.columns, "middle_height", (world * bodies[i].ball.centre).z());
    bodies[i].mesh.draw();
  }
  glDisable(GL_DEPTH_CLAMP);
}

/// What is not clear is drawn, and kept; then the back faces of what is.
void SceneRenderer::Parts::draw_backs(std::span<const ScenePose> poses) {
  const int width = camera.samples * camera.width, height = camera.samples * camera.height;
  glBindFramebuffer(GL_FRAMEBUFFER, target.get());
  const auto copy = [&](GLenum attachment, const Texture& texture, int unit) {
    glReadBuffer(attachment);
    bind(unit, texture.get());
    glCopyTexSubImage2D(GL_TEXTURE_2D, 0, 0, 0, 0, 0, width, height);
  };
  copy(GL_COLOR_ATTACHMENT0, behind->color, behind_color_unit);
  copy(GL_COLOR_ATTACHMENT1, behind->places, behind_places_unit);
  glBindFramebuffer(GL_FRAMEBUFFER, behind->target.get());
  glClear(GL_DEPTH_BUFFER_BIT);
  const std::array<float, 4> nothing = {0, 0, 0, 0};
  glClearBufferfv(GL_COLOR, 0, nothing.data());
  glEnable(GL_CULL_FACE);
  glCullFace(GL_FRONT);
  glUseProgram(programs.backs.get());
  set_matrix(programs.backs, "clip_from_world", view.clip_from_world);
  set_vector(programs.backs, "eye", view.eye);
  set_vector(programs.backs, "forward", view.forward);
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    if (!clear(bodies[i])) continue;
    set_place(programs.backs, bodies[i], world_from_body(poses[i]));
    bodies[i].mesh.draw();
  }
  glDisable(GL_CULL_FACE);
  glBindFramebuffer(GL_FRAMEBUFFER, target.get());
  bind(back_unit, behind->backs.get());
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
  set_studio(program, studio);
  set_number(program, "lamp", std::tan(light_radius));
  set_number(program, "shadow_extent", 2 * shadow_radius);
  set_number(program, "shadow_search", shadow_search);
  set_number(program, "shadow_texel", 1.0 / shadow_side);
  set_integer(program, "samples", camera.samples);
  set_integer(program, "shadow_taps",
              std::clamp(all_shadow_taps / (camera.samples * camera.samples), smallest_shadow_taps,
                         largest_shadow_taps));
  set_vector(program, "columns_place", columns_place);
  set_number(program, "cover_distance", cover_distance);
  // Numbers of loops are uniforms so that these are not unrolled, which takes llvmpipe seconds.
  set_integer(program, "cover_directions", 3);
  set_integer(program, "cover_rings", 2);
  set_integer(program, "steps_in_glass", 4);
  set_integer(program, "steps_behind", 5);
  set_number(program, "body_size", 2 * drawn.ball.radius);
  set_vector(program, "fade_middle", fade_middle);
  set_number(program, "fade_distance",
             std::min(drawn.fade_distance, fade_from_camera * (camera.target - camera.eye).norm()));
  set_integer(program, "shadow_map", shadow_unit);
  set_integer(program, "slopes", slopes_unit);
  set_integer(program, "heights", heights_unit);
  set_number(program, "pixel_angle", view.pixel_angle);
  set_integer(program, "shadow_depths", shadow_depths_unit);
  set_integer(program, "columns", columns_unit);
  set_integer(program, "back_faces", back_unit);
  set_integer(program, "behind_color", behind_color_unit);
  set_integer(program, "behind_places", behind_places_unit);
  bind(shadow_unit, shadows.texture());
  bind(shadow_depths_unit, shadows.texture());
  glBindSampler(shadow_depths_unit, shadows.plain_sampler());
  bind(columns_unit, columns.texture());
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

void SceneRenderer::Parts::set_place(const Program& program, const Drawn& drawn,
                                     const Eigen::Affine3d& world_from_body) {
  set_matrix(program, "world_from_mesh", (world_from_body * drawn.body_from_mesh).matrix());
  set_matrix(program, "face_from_world",
             (world_from_body * drawn.body_from_face).inverse().matrix());
  const Eigen::Matrix3f turn = world_from_body.linear().cast<float>();
  glUniformMatrix3fv(glGetUniformLocation(program.get(), "world_from_normal"), 1, GL_FALSE,
                     turn.data());
}

void SceneRenderer::Parts::draw_mesh(const Drawn& drawn, const Eigen::Affine3d& world_from_body) {
  const Program& program = clear(drawn) ? programs.clear : programs.body;
  set_common(program, drawn);
  set_place(program, drawn, world_from_body);
  const Eigen::Matrix3f face = (world_from_body * drawn.body_from_face).linear().cast<float>();
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
  offscreen_context();  // before anything of OpenGL
  parts_ = std::make_unique<Parts>(scene);
}

void SceneRenderer::look_from(const SceneCamera& camera, const Vec3& light) {
  check(camera, light);
  parts_->look_from(camera, light);
}

SceneRenderer::~SceneRenderer() = default;
SceneRenderer::SceneRenderer(SceneRenderer&&) noexcept = default;

SceneFrame SceneRenderer::draw(std::span<const ScenePose> poses) {
  Parts& parts = *parts_;
  check_poses(poses, parts.bodies.size());
  parts.draw_shadows(poses);
  parts.draw_columns(poses);
  parts.draw_background();
  const auto draw_body = [&](std::size_t i) {
    const Drawn& body = parts.bodies[i];
    const Eigen::Affine3d world = world_from_body(poses[i]);
    parts.draw_mesh(body, world);
    if (body.detail && body.detail->relief()) parts.draw_relief(body, world);
  };
  for (std::size_t i = 0; i < parts.bodies.size(); ++i)
    if (!parts.clear(parts.bodies[i])) draw_body(i);
  // The ground last: most of it lies behind bodies, and need not be shaded.
  glEnablei(GL_BLEND, 0);
  glBlendFunc(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA);
  if (parts.ground) {
    const Eigen::Affine3d still = Eigen::Affine3d::Identity();
    const bool relief = parts.ground->detail && parts.ground->detail->relief();
    relief ? parts.draw_relief(*parts.ground, still) : parts.draw_mesh(*parts.ground, still);
  }
  glDisablei(GL_BLEND, 0);
  if (parts.behind) {
    parts.draw_backs(poses);
    for (std::size_t i = 0; i < parts.bodies.size(); ++i)
      if (parts.clear(parts.bodies[i])) draw_body(i);
  }
  glBindSampler(shadow_depths_unit, 0);
  glActiveTexture(GL_TEXTURE0);
  SceneFrame frame = parts.read();
  check_gl("drawing a scene");
  return frame;
}

}  // namespace carillon::render
