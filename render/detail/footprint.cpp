#include "render/detail/footprint.hpp"

#include <algorithm>
#include <vector>

namespace carillon::render {
namespace {

constexpr int picture_side = 1024;
constexpr double margin_fraction = 0.02;  ///< part of the rectangle's sides

constexpr const char* vertex = R"(#version 330 core
layout(location = 0) in vec3 position;
uniform mat4 face_from_mesh;
uniform vec3 margin;  // and nothing
uniform vec3 size;
out float height;
void main() {
  vec3 place = (face_from_mesh * vec4(position, 1.0)).xyz;
  height = place.z;
  gl_Position = vec4((place.xy + margin.xy) / (size.xy + 2.0 * margin.xy) * 2.0 - 1.0, 0.0, 1.0);
}
)";
constexpr const char* fragment = R"(#version 330 core
in float height;
uniform float tolerance;
out vec4 inside;
void main() {
  if (abs(height) > tolerance) discard;
  inside = vec4(1.0);
}
)";

}  // namespace

FootprintPainter::FootprintPainter() : program_(make_program(vertex, fragment)) {
  glGenFramebuffers(1, target_.put());
}

Footprint FootprintPainter::paint(const DrawableMesh& mesh, const Eigen::Affine3d& face_from_mesh,
                                  const Eigen::Vector2d& size, double tolerance) const {
  Footprint footprint;
  footprint.margin = margin_fraction * size;
  footprint.inside = make_target(GL_R8, GL_RED, GL_UNSIGNED_BYTE, picture_side, picture_side);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
  glBindFramebuffer(GL_FRAMEBUFFER, target_.get());
  glFramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D,
                         footprint.inside.get(), 0);
  glViewport(0, 0, picture_side, picture_side);
  glDisable(GL_DEPTH_TEST);
  glClear(GL_COLOR_BUFFER_BIT);
  glUseProgram(program_.get());
  set_matrix(program_, "face_from_mesh", face_from_mesh.matrix());
  set_vector(program_, "margin", {footprint.margin.x(), footprint.margin.y(), 0});
  set_vector(program_, "size", {size.x(), size.y(), 0});
  set_number(program_, "tolerance", tolerance);
  mesh.draw();

  std::vector<std::uint8_t> seen(std::size_t(picture_side) * picture_side);
  glReadPixels(0, 0, picture_side, picture_side, GL_RED, GL_UNSIGNED_BYTE, seen.data());
  // A texel on either side of the rectangle's edges says nothing.
  const double low = margin_fraction / (1 + 2 * margin_fraction) * picture_side,
               high = picture_side - low;
  for (int row = 0; row < picture_side; ++row) {
    for (int column = 0; column < picture_side; ++column) {
      const double near = std::min(row, column) + 0.5, far = std::max(row, column) + 0.5;
      const bool face = seen[std::size_t(row) * picture_side + std::size_t(column)] > 0;
      if (near > low + 1 && far < high - 1) footprint.whole = footprint.whole && face;
      if (near < low - 1 || far > high + 1) footprint.goes_on = footprint.goes_on || face;
    }
  }
  return footprint;
}

}  // namespace carillon::render
