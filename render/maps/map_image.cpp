#include "render/maps/map_image.hpp"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "core/error.hpp"
#include "core/image_samples.hpp"

namespace carillon::render::maps {
namespace {

using core::ImageSamples;

void check(const std::string& name, const MapImage& image, const ImageSamples& samples) {
  if (!(image.width > 0) || !std::isfinite(image.width)) {
    throw core::InputError(
        fmt::format("{}: a map's width must be positive, not {} m", name, image.width));
  }
  if (!(image.depth >= 0) || !std::isfinite(image.depth)) {
    throw core::InputError(
        fmt::format("{}: a relief's depth must be positive, not {} m", name, image.depth),
        "0 makes it a normal map");
  }
  if (samples.channels < 3) {
    throw core::InputError(
        fmt::format("{}: the picture is grey, but a map's normals are colours", name),
        "save it as RGB, or as RGBA for a relief");
  }
  if (image.depth > 0 && samples.channels < 4) {
    throw core::InputError(
        fmt::format("{}: a depth of {} m is given, but the picture has no alpha channel", name,
                    image.depth),
        "save it as RGBA with the depths in alpha, or leave the depth out for a normal map");
  }
  if (samples.width < 4 || samples.height < 4) {
    throw core::InputError(fmt::format("{}: a map of {} x {} texels is too small", name,
                                       samples.width, samples.height),
                           "at least 4 x 4");
  }
}

/// Walks the texels of a map, lower left first, along the rows of its picture, bottom row first.
template <class Visit>
void for_each_texel(const ImageSamples& samples, Visit visit) {
  std::size_t texel = 0;
  for (int row = samples.height - 1; row >= 0; --row) {
    for (int column = 0; column < samples.width; ++column, ++texel) {
      visit(texel,
            (std::size_t(row) * std::size_t(samples.width) + std::size_t(column)) *
                std::size_t(samples.channels),
            column, row);
    }
  }
}

/// Fills in the slopes of RGB. Of a relief, whose slopes are those of its depths, colours that are
/// no normals become no numbers; of a normal map they are an error.
void read_normals(const std::string& name, const ImageSamples& samples, bool green_down,
                  bool of_relief, SurfaceMap& map) {
  const double half = samples.bits == 16 ? 32768 : 128;
  map.slopes_u.resize(std::size_t(map.width) * std::size_t(map.height));
  map.slopes_v.resize(map.slopes_u.size());
  for_each_texel(samples, [&](std::size_t texel, std::size_t at, int column, int row) {
    const Vec3 normal =
        Vec3(samples.values[at], samples.values[at + 1], samples.values[at + 2]) / half -
        Vec3::Ones();
    if (!(normal.z() > 0) && !of_relief) {
      throw core::InputError(
          fmt::format("{}: the normal of pixel ({}, {}), counted from the upper left, points into "
                      "the surface: blue is {}, no more than half of {}",
                      name, column, row, samples.values[at + 2], 2 * half - 1),
          "is it a normal map in the surface's own axes, mostly light blue?");
    }
    const double up = normal.z() > 0 ? normal.z() : std::numeric_limits<double>::quiet_NaN();
    map.slopes_u[texel] = static_cast<float>(-normal.x() / up);
    map.slopes_v[texel] = static_cast<float>((green_down ? 1 : -1) * normal.y() / up);
  });
}

/// Says so when a relief's colours are not its depths' normals.
void compare(const std::string& name, const SurfaceMap& colors, const SurfaceMap& depths) {
  constexpr double tolerance = 10 * std::numbers::pi / 180;
  std::size_t wrong = 0;
  for (std::size_t i = 0; i < colors.slopes_u.size(); ++i) {
    const Vec3 a = normal_of({colors.slopes_u[i], colors.slopes_v[i]});
    const Vec3 b = normal_of({depths.slopes_u[i], depths.slopes_v[i]});
    if (!(a.dot(b) >= std::cos(tolerance))) ++wrong;
  }
  if (wrong > colors.slopes_u.size() / 20) {
    spdlog::warn(
        "{}: normals of {:.0f} % of the texels lie more than 10 degrees from those of "
        "the depths; the depths count (is the depth or the width another?)",
        name, 100.0 * static_cast<double>(wrong) / static_cast<double>(colors.slopes_u.size()));
  }
}

}  // namespace

SurfaceMap read_map(const std::filesystem::path& path, const MapImage& image) {
  const ImageSamples samples = core::read_png_samples(path);
  const std::string name = path.string();
  check(name, image, samples);
  SurfaceMap map;
  map.name = path.stem().string();
  map.width = samples.width;
  map.height = samples.height;
  map.texel = image.width / samples.width;
  map.repeats = image.repeats;
  if (image.depth == 0) {
    read_normals(name, samples, image.green_down, false, map);
    return map;
  }
  const double full = samples.bits == 16 ? 65535 : 255;
  map.heights.resize(std::size_t(map.width) * std::size_t(map.height));
  for_each_texel(samples, [&](std::size_t texel, std::size_t at, int, int) {
    map.heights[texel] = static_cast<float>(-image.depth * samples.values[at + 3] / full);
  });
  SurfaceMap colors = map;
  colors.heights.clear();
  read_normals(name, samples, image.green_down, true, colors);
  compare(name, colors, normal_map_of(map));
  return map;
}

MapImage write_map(const std::filesystem::path& path, const SurfaceMap& map) {
  MapImage image{map.width * map.texel, 0, map.repeats, false};
  ImageSamples samples{map.width, map.height, map.relief() ? 4 : 3, 16, {}};
  samples.values.resize(std::size_t(map.width) * std::size_t(map.height) *
                        std::size_t(samples.channels));
  const SurfaceMap normals = normal_map_of(map);
  if (map.relief()) {
    image.depth = -*std::min_element(map.heights.begin(), map.heights.end());
    if (!(image.depth > 0)) image.depth = map.texel;  // a flat relief still is one
  }
  for_each_texel(samples, [&](std::size_t texel, std::size_t at, int, int) {
    // 32,767 for a whole one, so that upright fits; slopes are ratios and stay.
    const Vec3 normal = normal_of({normals.slopes_u[texel], normals.slopes_v[texel]});
    for (int axis = 0; axis < 3; ++axis) {
      const long value = std::lround(32768 + 32767 * normal[axis]);
      samples.values[at + std::size_t(axis)] =
          static_cast<std::uint16_t>(axis < 2 ? value : std::max(value, 32769L));
    }
    if (map.relief()) {
      const double cut = std::clamp(-map.heights[texel] / image.depth, 0.0, 1.0);
      samples.values[at + 3] = static_cast<std::uint16_t>(std::lround(65535 * cut));
    }
  });
  core::write_png_samples(path, samples);
  return image;
}

}  // namespace carillon::render::maps
