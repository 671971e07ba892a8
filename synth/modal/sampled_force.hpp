#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "synth/modal/contact_force.hpp"
#include "synth/modal/modal_response.hpp"

namespace carillon::synth::modal {

/// Motion of q'' + 2 d q' + lambda q = F(t) after a time in which F is a straight line from F0 to
/// F1, exactly: q = qq q0 + qv v0 + q_begin F0 + q_end F1, and v likewise.
struct LinearForceStep {
  double qq, qv, q_begin, q_end;
  double vq, vv, v_begin, v_end;
};

/// @param eigenvalue  lambda >= 0 [rad^2/s^2]
/// @param decay_rate  d >= 0 [1/s], below, at or above sqrt(lambda)
/// @param length      of the step, >= 0 [s]
LinearForceStep linear_force_step(double eigenvalue, double decay_rate, double length);

/// A sampled force cut where it bends and where the output is sampled.
struct ForceSchedule {
  struct Stretch {
    std::uint32_t length;  ///< index into lengths
    bool samples_end;      ///< the output is sampled at its end
    double begin, end;     ///< force [1/s]
  };
  std::vector<double> lengths;  ///< [s]; few when the steps of force and output go together
  std::vector<Stretch> stretches;
};

/// @param force  with samples (at least two) and a positive duration
/// @param first  time of the output's first sample [s], >= 0
/// @param count  output samples before the force ends
ForceSchedule cut_force(const ContactForce& force, double first, double sample_rate,
                        std::size_t count);

/// Adds the weighted motion of a mode at rest under the force to `samples` (those the schedule was
/// cut for).
/// @return motion at the force's end, just after it
ModalMotion add_forced_motion(double eigenvalue, double decay_rate, const ForceSchedule& schedule,
                              const Weights& weights, std::span<double> samples);

/// A mode at rest under a sampled force, at any time.
class SampledResponse {
 public:
  /// @param force  with samples
  /// @throws InputError  no samples, or as check()
  SampledResponse(double eigenvalue, double decay_rate, const ContactForce& force);

  /// Motion at any t: at rest before 0, under the force up to the duration, a free decay after it.
  ModalMotion at(double t) const;
  /// Integral of the force from 0 to t.
  double impulse(double t) const;

 private:
  struct Knot {
    double q = 0, v = 0, impulse = 0;
  };
  struct Place {
    std::size_t piece;
    double rest;   ///< time since the piece's begin [s]
    double force;  ///< there [1/s]
  };
  static Knot after(const LinearForceStep& step, const Knot& from, double begin, double end);
  Place place(double t) const;

  double eigenvalue_;
  double decay_rate_;
  ContactForce force_;
  double step_;
  std::vector<Knot> knots_;  ///< where the force bends
};

}  // namespace carillon::synth::modal
