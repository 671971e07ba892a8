#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>

#include "synth/modal/contact_force.hpp"

namespace carillon::synth::motion {

/// A strike on modes at rest, at the samples: its motion in contact, and what it leaves.
struct DrivenStrike {
  std::uint64_t first = 0, free = 0;  ///< samples: in contact from first to before free
  Eigen::VectorXd excitation;         ///< [N s kg^-1/2]
  Eigen::VectorXd force;              ///< [1/s] at the samples in contact
  Eigen::MatrixXd displacement, velocity, force_rate;  ///< modes x samples in contact
  Eigen::VectorXd end_displacement, end_velocity;      ///< at the sample `free`
};

/// In closed form for the raised cosine, by exact steps for a sampled force.
/// @param excitation  of each mode [N s kg^-1/2]
/// @param delay       from sample 0 to its begin [s]
/// @throws InputError  a delay that is negative or endless, a contact of more than 1e5 samples,
///                     what check() refuses
DrivenStrike driven_strike(std::span<const double> eigenvalues, std::span<const double> decay_rates,
                           const Eigen::VectorXd& excitation, const modal::ContactForce& force,
                           double delay, double sample_rate);

}  // namespace carillon::synth::motion
