#pragma once

#include <complex>
#include <span>
#include <vector>

#include "synth/modal_response.hpp"

namespace carillon::synth {

/// A mode at rest, q'' + 2 d q' + lambda q = F(t), under a force of straight pieces between samples
/// at equal steps (ContactForce::samples), exact at any time: each pole s carries z' = s z + F over
/// a piece in closed form.
class SampledResponse {
 public:
  /// @param eigenvalue  lambda >= 0 [rad^2/s^2]
  /// @param decay_rate  d >= 0 [1/s]; not within a tenth of critical damping (see
  ///                    ModalResponse::near_critical()), where the two poles' parts cancel
  /// @param force       two samples or more, the first at t = 0, the last at t = duration
  /// @throws InputError  fewer than two samples, one that is not finite, a duration that is not
  ///                     positive and finite
  SampledResponse(double eigenvalue, double decay_rate, std::span<const double> force,
                  double duration);

  /// Motion at any t; at rest before 0, a free decay after the duration.
  Motion at(double t) const;
  /// Integral of the force from 0 to t.
  double impulse(double t) const;

 private:
  std::complex<double> pole_part(int pole, double t) const;
  double force(double t) const;

  double eigenvalue_;
  double decay_rate_;
  double duration_;
  double step_;
  double split_;
  bool oscillates_;
  std::vector<double> force_;
  std::vector<double> impulse_;  ///< integral of the force up to each sample
  std::complex<double> poles_[2];
  std::vector<std::complex<double>> parts_[2];  ///< z of each pole at each sample
};

/// A force's samples are ones SampledResponse takes.
/// @throws InputError  as above
void check_force_samples(std::span<const double> force, double duration);

}  // namespace carillon::synth
