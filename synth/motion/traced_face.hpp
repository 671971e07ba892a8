#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "solvers/textures/surface_map.hpp"

namespace carillon::synth {

using solvers::Vec3;

/// A textured face as a ball-shaped tip traces it, at any width of blur: what the tip's patch of
/// contact, or the time between two samples, averages over.
class TracedFace {
 public:
  /// @param radius  of the tip [m], >= 0
  /// @throws InputError  a radius that is negative or no number, a face without map or axes
  TracedFace(const solvers::TexturedFace& face, double radius);

  /// Where a point of the body lies on the face; none where it lies beside it, or farther from it
  /// than the map is deep and 2 mm.
  std::optional<Eigen::Vector2d> place(const Vec3& point) const;

  /// Detail of the traced surface, averaged along both axes: a wave of length L is sinc(width /
  /// L)^4 as deep, so that curvatures of finer waves fall, too. Between the windows of 2^k texels
  /// in straight lines; a width below a texel is none.
  solvers::SurfaceDetail detail(const Eigen::Vector2d& uv, double width) const;

  const solvers::TexturedFace& face() const { return face_; }

 private:
  solvers::TexturedFace face_;               ///< its map as it came
  std::vector<solvers::SurfaceMap> levels_;  ///< level k: blurred over 2^k texels
  double deepest_ = 0;
};

}  // namespace carillon::synth
