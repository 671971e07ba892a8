#include "synth/motion/traced_face.hpp"

#include <algorithm>
#include <cmath>

#include "core/error.hpp"

namespace carillon::synth::motion {

namespace {

constexpr double beside = 2e-3;  ///< of a face a contact still is on it [m]
constexpr int max_levels = 8;

/// Mean of each texel with those `stride` to both sides, (1 2 1) / 4, twice along both axes: k such
/// steps with strides 1, 2, ... make two triangles of 2^k texels, one after the other.
render::maps::SurfaceMap blurred(const render::maps::SurfaceMap& map, int stride) {
  render::maps::SurfaceMap result = map;
  const auto index = [&](int i, int count) {
    return map.repeats ? ((i % count) + count) % count : std::clamp(i, 0, count - 1);
  };
  const auto pass = [&](bool columns) {
    const std::vector<float> from = result.heights;
    const auto at = [&](int i, int j) {
      return static_cast<double>(
          from[static_cast<std::size_t>(j) * static_cast<std::size_t>(map.width) +
               static_cast<std::size_t>(i)]);
    };
    std::size_t texel = 0;
    for (int j = 0; j < map.height; ++j) {
      for (int i = 0; i < map.width; ++i, ++texel) {
        const double middle = at(i, j);
        const double low =
            columns ? at(i, index(j - stride, map.height)) : at(index(i - stride, map.width), j);
        const double high =
            columns ? at(i, index(j + stride, map.height)) : at(index(i + stride, map.width), j);
        // By differences: what is flat stays flat to the last bit.
        result.heights[texel] = static_cast<float>(middle + ((low - middle) + (high - middle)) / 4);
      }
    }
  };
  for (const bool columns : {false, false, true, true}) pass(columns);
  return result;
}

}  // namespace

std::size_t TracedMaps::Made::texels() const {
  return traced->levels.size() * traced->levels.front()->heights.size();
}

std::shared_ptr<TracedMap> TracedMaps::made(const SharedMap& map, double radius) {
  if (map == nullptr) throw core::InputError("textured face: it has no map");
  for (const Made& one : made_) {
    if (one.map == map && one.radius == radius) return one.traced;
  }
  auto traced = std::make_shared<TracedMap>();
  traced->levels.push_back(
      std::make_shared<const render::maps::SurfaceMap>(render::maps::traced_map(*map, radius)));
  for (const float height : traced->levels.front()->heights) {
    traced->deepest = std::max(traced->deepest, -static_cast<double>(height));
  }
  made_.push_back({map, radius, traced});
  return traced;
}

SharedMap TracedMaps::finest(const SharedMap& map, double radius) {
  return made(map, radius)->levels.front();
}

std::shared_ptr<const TracedMap> TracedMaps::of(const SharedMap& map, double radius) {
  const std::shared_ptr<TracedMap> traced = made(map, radius);
  std::vector<SharedMap>& levels = traced->levels;
  const int maximum = std::max(levels.front()->width, levels.front()->height);
  for (auto k = static_cast<int>(levels.size()); k <= max_levels && (1 << k) <= maximum; ++k) {
    levels.push_back(
        std::make_shared<const render::maps::SurfaceMap>(blurred(*levels.back(), 1 << (k - 1))));
  }
  drop_oldest();
  return traced;
}

void TracedMaps::drop_oldest() {
  std::size_t texels = 0;
  for (const Made& one : made_) texels += one.texels();
  while (texels > max_traced_texels && made_.size() > 1) {
    texels -= made_.front().texels();
    made_.pop_front();
  }
}

TracedFace::TracedFace(const render::maps::TexturedFace& face,
                       std::shared_ptr<const TracedMap> traced)
    : face_(face), traced_(std::move(traced)) {
  const double skew =
      std::abs(face.u.dot(face.v)) + std::abs(face.u.norm() - 1) + std::abs(face.v.norm() - 1);
  if (!(skew < 1e-6) || !face.origin.allFinite() || !(face.size.minCoeff() > 0)) {
    throw core::InputError(
        "textured face: its axes must be unit vectors at right angles, its size "
        "positive");
  }
}

std::optional<Eigen::Vector2d> TracedFace::place(const Vec3& point) const {
  const Vec3 from = point - face_.origin;
  const Eigen::Vector2d uv(from.dot(face_.u), from.dot(face_.v));
  const double above = from.dot(face_.normal());
  const bool inside = uv.minCoeff() >= 0 && (face_.size - uv).minCoeff() >= 0;
  if (!inside || !(above <= beside && above >= -traced_->deepest - beside)) return {};
  return uv;
}

render::maps::SurfaceDetail TracedFace::detail(const Eigen::Vector2d& uv, double width) const {
  const std::vector<SharedMap>& levels = traced_->levels;
  const double texels = width / levels.front()->texel;
  const double level = texels > 1 ? std::log2(texels) : 0;
  const auto below = std::min(static_cast<std::size_t>(level), levels.size() - 1);
  render::maps::SurfaceDetail detail = render::maps::detail_at(*levels[below], uv);
  const double fraction = level - static_cast<double>(below);
  if (fraction <= 0 || below + 1 >= levels.size()) return detail;
  const render::maps::SurfaceDetail above = render::maps::detail_at(*levels[below + 1], uv);
  detail.height += fraction * (above.height - detail.height);
  detail.slope += fraction * (above.slope - detail.slope);
  detail.curvature += fraction * (above.curvature - detail.curvature);
  return detail;
}

}  // namespace carillon::synth::motion
