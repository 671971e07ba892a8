#include <Eigen/Geometry>
#include <algorithm>
#include <limits>

#include "core/error.hpp"
#include "synth/modal/ring_down.hpp"
#include "synth/surface/outer_surface.hpp"

namespace carillon::synth::modal {

namespace {

/// Barycentric coordinates of the point of a triangle nearest to p, by the region of the triangle
/// that p faces (Ericson 2005, section 5.1.5).
Eigen::Vector3d nearest_in_triangle(const Vec3& p, const std::array<Vec3, 3>& corners) {
  const auto& [a, b, c] = corners;
  const Vec3 ab = b - a;
  const Vec3 ac = c - a;
  const Vec3 ap = p - a;
  const double d1 = ab.dot(ap);
  const double d2 = ac.dot(ap);
  if (d1 <= 0 && d2 <= 0) return {1, 0, 0};
  const Vec3 bp = p - b;
  const double d3 = ab.dot(bp);
  const double d4 = ac.dot(bp);
  if (d3 >= 0 && d4 <= d3) return {0, 1, 0};
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) {
    const double v = d1 > d3 ? d1 / (d1 - d3) : 0;
    return {1 - v, v, 0};
  }
  const Vec3 cp = p - c;
  const double d5 = ab.dot(cp);
  const double d6 = ac.dot(cp);
  if (d6 >= 0 && d5 <= d6) return {0, 0, 1};
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) {
    const double w = d2 > d6 ? d2 / (d2 - d6) : 0;
    return {1 - w, 0, w};
  }
  const double va = d3 * d6 - d5 * d4;
  const double along = (d4 - d3) + (d5 - d6);
  if (va <= 0 && d4 >= d3 && d5 >= d6) {
    const double w = along > 0 ? (d4 - d3) / along : 0;
    return {0, 1 - w, w};
  }
  const double sum = va + vb + vc;
  return {va / sum, vb / sum, vc / sum};
}

}  // namespace

SurfaceSampler::SurfaceSampler(const solvers::modes::ModeSurface& surface)
    : pieces_(surface::outer_pieces(surface)) {
  double total = 0;
  for (const surface::SurfaceTriangle& piece : pieces_) {
    total += surface::area_vector(piece).norm();
    cumulative_.push_back(total);
  }
  if (!(total > 0)) {
    throw core::InputError("the object has no outer surface: no faces, or all of them look inward");
  }
}

double SurfaceSampler::area() const {
  return cumulative_.back();
}

SurfacePoint SurfaceSampler::sample(core::RandomStream& random) const {
  const double where = random.uniform() * area();
  const auto found = std::upper_bound(cumulative_.begin(), cumulative_.end(), where);
  const auto index =
      std::min(static_cast<std::size_t>(found - cumulative_.begin()), pieces_.size() - 1);
  // Uniform in the triangle: the unit square folded along its diagonal.
  double first = random.uniform();
  double second = random.uniform();
  if (first + second > 1) {
    first = 1 - first;
    second = 1 - second;
  }
  const surface::SurfaceTriangle& piece = pieces_[index];
  return {piece.face, (1 - first - second) * piece.corners[0] + first * piece.corners[1] +
                          second * piece.corners[2]};
}

SurfacePoint SurfaceSampler::nearest(const Vec3& position) const {
  if (!position.allFinite()) throw core::InputError("strike position is not finite");
  SurfacePoint best;
  double best_distance = std::numeric_limits<double>::infinity();
  for (const surface::SurfaceTriangle& piece : pieces_) {
    const Eigen::Vector3d weights = nearest_in_triangle(position, piece.positions);
    Vec3 point = Vec3::Constant(0);
    Eigen::Vector3d barycentric = Eigen::Vector3d::Zero();
    for (std::size_t k = 0; k < 3; ++k) {
      const double weight = weights[static_cast<Eigen::Index>(k)];
      point += weight * piece.positions[k];
      barycentric += weight * piece.corners[k];
    }
    const double distance = (position - point).squaredNorm();
    // Written so that a degenerate piece, whose distance is not a number, never wins.
    if (distance < best_distance) {
      best_distance = distance;
      best = {piece.face, barycentric};
    }
  }
  return best;
}

}  // namespace carillon::synth::modal
