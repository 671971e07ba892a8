#include "synth/modal/modal_response.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "synth/modal/detail/phi_functions.hpp"

namespace carillon::synth::modal {

namespace {

using Complex = std::complex<double>;
using std::numbers::pi;

/// Poles nearer than this fraction of d are treated as one pair: a sum of two exponentials would
/// lose more than a digit.
constexpr double near_critical_fraction = 0.1;

/// Poles and frequencies of the force are apart, over the contact, from this many radians on: parts
/// of a motion are then at most some hundred times as great as it.
constexpr double apart = 0.01;

/// (exp(x) - exp(c)) / (x - c), given both exponentials.
Complex exponential_difference(const Complex& x, const Complex& exp_x, const Complex& c,
                               const Complex& exp_c) {
  const Complex distance = x - c;
  return std::norm(distance) < 1 ? exp_c * phi1(distance) : (exp_x - exp_c) / distance;
}

/// I(s, t): convolution of the unit raised cosine with exp(s t), 0 <= t <= T.
Complex convolution(const Complex& s, double contact_time, double t) {
  const double turn = 2 * pi * (t / contact_time);
  const Complex x = s * t;
  const Complex exp_x = std::exp(x);
  const Complex up(std::cos(turn), std::sin(turn));
  const Complex constant = exponential_difference(x, exp_x, 0, 1);
  const Complex cosine = exponential_difference(x, exp_x, {0, turn}, up) +
                         exponential_difference(x, exp_x, {0, -turn}, std::conj(up));
  return (t / contact_time) * (constant - 0.5 * cosine);
}

/// I(s, T) = phi1(sT) / (1 + (sT / 2 pi)^2), whose two poles are zeros of phi1: near one of them
/// both are taken relative to it.
Complex pulse_transform(const Complex& s, double contact_time) {
  const Complex x = s * contact_time;
  if (std::abs(x.imag()) < pi) {
    return phi1(x) * (2 * pi / (x - Complex(0, 2 * pi))) * (2 * pi / (x + Complex(0, 2 * pi)));
  }
  const Complex zero(0, std::copysign(2 * pi, x.imag()));
  const Complex offset = x - zero;
  // exp(x) = exp(offset), so that phi1(x) = offset phi1(offset) / x.
  return phi1(offset) * (2 * pi / x) * (2 * pi / (offset + 2.0 * zero));
}

}  // namespace

double contact_force(double contact_time, double t) {
  if (!(contact_time > 0) || t < 0 || t > contact_time) return 0;
  const double sine = std::sin(pi * (t / contact_time));
  return 2 * sine * sine / contact_time;
}

double slow_fraction(double omega, double contact_time) {
  return 1 / (1 + std::pow(2 * pi / (omega * contact_time), 8));
}

ModalResponse::ModalResponse(double eigenvalue, double decay_rate, double contact_time)
    : ModalResponse(eigenvalue, decay_rate, ModalMotion{0, 1, -2 * decay_rate}) {
  contact_time_ = contact_time;
  given_ = !(contact_time > 0);
  slow_share_ = given_ ? 0 : slow_fraction(std::sqrt(eigenvalue), contact_time);
  if (given_ || near_critical_) return;
  const Complex first = first_pole() * contact_time;
  contact_splits_ = std::abs(first) >= apart && std::abs(first - Complex(0, 2 * pi)) >= apart;
}

ModalResponse::ModalResponse(double eigenvalue, double decay_rate, const ModalMotion& at_end)
    : eigenvalue_(eigenvalue),
      decay_rate_(decay_rate),
      contact_time_(0),
      given_(true),
      contact_splits_(false),
      given_end_(at_end) {
  const double omega = std::sqrt(eigenvalue);
  oscillates_ = decay_rate < omega;
  // The product of roots neither overflows nor cancels.
  split_ = std::sqrt(std::abs(decay_rate - omega)) * std::sqrt(decay_rate + omega);
  near_critical_ = split_ <= near_critical_fraction * decay_rate;
  if (oscillates_) {
    const auto extended = std::sqrt(static_cast<long double>(eigenvalue));
    damped_ = std::sqrt((extended - decay_rate) * (extended + decay_rate));
  }
}

ModalMotion ModalResponse::at_end() const {
  return given_ ? given_end_ : during_contact(contact_time_);
}

Complex ModalResponse::first_pole() const {
  // -d + split cancels when the damping is strong; the product of the poles is lambda.
  if (oscillates_) return {-decay_rate_, split_};
  const double sum = decay_rate_ + split_;
  return sum > 0 ? -eigenvalue_ / sum : 0.0;
}

Complex ModalResponse::second_pole() const {
  return oscillates_ ? Complex(-decay_rate_, -split_) : Complex(-(decay_rate_ + split_), 0);
}

double ModalResponse::damped_frequency() const {
  return oscillates_ ? split_ : 0;
}

ModalMotion ModalResponse::during_contact(double t) const {
  if (given_) return given_end_;
  if (!(t > 0)) return {};
  double q = 0;
  double v = 0;
  if (near_critical_ && split_ * t < 0.5) {
    // Divided difference by Cauchy's integral on a circle around both poles: I is entire, so the
    // trapezoidal rule converges geometrically (the poles lie within a quarter of the radius), and
    // nothing cancels however close they are. The lower half of the circle is the conjugate.
    constexpr int points = 16;
    const double radius = 2 / t;
    const double split_squared = oscillates_ ? -split_ * split_ : split_ * split_;
    for (int k = 0; k < points; ++k) {
      const Complex offset = std::polar(radius, pi * (k + 0.5) / points);
      const Complex s = -decay_rate_ + offset;
      const Complex term =
          convolution(s, contact_time_, t) * offset / (offset * offset - split_squared);
      q += term.real() / points;
      v += (s * term).real() / points;
    }
  } else if (oscillates_) {
    const Complex integral = convolution(first_pole(), contact_time_, t);
    q = integral.imag() / split_;
    v = (first_pole() * integral).imag() / split_;
  } else {
    const double first = convolution(first_pole(), contact_time_, t).real();
    const double second = convolution(second_pole(), contact_time_, t).real();
    q = (first - second) / (2 * split_);
    v = (first_pole().real() * first - second_pole().real() * second) / (2 * split_);
  }
  const double turn = 2 * pi / contact_time_;
  return {q, v, contact_force(contact_time_, t) - 2 * decay_rate_ * v - eigenvalue_ * q,
          slow_share_ * turn * std::sin(turn * t) / contact_time_};
}

ModalMotion ModalResponse::after_contact(double tau) const {
  // Fundamental solutions: `slope` starts with q = 0, q' = 1; `start` with q = 1, q' = 0.
  double slope = 0;
  double slope_rate = 0;
  double start = 0;
  if (oscillates_) {
    const double decay = std::exp(-decay_rate_ * tau);
    const double angle = split_ * tau;
    slope =
        decay * (std::abs(angle) < 1e-4 ? tau * (1 - angle * angle / 6) : std::sin(angle) / split_);
    slope_rate = decay * std::cos(angle) - decay_rate_ * slope;
    start = decay * std::cos(angle) + decay_rate_ * slope;
  } else {
    const double slow = std::exp(first_pole().real() * tau);
    slope = slow * tau * phi1(Complex(-2 * split_ * tau)).real();
    slope_rate = slow + second_pole().real() * slope;
    start = slow - first_pole().real() * slope;
  }
  const ModalMotion end = at_end();
  const double q = end.displacement * start + end.velocity * slope;
  const double v = -eigenvalue_ * end.displacement * slope + end.velocity * slope_rate;
  return {q, v, -2 * decay_rate_ * v - eigenvalue_ * q, 0};
}

std::array<Partial, 2> ModalResponse::partials_of(const Weights& weights,
                                                  const std::array<Complex, 2>& transforms) const {
  const auto power = [&](const Complex& s) {
    return weights.displacement + s * (weights.velocity + s * weights.acceleration);
  };
  std::array<Partial, 2> partials = poles();
  const Complex first = first_pole();
  if (oscillates_) {
    // Im z = Re(-i z).
    partials[0].amplitude = Complex(0, -1 / split_) * power(first) * transforms[0];
  } else {
    partials[0].amplitude = power(first) * transforms[0] / (2 * split_);
    partials[1].amplitude = -power(second_pole()) * transforms[1] / (2 * split_);
  }
  return partials;
}

std::array<Partial, 2> ModalResponse::poles() const {
  if (oscillates_) return {Partial{1, decay_rate_, damped_}, Partial{}};
  return {Partial{1, -first_pole().real(), 0}, Partial{1, -second_pole().real(), 0}};
}

std::array<Partial, 2> ModalResponse::partials(const Weights& weights) const {
  const Complex first = first_pole();
  const Complex second = second_pole();
  // I(s, T), for a given motion from q and v: (s1 - s2) q is the difference of the poles' I.
  const auto transform = [&](const Complex& s, const Complex& other) {
    return given_ ? given_end_.velocity - other * given_end_.displacement
                  : pulse_transform(s, contact_time_);
  };
  return partials_of(
      weights, {transform(first, second), oscillates_ ? Complex(0) : transform(second, first)});
}

std::array<Partial, 2> ModalResponse::contact_partials(const Weights& weights) const {
  // The part of I(s, t) with exp(s t): Omega^2 / (s T (s^2 + Omega^2)), Omega = 2 pi / T.
  const auto transform = [&](const Complex& s) {
    const Complex x = s * contact_time_;
    return (1.0 / x) * (2 * pi / (x - Complex(0, 2 * pi))) * (2 * pi / (x + Complex(0, 2 * pi)));
  };
  return partials_of(weights,
                     {transform(first_pole()), oscillates_ ? 0 : transform(second_pole())});
}

ForcedMotion ModalResponse::forced_motion(const Weights& weights) const {
  const Complex frequency(0, 2 * pi / contact_time_);
  const Complex response = 1.0 / ((frequency - first_pole()) * (frequency - second_pole()));
  const Complex power =
      weights.displacement + frequency * (weights.velocity + frequency * weights.acceleration);
  // The force is (1 - Re exp(i Omega t)) / T.
  return {weights.displacement / (eigenvalue_ * contact_time_),
          -(power * response + weights.force_rate * slow_share_ * frequency) / contact_time_};
}

double ModalResponse::bound_after_contact(double tau, const Weights& weights) const {
  // With e the slower decay, |slope| <= tau e, and |slope_rate| and |start| <= e + fast |slope|.
  // tau e rises until 1 / rate: before that its maximum is what counts.
  const double rate = oscillates_ ? decay_rate_ : -first_pole().real();
  const double reach = rate > 0 ? std::max(tau, 1 / rate) : tau;
  const double fast = oscillates_ ? decay_rate_ : decay_rate_ + split_;
  const double slope = reach * std::exp(-rate * reach);
  const double start = std::exp(-rate * tau) + fast * slope;
  const ModalMotion end = at_end();
  const double q = std::abs(end.displacement) * start + std::abs(end.velocity) * slope;
  const double v =
      eigenvalue_ * std::abs(end.displacement) * slope + std::abs(end.velocity) * start;
  return std::abs(weights.displacement) * q + std::abs(weights.velocity) * v +
         std::abs(weights.acceleration) * (2 * decay_rate_ * v + eigenvalue_ * q);
}

}  // namespace carillon::synth::modal
