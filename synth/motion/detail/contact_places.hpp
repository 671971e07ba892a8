#pragma once

#include <Eigen/Core>
#include <vector>

#include "synth/modal/ring_down.hpp"
#include "synth/motion/motion.hpp"

namespace carillon::synth::motion {

/// A body's mode shapes along the way of a lasting contact over it: taken at the surface's nearest
/// point where the contact has moved on by a distance, straight lines between.
class ContactPlaces {
 public:
  /// @param side     0 or 1: of the contact's bodies
  /// @param spacing  of the places where shapes are taken [m]
  /// @throws InputError  a contact without steps
  ContactPlaces(const solvers::modes::Modes& modes, const modal::SurfaceSampler& sampler,
                const LastingContact& contact, std::size_t side, double spacing);

  /// At the begin of a step of the contact, or (steps) at the end of its last: modes x 3.
  Eigen::MatrixX3d shapes(std::size_t step) const;

  std::size_t keys() const { return keys_.size(); }

 private:
  std::vector<std::size_t> keys_;  ///< steps, ascending, the first and the last among them
  std::vector<Eigen::MatrixX3d> shapes_;
  std::vector<double> way_;  ///< up to each step [m]
};

/// Normal force of a contact at each step without the chatter of a solver's impulses: the mean
/// under a Hann window [N].
/// @param window  whole width [s]; it is cut at the contact's ends
std::vector<double> smooth_normal_force(const LastingContact& contact, double step, double window);

/// What a dashpot of 1 N s/m at a contact does to each mode (supports.hpp): the diagonal of
/// Phi^T (mu I + (1 - mu) n n^T) Phi [1/kg].
Eigen::VectorXd unit_damping(const Eigen::MatrixX3d& shapes, const Vec3& normal, double friction);

}  // namespace carillon::synth::motion
