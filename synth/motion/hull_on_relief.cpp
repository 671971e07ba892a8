#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include "synth/motion/detail/relief_contacts.hpp"

namespace carillon::synth::motion {

using Eigen::Vector2d;
using render::maps::SurfaceMap;

namespace {

constexpr double nothing = std::numeric_limits<double>::infinity();
constexpr double alike_limit = 1e-6;  ///< of a texel: depths that do not differ

/// A triangle that looks down, as a height field.
struct LowerTriangle {
  std::array<Vec3, 3> corners;
  Vector2d low, high;  ///< of its footprint
  Vector2d slope;      ///< of its plane
  double lowest;       ///< of its corners

  double plane(const Vector2d& uv) const {
    return corners[0].z() + slope.dot(uv - corners[0].head<2>());
  }
  /// Height above a place; infinite beside the triangle.
  double height(const Vector2d& uv) const {
    const auto side = [&](const Vec3& p, const Vec3& q) {
      return (q.x() - p.x()) * (uv.y() - p.y()) - (q.y() - p.y()) * (uv.x() - p.x());
    };
    // Seen from above a face that looks down turns clockwise.
    for (std::size_t k = 0; k < 3; ++k) {
      if (side(corners[k], corners[(k + 1) % 3]) > 0) return nothing;
    }
    return plane(uv);
  }
};

std::vector<LowerTriangle> lower_side(std::span<const Vec3> points,
                                      std::span<const solvers::mesh::Triangle> triangles) {
  std::vector<LowerTriangle> result;
  for (const solvers::mesh::Triangle& t : triangles) {
    LowerTriangle triangle;
    for (std::size_t k = 0; k < 3; ++k) {
      triangle.corners[k] = points[static_cast<std::size_t>(t[k])];
    }
    const auto& [a, b, c] = triangle.corners;
    const Vec3 normal = (b - a).cross(c - a);
    if (!(normal.z() < 0)) continue;  // looks up, or stands upright
    triangle.slope = -normal.head<2>() / normal.z();
    triangle.lowest = std::min({a.z(), b.z(), c.z()});
    if (!(triangle.lowest < 0)) continue;  // above the face, and so above its relief
    triangle.low = a.head<2>().cwiseMin(b.head<2>()).cwiseMin(c.head<2>());
    triangle.high = a.head<2>().cwiseMax(b.head<2>()).cwiseMax(c.head<2>());
    result.push_back(triangle);
  }
  return result;
}

/// Looks for where a hull dips into a relief.
class HullSearch {
 public:
  HullSearch(const ReliefPeaks& peaks, const Texels& texels, std::vector<LowerTriangle> triangles)
      : peaks_(peaks),
        relief_(peaks.relief()),
        texels_(texels),
        triangles_(std::move(triangles)),
        blocks_(peaks.blocks(texels)),
        above_(blocks_.size()),
        bounds_(blocks_.size(), nothing),
        seen_(static_cast<std::size_t>(texels.to_u - texels.from_u) *
                  static_cast<std::size_t>(texels.to_v - texels.from_v),
              false) {
    while (across_ < blocks_.size() &&
           blocks_[across_].texels.from_v == blocks_.front().texels.from_v) {
      ++across_;
    }
    for (std::size_t t = 0; t < triangles_.size(); ++t) bound(t);
  }

  /// Texels where the distance is negative and least among their neighbours.
  std::vector<ReliefContact> dips() {
    std::vector<std::optional<Dip>> candidates(blocks_.size());
    double minimum = 0;
    for (std::size_t b = 0; b < blocks_.size(); ++b) {
      if (above_[b].empty()) continue;
      const Dip peak = at(b, blocks_[b].peak_u, blocks_[b].peak_v);
      candidates[b] = peak.distance < 0 ? peak : deepest(b);
      minimum = std::min(minimum, candidates[b]->distance);
    }
    std::vector<ReliefContact> found;
    for (std::size_t b = 0; b < blocks_.size(); ++b) {
      if (!candidates[b] || !(candidates[b]->distance < 0)) continue;
      // Somewhere in it may be the deepest of all; what lies flat is as deep everywhere.
      if (bounds_[b] < minimum - alike_limit * relief_.texel) {
        candidates[b] = deepest(b);
        minimum = std::min(minimum, candidates[b]->distance);
      }
      if (const auto dip = descend(*candidates[b])) found.push_back(contact(*dip));
    }
    return found;
  }

 private:
  struct Dip {
    std::size_t block;
    int u, v;
    double height, distance;
  };

  /// Blocks that a triangle may dip into, and by how much at the most.
  void bound(std::size_t t) {
    const LowerTriangle& triangle = triangles_[t];
    const auto texel = [&](double place) { return place / relief_.texel - 0.5; };
    const auto reached = [&](std::size_t first, std::size_t stride, std::size_t count, auto from,
                             auto to, double low, double high) {
      std::size_t begin = 0, end = count;
      while (begin < end && blocks_[first + begin * stride].texels.*to - 1 < texel(low)) ++begin;
      while (end > begin && blocks_[first + (end - 1) * stride].texels.*from > texel(high)) --end;
      return std::pair(begin, end);
    };
    const auto [left, right] =
        reached(0, 1, across_, &Texels::from_u, &Texels::to_u, triangle.low.x(), triangle.high.x());
    const auto [bottom, top] = reached(0, across_, blocks_.size() / across_, &Texels::from_v,
                                       &Texels::to_v, triangle.low.y(), triangle.high.y());
    for (std::size_t row = bottom; row < top; ++row) {
      for (std::size_t b = row * across_ + left; b < row * across_ + right; ++b) {
        const Texels& own = blocks_[b].texels;
        const Vector2d first = centre_of(relief_, own.from_u, own.from_v);
        const Vector2d last = centre_of(relief_, own.to_u - 1, own.to_v - 1);
        const Vector2d middle = (first + last) / 2, half = (last - first) / 2;
        const double plane = triangle.plane(middle) - triangle.slope.cwiseAbs().dot(half);
        const double distance = std::max(triangle.lowest, plane) - blocks_[b].highest;
        if (!(distance < 0)) continue;
        above_[b].push_back(t);
        bounds_[b] = std::min(bounds_[b], distance);
      }
    }
  }

  Dip at(std::size_t block, int u, int v) const {
    Dip dip{block, u, v, nothing, nothing};
    if (!texels_.have(u, v)) return dip;
    const Vector2d uv = centre_of(relief_, u, v);
    for (const std::size_t t : above_[block]) {
      dip.height = std::min(dip.height, triangles_[t].height(uv));
    }
    if (dip.height < 0) dip.distance = dip.height - peaks_.height(u, v);
    return dip;
  }

  Dip deepest(std::size_t b) const {
    const Texels& own = blocks_[b].texels;
    Dip best{b, own.from_u, own.from_v, nothing, nothing};
    for (int v = own.from_v; v < own.to_v; ++v) {
      for (int u = own.from_u; u < own.to_u; ++u) {
        const Dip dip = at(b, u, v);
        if (dip.distance < best.distance) best = dip;
      }
    }
    return best;
  }

  /// Texel by texel to the least distance around; none where an earlier way has been.
  std::optional<Dip> descend(Dip dip) {
    while (true) {
      const auto index = static_cast<std::size_t>(dip.v - texels_.from_v) *
                             static_cast<std::size_t>(texels_.to_u - texels_.from_u) +
                         static_cast<std::size_t>(dip.u - texels_.from_u);
      if (seen_[index]) return {};
      seen_[index] = true;
      Dip next = dip;
      for (int dv = -1; dv <= 1; ++dv) {
        for (int du = -1; du <= 1; ++du) {
          if ((du == 0 && dv == 0) || !texels_.have(dip.u + du, dip.v + dv)) continue;
          const Dip there = at(block_of(dip, dip.u + du, dip.v + dv), dip.u + du, dip.v + dv);
          if (there.distance < next.distance) next = there;
        }
      }
      if (!(next.distance < dip.distance)) return dip;
      dip = next;
    }
  }

  /// Of a texel in the dip's block or beside it.
  std::size_t block_of(const Dip& dip, int u, int v) const {
    const Texels& own = blocks_[dip.block].texels;
    std::size_t block = dip.block;
    if (u < own.from_u) block -= 1;
    if (u >= own.to_u) block += 1;
    if (v < own.from_v) block -= across_;
    if (v >= own.to_v) block += across_;
    return block;
  }

  ReliefContact contact(const Dip& dip) const {
    const Vector2d uv = centre_of(relief_, dip.u, dip.v);
    ReliefContact contact;
    contact.point = {uv.x(), uv.y(), dip.height};
    contact.normal = render::maps::normal_of(render::maps::slope_at(relief_, uv));
    contact.depth = -dip.distance * contact.normal.z();
    return contact;
  }

  const ReliefPeaks& peaks_;
  const SurfaceMap& relief_;
  Texels texels_;
  std::vector<LowerTriangle> triangles_;
  std::vector<ReliefPeaks::Block> blocks_;
  std::vector<std::vector<std::size_t>> above_;  ///< triangles that may dip into each
  std::vector<double> bounds_;                   ///< least distance that there may be in each
  std::size_t across_ = 0;                       ///< blocks of a row
  std::vector<bool> seen_;                       ///< texels that a way has been at
};

}  // namespace

std::vector<ReliefContact> hull_on_relief(const ReliefPeaks& peaks, const Vector2d& size,
                                          std::span<const Vec3> points,
                                          std::span<const solvers::mesh::Triangle> triangles) {
  const SurfaceMap& relief = peaks.relief();
  std::vector<LowerTriangle> lower = lower_side(points, triangles);
  if (lower.empty()) return {};
  Vector2d low = lower.front().low, high = lower.front().high;
  for (const LowerTriangle& triangle : lower) {
    low = low.cwiseMin(triangle.low);
    high = high.cwiseMax(triangle.high);
  }
  std::vector<ReliefContact> found;
  const Texels texels = texels_within(relief, size, low, high);
  if (!texels.empty()) found = HullSearch(peaks, texels, std::move(lower)).dips();
  // Corners between texels: they are what dips in first.
  for (const Vec3& p : points) {
    if (!(p.z() < 0) || p.x() < 0 || p.y() < 0 || p.x() > size.x() || p.y() > size.y()) continue;
    const double distance = p.z() - render::maps::height_at(relief, p.head<2>());
    if (!(distance < 0)) continue;
    ReliefContact contact;
    contact.point = p;
    contact.normal = render::maps::normal_of(render::maps::slope_at(relief, p.head<2>()));
    contact.depth = -distance * contact.normal.z();
    found.push_back(contact);
  }
  return spread_out(std::move(found));
}

}  // namespace carillon::synth::motion
