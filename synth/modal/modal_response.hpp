#pragma once

#include <array>
#include <complex>

namespace carillon::synth::modal {

/// Displacement, velocity and acceleration of a modal coordinate.
struct ModalMotion {
  double displacement = 0;
  double velocity = 0;
  double acceleration = 0;
  /// Rate of change of the force while it acts, as far as it is slow against the mode.
  double force_rate = 0;
};

/// Weights of a motion's parts in an output.
struct Weights {
  double displacement = 0;
  double velocity = 0;
  double acceleration = 0;
  double force_rate = 0;
  double of(const ModalMotion& motion) const {
    return displacement * motion.displacement + velocity * motion.velocity +
           acceleration * motion.acceleration + force_rate * motion.force_rate;
  }
  bool any() const {
    return displacement != 0 || velocity != 0 || acceleration != 0 || force_rate != 0;
  }
};

/// One exponential of a free decay: Re(amplitude exp((-decay_rate + i angular_frequency) tau)).
struct Partial {
  std::complex<double> amplitude;
  double decay_rate = 0;              ///< [1/s]
  long double angular_frequency = 0;  ///< [rad/s]; extended, for minutes of phase
};

/// A motion as wanted while a raised cosine acts: constant + Re(turning exp(2 pi i t / T)).
struct ForcedMotion {
  double constant = 0;
  std::complex<double> turning;
};

/// Force of a strike of unit impulse: the raised cosine (1 - cos(2 pi t / T)) / T on 0 <= t <= T
/// [N].
double contact_force(double contact_time, double t);

/// How far the force of a contact is slow against a mode of angular frequency omega: 0 for short
/// contacts, 1 for long ones, a half where it lasts one period.
double slow_fraction(double omega, double contact_time);

/// A mode at rest, q'' + 2 d q' + lambda q = F(t), struck by contact_force() of duration T, in
/// closed form. With the poles s of s^2 + 2 d s + lambda = 0 and I(s, t) the convolution of F with
/// exp(s t), q is the divided difference (I(s1, t) - I(s2, t)) / (s1 - s2). For T = 0 the force is
/// an ideal impulse and t = 0 means just after it.
class ModalResponse {
 public:
  /// @param eigenvalue    lambda = omega_n^2 >= 0 [rad^2/s^2]
  /// @param decay_rate    d >= 0 [1/s], below, at or above omega_n
  /// @param contact_time  T >= 0 [s]
  ModalResponse(double eigenvalue, double decay_rate, double contact_time);
  /// The free decay from a given motion on, as after a force of any other course.
  ModalResponse(double eigenvalue, double decay_rate, const ModalMotion& at_end);

  /// Motion while the force acts, 0 <= t <= T.
  ModalMotion during_contact(double t) const;
  /// Motion at tau >= 0 after the contact's end.
  ModalMotion after_contact(double tau) const;

  /// Damped angular frequency sqrt(lambda - d^2) [rad/s]; 0 for a mode that does not oscillate.
  double damped_frequency() const;
  /// The two poles are too close for a sum of two exponentials: only after_contact() is accurate.
  bool near_critical() const { return near_critical_; }
  /// The two poles s = -decay_rate + i angular_frequency with amplitude 1, or one and an unused one
  /// (amplitude 0) for a conjugate pair.
  std::array<Partial, 2> poles() const;
  /// The weighted free decay as exponentials of time after the contact's end; unused ones are zero.
  /// Not for near-critical modes.
  std::array<Partial, 2> partials(const Weights& weights) const;
  /// The motion in contact as the force's own oscillation and two exponentials of time, none of
  /// them much greater than the motion: not for modes near the pulse's frequency, slow against the
  /// pulse or near critical, whose parts would cancel (then during_contact() serves).
  bool contact_splits() const { return contact_splits_; }
  /// The exponentials of time since the contact's begin. Their negatives, begun at its end, turn
  /// them into the free decay. Only if contact_splits().
  std::array<Partial, 2> contact_partials(const Weights& weights) const;
  /// The motion with the force's own frequency. Only if contact_splits().
  ForcedMotion forced_motion(const Weights& weights) const;
  /// No smaller than the magnitude of the weighted motion at tau or later; falls with tau.
  double bound_after_contact(double tau, const Weights& weights) const;

 private:
  std::complex<double> first_pole() const;
  std::complex<double> second_pole() const;
  ModalMotion at_end() const;
  std::array<Partial, 2> partials_of(const Weights& weights,
                                     const std::array<std::complex<double>, 2>& transforms) const;

  double eigenvalue_;
  double decay_rate_;
  double contact_time_;
  bool given_;              ///< the motion at the end is given, not that of a raised cosine
  long double damped_ = 0;  ///< damped_frequency() in extended precision
  double split_;            ///< half the distance of the poles, sqrt|d^2 - lambda| [1/s]
  bool oscillates_;         ///< the poles are a complex pair
  bool near_critical_;
  bool contact_splits_;
  double slow_share_ = 0;  ///< of the force's rate
  ModalMotion given_end_;  ///< of the contact, if it was given
};

}  // namespace carillon::synth::modal
