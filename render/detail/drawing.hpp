#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <string>

#include "core/image.hpp"
#include "render/detail/offscreen.hpp"
#include "render/frame.hpp"
#include "render/shading_mesh.hpp"

namespace carillon::render {

/// Uniforms of the program in use.
void set_matrix(const Program& program, const char* name, const Eigen::Matrix4d& matrix);
void set_vector(const Program& program, const std::string& name, const Vec3& value);
void set_number(const Program& program, const char* name, double value);
void set_integer(const Program& program, const char* name, int value);

/// Where a body's grain lies in its mesh's coordinates, those of its ball.
struct GrainPlace {
  Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();  ///< rows: along the grain and across
  Vec3 offset = Vec3::Zero();                          ///< of the body's middle from the origin
  double scale = 1;        ///< of the pattern to the body's ball, whose radius is 1
  double plank_width = 0;  ///< of a floor's boards, in the pattern's units; 0: one piece
};
/// Along the body's longest axis: the first of those that are as long within a hundredth. The piece
/// says where from the pith it was cut.
/// @param radius  of the body's ball [m]
GrainPlace grain_place(const ShadingMesh& mesh, double radius, const Appearance& appearance);
/// Uniforms of grain_code.hpp and those of shading_code.hpp that are the surface's, and of the
/// reflectance, which is the factor of a mesh's own colours where it has them.
void set_appearance(const Program& program, const Appearance& appearance, const GrainPlace& grain);
/// @throws InputError  colours that are not as many as the mesh's vertices, looks of faces that are
///                     not as many as these, or a number of none
void check_looks(const Appearance& appearance, const FaceLooks& faces,
                 const solvers::mesh::SurfaceMesh& mesh);

/// Texture of one level without filtering, where something is drawn to.
Texture make_target(GLint internal, GLenum format, GLenum type, int width, int height);

/// A mesh's buffers on the side of OpenGL.
class DrawableMesh {
 public:
  /// @param colours   at the vertices that `mesh` was made of; empty: all are (1, 1, 1)
  /// @param of_faces  part of each triangle, from 0; empty: all are one
  explicit DrawableMesh(const ShadingMesh& mesh, std::span<const Vec3> colours = {},
                        std::span<const std::int32_t> of_faces = {});
  void draw() const { draw(0, ends_.back()); }
  std::size_t parts() const { return ends_.size(); }
  void draw_part(std::size_t part) const { draw(part == 0 ? 0 : ends_[part - 1], ends_[part]); }

 private:
  void draw(GLsizei begin, GLsizei end) const;

  std::vector<GLsizei> ends_;  ///< of each part, behind its last index
  VertexArray array_;
  Buffer positions_;
  Buffer normals_;
  Buffer colours_;
  Buffer indices_;
};

/// Depth seen from a light, read with comparison, or as it is.
class ShadowMap {
 public:
  explicit ShadowMap(int side);
  /// What is drawn next goes into it, with nothing there before.
  void begin();
  GLuint texture() const { return texture_.get(); }
  GLuint plain_sampler() const { return plain_.get(); }

 private:
  int side_;
  Texture texture_;
  Sampler plain_;
  Framebuffer target_;
};

/// Highest and lowest heights seen from straight above (light_code.hpp).
class ColumnMap {
 public:
  explicit ColumnMap(int side);
  /// What is drawn next goes into it, with nothing there before.
  void begin();
  GLuint texture() const { return texture_.get(); }

 private:
  int side_;
  Texture depths_;
  Texture texture_;
  Framebuffer target_;
};

/// 0 to 1 of linear light as sRGB's byte.
std::uint8_t srgb(double linear);

/// Means over each pixel's samples x samples in linear light, then sRGB, of the framebuffer's
/// chosen colours; rows from top to bottom.
core::Image read_picture(int width, int height, int samples);

}  // namespace carillon::render
