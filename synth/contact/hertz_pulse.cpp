#include "synth/contact/hertz_pulse.hpp"

#include <algorithm>
#include <cmath>

namespace carillon::synth::contact {

namespace {

constexpr int pieces = 128;

/// The force over one contact of duration 1 and unit impulse.
std::vector<double> make_shape() {
  // Runge-Kutta's steps up to the deepest point; the way out is the way in reversed. Half the
  // contact lasts the integral of dx / sqrt(1 - x^(5/2)) from 0 to 1, 2/5 B(2/5, 1/2).
  constexpr int steps = 200;  // in each piece
  const double half = 0.4 * std::beta(0.4, 0.5);
  const double h = half / (pieces / 2 * steps);
  const auto force = [](double x) { return x > 0 ? x * std::sqrt(x) : 0; };
  std::vector<double> shape(pieces + 1, 0.0);
  double x = 0;
  double v = 1;
  for (int k = 1; k <= pieces / 2; ++k) {
    for (int step = 0; step < steps; ++step) {
      const double v1 = v, a1 = -1.25 * force(x);
      const double v2 = v + h / 2 * a1, a2 = -1.25 * force(x + h / 2 * v1);
      const double v3 = v + h / 2 * a2, a3 = -1.25 * force(x + h / 2 * v2);
      const double v4 = v + h * a3, a4 = -1.25 * force(x + h * v3);
      x += h / 6 * (v1 + 2 * v2 + 2 * v3 + v4);
      v += h / 6 * (a1 + 2 * a2 + 2 * a3 + a4);
    }
    shape[static_cast<std::size_t>(k)] = shape[static_cast<std::size_t>(pieces - k)] = force(x);
  }
  const double impulse = modal::impulse_of({1, shape});
  for (double& value : shape) value /= impulse;
  return shape;
}

}  // namespace

modal::ContactForce hertz_pulse(double duration) {
  modal::check(modal::ContactForce{duration, {}});
  if (duration == 0) return {};
  static const std::vector<double> shape = make_shape();
  modal::ContactForce force{duration, shape};
  for (double& value : force.samples) value /= duration;
  modal::check(force);  // 1 / duration may be beyond a double
  return force;
}

}  // namespace carillon::synth::contact
