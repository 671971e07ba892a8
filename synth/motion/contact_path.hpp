#pragma once

#include <Eigen/Core>
#include <vector>

#include "solvers/mesh/surface_mesh.hpp"

namespace carillon::synth::motion {

/// The way of a contact over a body between the steps of a motion: the uniform cubic B-spline whose
/// control points they are, with two continuous derivatives (no steps, no hold). What moves evenly
/// it follows exactly, at the ends too.
class ContactPath {
 public:
  /// @param points  one for each step, at least one [m]
  /// @param step    [s]
  ContactPath(std::vector<Vec3> points, double step);

  struct Place {
    Vec3 point, velocity, acceleration;
  };
  /// @param time  since the first point's [s], clamped to the steps
  Place at(double time) const;
  /// No smaller than any speed within a step [m/s].
  double fastest(std::size_t step) const;

 private:
  std::vector<Vec3> control_;  ///< the points, one more before and two after
  double step_;
};

}  // namespace carillon::synth::motion
