#include "synth/motion/relief_contacts.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

namespace carillon::synth {

using Eigen::Vector2d;
using solvers::SurfaceMap;

namespace {

constexpr double kNothing = std::numeric_limits<double>::infinity();

/// Texels of a rectangle of the face, and what the body's lower side is above each: its height over
/// the face, or infinity where there is no body.
struct Lower {
  int from_u = 0, from_v = 0, columns = 0, rows = 0;
  std::vector<double> heights;

  double& at(int i, int j) { return heights[static_cast<std::size_t>(j * columns + i)]; }
  double at(int i, int j) const { return heights[static_cast<std::size_t>(j * columns + i)]; }
};

Vector2d place_of(const SurfaceMap& relief, const Lower& lower, int i, int j) {
  return {(lower.from_u + i + 0.5) * relief.texel, (lower.from_v + j + 0.5) * relief.texel};
}

/// Texels whose centres lie within [low, high] and on the face.
Lower texels_within(const SurfaceMap& relief, const Vector2d& size, Vector2d low, Vector2d high) {
  low = low.cwiseMax(Vector2d(0, 0));
  high = high.cwiseMin(size);
  Lower lower;
  lower.from_u = static_cast<int>(std::ceil(low.x() / relief.texel - 0.5));
  lower.from_v = static_cast<int>(std::ceil(low.y() / relief.texel - 0.5));
  lower.columns =
      std::max(0, static_cast<int>(std::floor(high.x() / relief.texel - 0.5)) - lower.from_u + 1);
  lower.rows =
      std::max(0, static_cast<int>(std::floor(high.y() / relief.texel - 0.5)) - lower.from_v + 1);
  lower.heights.assign(
      static_cast<std::size_t>(lower.columns) * static_cast<std::size_t>(lower.rows), kNothing);
  return lower;
}

bool on_face(const Vector2d& uv, const Vector2d& size) {
  return uv.x() >= 0 && uv.y() >= 0 && uv.x() <= size.x() && uv.y() <= size.y();
}

/// Distance along the face's normal from relief to body at each texel, in place of the heights.
void subtract_relief(const SurfaceMap& relief, Lower& lower) {
  for (int j = 0; j < lower.rows; ++j) {
    for (int i = 0; i < lower.columns; ++i) {
      double& height = lower.at(i, j);
      if (height < 0) {
        height -= solvers::height_at(relief, place_of(relief, lower, i, j));
      } else {
        height = kNothing;  // above the face, and so above its relief
      }
    }
  }
}

/// The deepest, then those farthest from all that were taken.
std::vector<ReliefContact> spread_out(std::vector<ReliefContact> all) {
  if (all.empty()) return all;
  std::vector<ReliefContact> kept;
  const auto deepest = std::max_element(
      all.begin(), all.end(),
      [](const ReliefContact& a, const ReliefContact& b) { return a.depth < b.depth; });
  kept.push_back(*deepest);
  std::vector<double> distance(all.size(), kNothing);
  while (kept.size() < std::min(kMostReliefContacts, all.size())) {
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

/// A ball's lower side as a height field: value, gradient, curvature.
struct BallSide {
  Vec3 centre;
  double radius;

  double height(const Vector2d& uv) const {
    const double inside = radius * radius - (uv - centre.head<2>()).squaredNorm();
    return inside > 0 ? centre.z() - std::sqrt(inside) : kNothing;
  }
};

/// Least distance near a texel by Newton's method on spline and sphere, within a texel and a half.
Vector2d refine(const SurfaceMap& relief, const Vector2d& size, const BallSide& ball,
                const Vector2d& start) {
  const double reach = 1.5 * relief.texel;
  Vector2d best = start;
  double least = ball.height(start) - solvers::height_at(relief, start);
  Vector2d uv = start;
  for (int step = 0; step < 12; ++step) {
    const solvers::SurfaceDetail detail = solvers::detail_at(relief, uv);
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
      const double distance = height - solvers::height_at(relief, next);
      if (distance >= least) continue;
      better = true;
      least = distance;
      best = uv = next;
    }
    if (!better || move.norm() < 1e-4 * relief.texel) break;
  }
  return best;
}

}  // namespace

std::vector<ReliefContact> ball_on_relief(const SurfaceMap& relief, const Vector2d& size,
                                          const Vec3& centre, double radius) {
  const double low = centre.z() - radius;
  if (!(low < 0)) return {};
  const BallSide ball{centre, radius};
  // The part below the face; a ball whose centre is in the relief touches with its lower half.
  const double reach =
      centre.z() > 0 ? std::sqrt(radius * radius - centre.z() * centre.z()) : 0.999 * radius;
  const Vector2d middle = centre.head<2>(), around(reach, reach);
  Lower lower = texels_within(relief, size, middle - around, middle + around);
  for (int j = 0; j < lower.rows; ++j) {
    for (int i = 0; i < lower.columns; ++i) {
      const Vector2d uv = place_of(relief, lower, i, j);
      if ((uv - middle).squaredNorm() < reach * reach) lower.at(i, j) = ball.height(uv);
    }
  }
  subtract_relief(relief, lower);
  // A minimum between texels may lie a little deeper than its texels.
  const double near = relief.texel * relief.texel / radius;
  std::vector<ReliefContact> found;
  const auto add = [&](const Vector2d& start) {
    const Vector2d uv = refine(relief, size, ball, start);
    const double distance = ball.height(uv) - solvers::height_at(relief, uv);
    if (!(distance < 0)) return;
    for (const ReliefContact& other : found) {
      if ((other.point.head<2>() - uv).norm() < relief.texel) return;
    }
    ReliefContact contact;
    contact.point = {uv.x(), uv.y(), ball.height(uv)};
    contact.normal = solvers::normal_of(solvers::slope_at(relief, uv));
    contact.depth = -distance * contact.normal.z();
    found.push_back(contact);
  };
  if (lower.columns < 1 || lower.rows < 1) {
    if (on_face(middle, size)) add(middle);  // a ball smaller than a texel
    return found;
  }
  for (int j = 0; j < lower.rows; ++j) {
    for (int i = 0; i < lower.columns; ++i) {
      const double here = lower.at(i, j);
      if (!(here < near)) continue;
      bool least = true;
      for (int dj = -1; dj <= 1 && least; ++dj) {
        for (int di = -1; di <= 1 && least; ++di) {
          const int x = i + di, y = j + dj;
          if (x < 0 || y < 0 || x >= lower.columns || y >= lower.rows) continue;
          // Of equal neighbours the first counts.
          const double there = lower.at(x, y);
          const bool earlier = dj < 0 || (dj == 0 && di < 0);
          least = earlier ? here < there : here <= there;
        }
      }
      if (least) add(place_of(relief, lower, i, j));
    }
  }
  return spread_out(std::move(found));
}

namespace {

/// Lowers the heights to those of a triangle, at the texels it covers.
void rasterise(const SurfaceMap& relief, const Vec3& a, const Vec3& b, const Vec3& c,
               Lower& lower) {
  const Vec3 normal = (b - a).cross(c - a);
  if (!(normal.z() < 0)) return;  // looks up, or stands upright: never the lower side
  const auto column = [&](double u) { return u / relief.texel - 0.5 - lower.from_u; };
  const auto row = [&](double v) { return v / relief.texel - 0.5 - lower.from_v; };
  const auto [low_u, high_u] = std::minmax({a.x(), b.x(), c.x()});
  const auto [low_v, high_v] = std::minmax({a.y(), b.y(), c.y()});
  const int i0 = std::max(0, static_cast<int>(std::ceil(column(low_u))));
  const int i1 = std::min(lower.columns - 1, static_cast<int>(std::floor(column(high_u))));
  const int j0 = std::max(0, static_cast<int>(std::ceil(row(low_v))));
  const int j1 = std::min(lower.rows - 1, static_cast<int>(std::floor(row(high_v))));
  const auto side = [](const Vec3& p, const Vec3& q, const Vector2d& uv) {
    return (q.x() - p.x()) * (uv.y() - p.y()) - (q.y() - p.y()) * (uv.x() - p.x());
  };
  for (int j = j0; j <= j1; ++j) {
    for (int i = i0; i <= i1; ++i) {
      const Vector2d uv = place_of(relief, lower, i, j);
      // Seen from above a face that looks down turns clockwise.
      if (side(a, b, uv) > 0 || side(b, c, uv) > 0 || side(c, a, uv) > 0) continue;
      const double height =
          a.z() - (normal.x() * (uv.x() - a.x()) + normal.y() * (uv.y() - a.y())) / normal.z();
      lower.at(i, j) = std::min(lower.at(i, j), height);
    }
  }
}

}  // namespace

std::vector<ReliefContact> hull_on_relief(const SurfaceMap& relief, const Vector2d& size,
                                          std::span<const Vec3> points,
                                          std::span<const std::int32_t> triangles) {
  Vector2d low(kNothing, kNothing), high = -low;
  double lowest = kNothing;
  for (const Vec3& p : points) {
    low = low.cwiseMin(p.head<2>());
    high = high.cwiseMax(p.head<2>());
    lowest = std::min(lowest, p.z());
  }
  if (!(lowest < 0)) return {};
  Lower lower = texels_within(relief, size, low, high);
  for (std::size_t t = 0; t + 2 < triangles.size(); t += 3) {
    rasterise(relief, points[static_cast<std::size_t>(triangles[t])],
              points[static_cast<std::size_t>(triangles[t + 1])],
              points[static_cast<std::size_t>(triangles[t + 2])], lower);
  }
  std::vector<double> heights = lower.heights;
  subtract_relief(relief, lower);
  std::vector<ReliefContact> found;
  const auto add = [&](const Vector2d& uv, double height, double distance) {
    ReliefContact contact;
    contact.point = {uv.x(), uv.y(), height};
    contact.normal = solvers::normal_of(solvers::slope_at(relief, uv));
    contact.depth = -distance * contact.normal.z();
    found.push_back(contact);
  };
  for (int j = 0; j < lower.rows; ++j) {
    for (int i = 0; i < lower.columns; ++i) {
      const double here = lower.at(i, j);
      if (!(here < 0)) continue;
      const auto deeper = [&](int x, int y) {
        return x >= 0 && y >= 0 && x < lower.columns && y < lower.rows && lower.at(x, y) < here;
      };
      // A flat side on a flat top dips in alike all over: all its texels stay candidates.
      if (deeper(i - 1, j) || deeper(i + 1, j) || deeper(i, j - 1) || deeper(i, j + 1)) continue;
      add(place_of(relief, lower, i, j), heights[static_cast<std::size_t>(j * lower.columns + i)],
          here);
    }
  }
  // Corners between texels: they are what dips in first.
  for (const Vec3& p : points) {
    const Vector2d uv = p.head<2>();
    if (!(p.z() < 0) || !on_face(uv, size)) continue;
    const double distance = p.z() - solvers::height_at(relief, uv);
    if (distance < 0) add(uv, p.z(), distance);
  }
  return spread_out(std::move(found));
}

}  // namespace carillon::synth
