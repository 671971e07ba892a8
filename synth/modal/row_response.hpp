#pragma once

#include <complex>
#include <cstddef>
#include <span>
#include <vector>

#include "synth/modal/contact_force.hpp"
#include "synth/modal/modal_response.hpp"
#include "synth/modal/readout.hpp"
#include "synth/modal/resonators.hpp"

namespace carillon::synth::modal {

/// Weights of a mode's motion in a row of a readout, its excitation included.
Weights weights_of(const Readout& readout, Eigen::Index row, Eigen::Index mode, double excitation);

/// Modes as the kernel rings them.
struct Resonances {
  struct Mode {
    std::size_t index;     ///< among the eigenvalues given
    std::size_t rotation;  ///< its first: one for an oscillation, two beyond critical damping, none
    std::size_t rotations;  ///< near it
  };
  std::vector<double> eigenvalues;
  std::vector<double> decay_rates;
  std::vector<Mode> modes;  ///< those whose damped frequency is below Nyquist
  std::vector<Rotation> rotations;
  double sample_rate = 0;  ///< [Hz]
};

/// @throws InputError  sizes that do not match, values that are negative or not finite
Resonances make_resonances(std::span<const double> eigenvalues, std::span<const double> decay_rates,
                           double sample_rate);

/// When samples fall relative to a strike.
struct StrikeTiming {
  std::size_t contact_samples = 0;  ///< taken while the force acts
  long double first = 0;            ///< time of the first sample after the strike's begin [s]
  long double free = 0;             ///< time of the first free sample after the force's end [s]
};

/// A near-critical mode after a strike: its two exponentials cannot be told apart.
struct NearCriticalMotion {
  std::size_t index;  ///< of the mode
  Weights gains;      ///< of its motion in the row
  ModalMotion start;  ///< at the first free sample
};

/// What a strike adds to one row.
struct RowResponse {
  /// Per rotation: added to its voice's value at the first sample and at the first free sample.
  std::vector<std::complex<double>> begin, end;
  /// Samples in contact that no exponential gives.
  std::vector<double> direct;
  /// The forced motion in contact, its turning part taken at the first sample.
  ForcedMotion forced;
  std::vector<NearCriticalMotion> near_critical;
};

/// What a strike adds to a row: excitation [N s kg^-1/2] of every mode times the force.
/// @param response  filled anew; keeps its memory
void respond(const Resonances& resonances, const Readout& readout, Eigen::Index row,
             const Eigen::VectorXd& excitation, const ContactForce& force,
             const StrikeTiming& timing, RowResponse& response);

}  // namespace carillon::synth::modal
