#pragma once

#include <Eigen/Core>
#include <span>

namespace carillon::synth::motion {

/// Times of flight from a body that moves to a place, at equal steps from t = 0 on, straight lines
/// between; after the last it stays.
struct FlightTimes {
  double step = 0;             ///< [s]
  std::span<const double> at;  ///< [s], at least one; none shrinks by more than a step each step
};

/// Adds what arrives at a place to `heard`: what leaves at t arrives at t + flight(t), so that
/// pitch is that of a source that moves (Doppler), by interpolation with a windowed sinc (Kaiser,
/// 64 samples: -96 dB up to 0.41 of the sample rate). Of the body's own changes in loudness
/// nothing is made here.
/// @param emitted  samples as they leave, silence before and after
/// @throws InputError  sizes, times that are negative or not finite, a body faster than sound
void add_arriving(const Eigen::Ref<const Eigen::VectorXd>& emitted, const FlightTimes& flight,
                  double sample_rate, Eigen::Ref<Eigen::VectorXd> heard);

}  // namespace carillon::synth::motion
