#include "synth/motion/detail/relief_contacts.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace carillon::synth::motion {

using Eigen::Vector2d;
using render::maps::SurfaceMap;

namespace {

constexpr double nothing = std::numeric_limits<double>::infinity();

bool on_face(const Vector2d& uv, const Vector2d& size) {
  return uv.x() >= 0 && uv.y() >= 0 && uv.x() <= size.x() && uv.y() <= size.y();
}

}  // namespace

std::vector<ReliefContact> spread_out(std::vector<ReliefContact> all) {
  if (all.empty()) return all;
  std::vector<ReliefContact> kept;
  const auto deepest = std::max_element(
      all.begin(), all.end(),
      [](const ReliefContact& a, const ReliefContact& b) { return a.depth < b.depth; });
  kept.push_back(*deepest);
  std::vector<double> distance(all.size(), nothing);
  while (kept.size() < std::min(max_relief_contacts, all.size())) {
    std::size_t farthest = 0;
    for (std::size_t k = 0; k < all.size(); ++k) {
      distance[k] = std::min(distance[k], (all[k].point - kept.back().point).squaredNorm());
      if (distance[k] > distance[farthest]) farthest = k;
    }
    if (!(distance[farthest] > 0)) break;
    kept.push_back(all[farthest]);
  }
  return kept;
}

namespace {

/// A ball's lower side as a height field: value, gradient, curvature.
struct BallSide {
  Vec3 centre;
  double radius;

  double height(const Vector2d& uv) const {
    const double inside = radius * radius - (uv - centre.head<2>()).squaredNorm();
    return inside > 0 ? centre.z() - std::sqrt(inside) : nothing;
  }
};

/// Least distance near a texel by Newton's method on spline and sphere, within a texel and a half.
Vector2d refine(const SurfaceMap& relief, const Vector2d& size, const BallSide& ball,
                const Vector2d& start) {
  const double reach = 1.5 * relief.texel;
  Vector2d best = start;
  double minimum = ball.height(start) - render::maps::height_at(relief, start);
  Vector2d uv = start;
  for (int step = 0; step < 12; ++step) {
    const render::maps::SurfaceDetail detail = render::maps::detail_at(relief, uv);
    const Vector2d out = uv - ball.centre.head<2>();
    const double root = std::sqrt(ball.radius * ball.radius - out.squaredNorm());
    const Vector2d gradient = out / root - detail.slope;
    Eigen::Matrix2d hessian = Eigen::Matrix2d::Identity() / root +
                              out * out.transpose() / (root * root * root) - detail.curvature;
    // Where the distance curves down the step follows the slope instead.
    const double trace = hessian.trace(), determinant = hessian.determinant();
    if (!(determinant > 0 && trace > 0)) hessian = Eigen::Matrix2d::Identity() / root;
    Vector2d move = -hessian.inverse() * gradient;
    if (move.norm() > 0.5 * relief.texel) move *= 0.5 * relief.texel / move.norm();
    bool better = false;
    for (int half = 0; half < 6 && !better; ++half, move *= 0.5) {
      const Vector2d next = uv + move;
      if ((next - start).norm() > reach || !on_face(next, size)) continue;
      const double height = ball.height(next);
      if (!std::isfinite(height)) continue;
      const double distance = height - render::maps::height_at(relief, next);
      if (distance >= minimum) continue;
      better = true;
      minimum = distance;
      best = uv = next;
    }
    if (!better || move.norm() < 1e-4 * relief.texel) break;
  }
  return best;
}

}  // namespace

std::vector<ReliefContact> ball_on_relief(const ReliefPeaks& peaks, const Vector2d& size,
                                          const Vec3& centre, double radius) {
  const SurfaceMap& relief = peaks.relief();
  const double low = centre.z() - radius;
  if (!(low < 0)) return {};
  const BallSide ball{centre, radius};
  // The part below the face; a ball whose centre is in the relief touches with its lower half.
  const double reach =
      centre.z() > 0 ? std::sqrt(radius * radius - centre.z() * centre.z()) : 0.999 * radius;
  const Vector2d middle = centre.head<2>(), around(reach, reach);
  const Texels texels = texels_within(relief, size, middle - around, middle + around);
  // A minimum between texels may lie a little deeper than its texels.
  const double near = relief.texel * relief.texel / radius;
  std::vector<ReliefContact> found;
  const auto add = [&](const Vector2d& start) {
    const Vector2d uv = refine(relief, size, ball, start);
    const double distance = ball.height(uv) - render::maps::height_at(relief, uv);
    if (!(distance < 0)) return;
    for (const ReliefContact& other : found) {
      if ((other.point.head<2>() - uv).norm() < relief.texel) return;
    }
    ReliefContact contact;
    contact.point = {uv.x(), uv.y(), ball.height(uv)};
    contact.normal = render::maps::normal_of(render::maps::slope_at(relief, uv));
    contact.depth = -distance * contact.normal.z();
    found.push_back(contact);
  };
  if (texels.empty()) {
    if (on_face(middle, size)) add(middle);  // a ball smaller than a texel
    return found;
  }
  const auto distance_at = [&](int u, int v) {
    const Vector2d uv = centre_of(relief, u, v);
    if (!texels.have(u, v) || !((uv - middle).squaredNorm() < reach * reach)) return nothing;
    const double height = ball.height(uv);
    // Above the face it is above its relief.
    return height < 0 ? height - peaks.height(u, v) : nothing;
  };
  constexpr int width = ReliefPeaks::side + 2;
  std::array<double, static_cast<std::size_t>(width) * width> distances;  // a block's, and around
  for (const ReliefPeaks::Block& block : peaks.blocks(texels)) {
    const Texels& own = block.texels;
    const Vector2d first = centre_of(relief, own.from_u, own.from_v);
    const Vector2d last = centre_of(relief, own.to_u - 1, own.to_v - 1);
    if (!(ball.height(middle.cwiseMax(first).cwiseMin(last)) - block.highest < near)) continue;
    const auto at = [&](int u, int v) -> double& {
      return distances[static_cast<std::size_t>((v - own.from_v + 1) * width + u - own.from_u + 1)];
    };
    for (int v = own.from_v - 1; v <= own.to_v; ++v) {
      for (int u = own.from_u - 1; u <= own.to_u; ++u) at(u, v) = distance_at(u, v);
    }
    for (int v = own.from_v; v < own.to_v; ++v) {
      for (int u = own.from_u; u < own.to_u; ++u) {
        const double here = at(u, v);
        if (!(here < near)) continue;
        // Of equal neighbours the first counts.
        const bool minimum = here < at(u - 1, v - 1) && here < at(u, v - 1) &&
                             here < at(u + 1, v - 1) && here < at(u - 1, v) &&
                             here <= at(u + 1, v) && here <= at(u - 1, v + 1) &&
                             here <= at(u, v + 1) && here <= at(u + 1, v + 1);
        if (minimum) add(centre_of(relief, u, v));
      }
    }
  }
  return spread_out(std::move(found));
}

}  // namespace carillon::synth::motion
