#include "render/detail/face_detail.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/error.hpp"

namespace carillon::render {
namespace {

constexpr int max_texels = 8192;   ///< a side
constexpr int fine_texels = 1024;  ///< up to which samples lie half a texel apart

void check(const maps::SurfaceMap& map) {
  const std::size_t count =
      map.width > 0 && map.height > 0 ? std::size_t(map.width) * std::size_t(map.height) : 0;
  const auto full = [&](const std::vector<float>& texels) {
    return texels.size() == count &&
           std::all_of(texels.begin(), texels.end(), [](float x) { return std::isfinite(x); });
  };
  const bool good = map.relief() ? full(map.heights) : full(map.slopes_u) && full(map.slopes_v);
  if (count == 0 || !good || !(map.texel > 0) || std::max(map.width, map.height) > max_texels) {
    throw core::InputError(fmt::format("map {}: cannot be drawn with {} x {} texels of {} m",
                                       map.name, map.width, map.height, map.texel),
                           fmt::format("finite values, and at most {} texels a side", max_texels));
  }
}

Texture upload(GLint internal, GLenum format, int width, int height,
               const std::vector<float>& values, bool repeats, bool with_means) {
  Texture texture;
  glGenTextures(1, texture.put());
  glBindTexture(GL_TEXTURE_2D, texture.get());
  glTexImage2D(GL_TEXTURE_2D, 0, internal, width, height, 0, format, GL_FLOAT, values.data());
  const GLint beyond = repeats ? GL_REPEAT : GL_CLAMP_TO_EDGE;
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, beyond);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, beyond);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER,
                  with_means ? GL_LINEAR_MIPMAP_LINEAR : GL_LINEAR);
  if (with_means) glGenerateMipmap(GL_TEXTURE_2D);
  return texture;
}

}  // namespace

FaceDetail face_detail(const maps::SurfaceMap& map) {
  check(map);
  const int factor = std::max(map.width, map.height) <= fine_texels ? 2 : 1;
  const int width = factor * map.width, height = factor * map.height;
  FaceDetail detail;
  detail.map_size = map.size();
  detail.grain = map.texel / factor;
  std::vector<float> heights, slopes;
  const std::size_t count = std::size_t(width) * std::size_t(height);
  slopes.reserve(2 * count);
  if (map.relief()) heights.reserve(count);
  for (int j = 0; j < height; ++j) {
    for (int i = 0; i < width; ++i) {
      const Eigen::Vector2d uv = Eigen::Vector2d(i + 0.5, j + 0.5) * detail.grain;
      const Eigen::Vector2d slope = maps::slope_at(map, uv);
      slopes.push_back(static_cast<float>(slope.x()));
      slopes.push_back(static_cast<float>(slope.y()));
      if (map.relief()) heights.push_back(static_cast<float>(maps::height_at(map, uv)));
    }
  }
  detail.slopes = upload(GL_RG32F, GL_RG, width, height, slopes, map.repeats, true);
  if (map.relief()) {
    const double depth = -*std::min_element(heights.begin(), heights.end());
    // A slab that even the rounding of a flat relief stays within.
    detail.deepest = 1.001 * std::max(depth, 0.0) + 1e-3 * map.texel;
    detail.heights = upload(GL_R32F, GL_RED, width, height, heights, map.repeats, false);
  }
  return detail;
}

Eigen::Affine3d body_from_face(const maps::TexturedFace& face) {
  Eigen::Affine3d body = Eigen::Affine3d::Identity();
  body.linear() << face.u, face.v, face.normal();
  body.translation() = face.origin;
  return body;
}

}  // namespace carillon::render
