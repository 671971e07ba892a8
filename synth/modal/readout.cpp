#include "synth/modal/readout.hpp"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "core/error.hpp"
#include "synth/modal/ring_down.hpp"
#include "synth/surface/outer_surface.hpp"

namespace carillon::synth::modal {

Readout point_velocity(const solvers::modes::Modes& modes, const SurfacePoint& point) {
  Readout readout;
  const Vec3 normal = frame_at(modes.surface, point).normal;
  readout.velocity = (shapes_at(modes, point) * normal).transpose();
  readout.delays = {0.0};
  return readout;
}

Readout monopole(const solvers::modes::Modes& modes, std::span<const Listener> listeners) {
  const surface::OuterHull hull = surface::outer_hull(modes.surface);
  const Eigen::VectorXd volume_velocity =
      modes.shapes.at_nodes().cast<double>() * hull.volume_weights;
  Readout readout;
  readout.unit = "Pa";
  readout.acceleration.resize(static_cast<Eigen::Index>(listeners.size()),
                              static_cast<Eigen::Index>(modes.size()));
  for (Eigen::Index row = 0; row < readout.acceleration.rows(); ++row) {
    const Vec3& position = listeners[static_cast<std::size_t>(row)].position;
    const double distance = (position - hull.centroid).norm();
    if (!(distance > hull.radius) || !std::isfinite(distance)) {
      throw core::InputError(
          fmt::format("listener {} is {:.4g} m from the object's centre, which reaches {:.4g} m",
                      row, distance, hull.radius),
          "move the listener away from the object; the far field holds some radii away");
    }
    readout.acceleration.row(row) =
        (air_density / (4 * std::numbers::pi * distance)) * volume_velocity.transpose();
    readout.delays.push_back(distance / speed_of_sound);
  }
  return readout;
}

}  // namespace carillon::synth::modal
