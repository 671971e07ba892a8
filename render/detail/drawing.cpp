#include "render/detail/drawing.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "core/error.hpp"
#include "core/random.hpp"

namespace carillon::render {

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

void set_integer(const Program& program, const char* name, int value) {
  glUniform1i(glGetUniformLocation(program.get(), name), value);
}

GrainPlace grain_place(const ShadingMesh& mesh, double radius, const Appearance& appearance) {
  Eigen::Vector3f low = Eigen::Vector3f::Constant(2), high = Eigen::Vector3f::Constant(-2);
  for (std::size_t i = 0; i < mesh.positions.size(); i += 3) {
    const Eigen::Map<const Eigen::Vector3f> position(mesh.positions.data() + i);
    low = low.cwiseMin(position);
    high = high.cwiseMax(position);
  }
  const Vec3 sides = (high - low).cast<double>();
  Eigen::Index along = 0;
  while (sides[along] < 0.99 * sides.maxCoeff()) ++along;
  GrainPlace place;
  for (Eigen::Index row = 0; row < 3; ++row) place.axes.row(row) = Vec3::Unit((along + row) % 3);
  core::RandomStream random(appearance.piece, 0, "grain");
  const double slice = random.uniform(-32, 32), angle = random.uniform(0, 2 * std::numbers::pi);
  const double from_pith = random.uniform(0.3, 1.2);
  // A unit is 30 mm, so that rings are 3 mm apart; small bodies show some, too.
  place.scale = std::max(0.6, radius / 0.03);
  place.offset = {slice, from_pith * std::cos(angle), from_pith * std::sin(angle)};
  return place;
}

void set_appearance(const Program& program, const Appearance& appearance, const GrainPlace& grain) {
  const bool painted = !appearance.colours.empty();
  set_vector(program, "reflectance", painted ? Vec3::Ones() : appearance.color);
  set_number(program, "roughness", appearance.roughness);
  set_number(program, "metallic", appearance.metallic);
  set_number(program, "transmission", appearance.transmission);
  set_number(program, "coat", appearance.coat);
  set_integer(program, "grain_kind", painted ? 0 : static_cast<int>(appearance.grain));
  set_integer(program, "grain_layers", appearance.grain == looks::Grain::speckled ? 3 : 4);
  set_number(program, "grain_contrast", appearance.grain_contrast);
  set_vector(program, "grain_offset", grain.offset);
  set_number(program, "grain_scale", grain.scale);
  set_number(program, "plank_width", grain.plank_width);
  const Eigen::Matrix3f axes = grain.axes.cast<float>();  // stored by columns, as OpenGL has them
  glUniformMatrix3fv(glGetUniformLocation(program.get(), "grain_axes"), 1, GL_FALSE, axes.data());
}

void check_looks(const Appearance& appearance, const FaceLooks& faces,
                 const solvers::mesh::SurfaceMesh& mesh) {
  looks::check(appearance);
  for (const Appearance& other : faces.others) looks::check(other);
  if (!appearance.colours.empty() && appearance.colours.size() != mesh.vertices.size()) {
    throw core::InputError(fmt::format("appearance: {} colours of {} vertices",
                                       appearance.colours.size(), mesh.vertices.size()));
  }
  if (!faces.of_faces.empty() && faces.of_faces.size() != mesh.triangles.size()) {
    throw core::InputError(fmt::format("appearance: looks of {} faces, and the mesh has {}",
                                       faces.of_faces.size(), mesh.triangles.size()));
  }
  for (const std::int32_t part : faces.of_faces) {
    if (part >= 0 && static_cast<std::size_t>(part) <= faces.others.size()) continue;
    throw core::InputError(
        fmt::format("appearance: a face has the look {} of {}", part, faces.others.size() + 1));
  }
}

Texture make_target(GLint internal, GLenum format, GLenum type, int width, int height) {
  Texture texture;
  glGenTextures(1, texture.put());
  glBindTexture(GL_TEXTURE_2D, texture.get());
  glTexImage2D(GL_TEXTURE_2D, 0, internal, width, height, 0, format, type, nullptr);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
  return texture;
}

namespace {

constexpr GLuint colour_location = 2;

void upload(Buffer& buffer, const std::vector<float>& values, GLuint location) {
  glGenBuffers(1, buffer.put());
  glBindBuffer(GL_ARRAY_BUFFER, buffer.get());
  glBufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(values.size() * sizeof(float)),
               values.data(), GL_STATIC_DRAW);
  glVertexAttribPointer(location, 3, GL_FLOAT, GL_FALSE, 0, nullptr);
  glEnableVertexAttribArray(location);
}

}  // namespace

DrawableMesh::DrawableMesh(const ShadingMesh& mesh, std::span<const Vec3> colours,
                           std::span<const std::int32_t> of_faces) {
  glGenVertexArrays(1, array_.put());
  glBindVertexArray(array_.get());
  upload(positions_, mesh.positions, 0);
  upload(normals_, mesh.normals, 1);
  if (!colours.empty()) {
    std::vector<float> values;
    for (const std::int32_t source : mesh.sources)
      for (const double value : colours[static_cast<std::size_t>(source)])
        values.push_back(static_cast<float>(value));
    upload(colours_, values, colour_location);
  }
  // One part after the other.
  std::vector<std::uint32_t> indices;
  const std::int32_t last =
      of_faces.empty() ? 0 : *std::max_element(of_faces.begin(), of_faces.end());
  for (std::int32_t part = 0; part <= last; ++part) {
    for (std::size_t corner = 0; corner < mesh.indices.size(); ++corner) {
      if (of_faces.empty() || of_faces[corner / 3] == part) indices.push_back(mesh.indices[corner]);
    }
    ends_.push_back(static_cast<GLsizei>(indices.size()));
  }
  glGenBuffers(1, indices_.put());
  glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, indices_.get());
  glBufferData(GL_ELEMENT_ARRAY_BUFFER,
               static_cast<GLsizeiptr>(indices.size() * sizeof(std::uint32_t)), indices.data(),
               GL_STATIC_DRAW);
}

void DrawableMesh::draw(GLsizei begin, GLsizei end) const {
  glBindVertexArray(array_.get());
  glVertexAttrib3f(colour_location, 1, 1, 1);  // where the mesh has none of its own
  glDrawElements(
      GL_TRIANGLES, end - begin, GL_UNSIGNED_INT,
      reinterpret_cast<const void*>(static_cast<std::size_t>(begin) * sizeof(std::uint32_t)));
}

ShadowMap::ShadowMap(int side)
    : side_(side),
      texture_(make_target(GL_DEPTH_COMPONENT32F, GL_DEPTH_COMPONENT, GL_FLOAT, side, side)) {
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_COMPARE_MODE, GL_COMPARE_REF_TO_TEXTURE);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_COMPARE_FUNC, GL_LEQUAL);
  glGenSamplers(1, plain_.put());
  glSamplerParameteri(plain_.get(), GL_TEXTURE_MIN_FILTER, GL_NEAREST);
  glSamplerParameteri(plain_.get(), GL_TEXTURE_MAG_FILTER, GL_NEAREST);
  glSamplerParameteri(plain_.get(), GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
  glSamplerParameteri(plain_.get(), GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
  glSamplerParameteri(plain_.get(), GL_TEXTURE_COMPARE_MODE, GL_NONE);
  glGenFramebuffers(1, target_.put());
  glBindFramebuffer(GL_FRAMEBUFFER, target_.get());
  glFramebufferTexture2D(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_TEXTURE_2D, texture_.get(), 0);
  glDrawBuffer(GL_NONE);
  glReadBuffer(GL_NONE);
}

void ShadowMap::begin() {
  glBindTexture(GL_TEXTURE_2D, 0);
  glBindFramebuffer(GL_FRAMEBUFFER, target_.get());
  glViewport(0, 0, side_, side_);
  glEnable(GL_DEPTH_TEST);
  glClear(GL_DEPTH_BUFFER_BIT);
}

ColumnMap::ColumnMap(int side)
    : side_(side),
      depths_(make_target(GL_DEPTH_COMPONENT32F, GL_DEPTH_COMPONENT, GL_FLOAT, side, side)),
      texture_(make_target(GL_RG32F, GL_RG, GL_FLOAT, side, side)) {
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
  glGenFramebuffers(1, target_.put());
  glBindFramebuffer(GL_FRAMEBUFFER, target_.get());
  glFramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, texture_.get(), 0);
  glFramebufferTexture2D(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_TEXTURE_2D, depths_.get(), 0);
}

void ColumnMap::begin() {
  glBindFramebuffer(GL_FRAMEBUFFER, target_.get());
  glViewport(0, 0, side_, side_);
  glEnable(GL_DEPTH_TEST);
  glClear(GL_DEPTH_BUFFER_BIT);
  const std::array<float, 4> nothing = {-1e30F, -1e30F, 0, 0};
  glClearBufferfv(GL_COLOR, 0, nothing.data());
}

std::uint8_t srgb(double linear) {
  const double x = std::clamp(linear, 0.0, 1.0);
  const double encoded = x <= 0.0031308 ? 12.92 * x : 1.055 * std::pow(x, 1 / 2.4) - 0.055;
  return static_cast<std::uint8_t>(std::lround(255 * encoded));
}

core::Image read_picture(int width, int height, int samples) {
  const int fine_width = samples * width;
  std::vector<float> rows(static_cast<std::size_t>(fine_width) * static_cast<std::size_t>(samples) *
                          4);
  core::Image image;
  image.width = width;
  image.height = height;
  image.channels = 3;
  image.pixels.resize(static_cast<std::size_t>(width) * static_cast<std::size_t>(height) * 3);
  auto* pixel = image.pixels.data();
  for (int row = 0; row < height; ++row) {
    glReadPixels(0, samples * (height - 1 - row), fine_width, samples, GL_RGBA, GL_FLOAT,
                 rows.data());
    for (int column = 0; column < width; ++column) {
      for (int channel = 0; channel < 3; ++channel) {
        double sum = 0;
        for (int j = 0; j < samples; ++j) {
          for (int i = 0; i < samples; ++i) {
            sum += rows[static_cast<std::size_t>((j * fine_width + samples * column + i) * 4 +
                                                 channel)];
          }
        }
        *pixel++ = srgb(sum / (samples * samples));
      }
    }
  }
  return image;
}

}  // namespace carillon::render
