#pragma once

#include <Eigen/Core>
#include <functional>
#include <vector>

namespace carillon::solvers::families {

/// A point of the middle line of a turned wall, in the (radius, height) half-plane.
struct ProfilePoint {
  Eigen::Vector2d at;       ///< (radius, height) [m]
  Eigen::Vector2d tangent;  ///< direction of growing arc length, unit length
};

/// A smooth piece of a profile, u in [0, 1].
struct ProfileSegment {
  std::function<ProfilePoint(double u)> point;
  double length;    ///< [m]
  double turning;   ///< angle the tangent sweeps over [rad]
  double tightest;  ///< smallest radius of curvature [m], infinite for a line
};

/// Middle line of a wall from the axis outward: segments that meet with a common tangent. Its
/// coordinate s runs over [0, length()]; within a segment it is u times the segment's length.
class Profile {
 public:
  Profile& line(const Eigen::Vector2d& a, const Eigen::Vector2d& b);
  /// Quarter of an ellipse about `centre`, from angle `from` to `to` [rad].
  Profile& arc(const Eigen::Vector2d& centre, const Eigen::Vector2d& semi_axes, double from,
               double to);
  /// Radius as a cubic of height that leaves `a` and reaches `b` upright (vase), or, with
  /// `flare`, leaves `a` upright and gathers slope with the square of the way (lip of a bell).
  Profile& swing(const Eigen::Vector2d& a, const Eigen::Vector2d& b, bool flare = false);
  /// Straight lines through points; each inner corner is rounded by an arc that takes `fraction` of
  /// the shorter of its two lines.
  Profile& rounded(const std::vector<Eigen::Vector2d>& points, double fraction);

  ProfilePoint point(double s) const;
  double length() const;
  double tightest() const;
  double largest_radius() const;
  const std::vector<ProfileSegment>& segments() const { return segments_; }

 private:
  void add(std::function<ProfilePoint(double)> point);
  std::vector<ProfileSegment> segments_;
};

}  // namespace carillon::solvers::families
