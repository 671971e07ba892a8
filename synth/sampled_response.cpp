#include "synth/sampled_response.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/error.hpp"

namespace carillon::synth {

namespace {

using Complex = std::complex<double>;

/// (exp(z) - 1) / z and (exp(z) - 1 - z) / z^2, by their series where the closed form cancels.
struct Phi {
  Complex first;
  Complex second;
};

Phi phi(const Complex& z) {
  if (std::abs(z) > 0.5) {
    const Complex first = (std::exp(z) - 1.0) / z;
    return {first, (first - 1.0) / z};
  }
  Complex second = 0;
  for (int k = 15; k >= 2; --k) second = (1.0 + z * second) / static_cast<double>(k);
  // second = 1/2 (1 + z/3 (1 + z/4 (...))), and first = 1 + z second.
  return {1.0 + z * second, second};
}

}  // namespace

void check_force_samples(std::span<const double> force, double duration) {
  if (force.size() < 2) {
    throw core::InputError(
        fmt::format("a sampled force needs two samples or more, not {}", force.size()));
  }
  if (!std::all_of(force.begin(), force.end(), [](double f) { return std::isfinite(f); })) {
    throw core::InputError("a sampled force has a value that is not finite");
  }
  if (!(duration > 0) || !std::isfinite(duration)) {
    throw core::InputError(
        fmt::format("a sampled force must last longer than 0 s, not {} s", duration));
  }
}

SampledResponse::SampledResponse(double eigenvalue, double decay_rate,
                                 std::span<const double> force, double duration)
    : eigenvalue_(eigenvalue), decay_rate_(decay_rate), duration_(duration) {
  check_force_samples(force, duration);
  force_.assign(force.begin(), force.end());
  step_ = duration / static_cast<double>(force.size() - 1);
  const double omega = std::sqrt(eigenvalue);
  oscillates_ = decay_rate < omega;
  split_ = std::sqrt(std::abs(decay_rate - omega)) * std::sqrt(decay_rate + omega);
  if (oscillates_) {
    poles_[0] = {-decay_rate, split_};
  } else {
    const double sum = decay_rate + split_;
    poles_[0] = sum > 0 ? -eigenvalue / sum : 0.0;
    poles_[1] = -sum;
  }
  impulse_.assign(force.size(), 0.0);
  for (std::size_t k = 1; k < force.size(); ++k) {
    impulse_[k] = impulse_[k - 1] + step_ * (force_[k - 1] + force_[k]) / 2;
  }
  for (int p = 0; p < (oscillates_ ? 1 : 2); ++p) {
    const Complex turn = std::exp(poles_[p] * step_);
    const Phi weights = phi(poles_[p] * step_);
    parts_[p].assign(force.size(), 0.0);
    for (std::size_t k = 1; k < force.size(); ++k) {
      parts_[p][k] =
          turn * parts_[p][k - 1] +
          step_ * (weights.first * force_[k - 1] + weights.second * (force_[k] - force_[k - 1]));
    }
  }
}

Complex SampledResponse::pole_part(int pole, double t) const {
  const auto& parts = parts_[pole];
  if (t >= duration_) return parts.back() * std::exp(poles_[pole] * (t - duration_));
  const auto k = std::min(static_cast<std::size_t>(t / step_), parts.size() - 2);
  const double rest = std::max(0.0, t - static_cast<double>(k) * step_);
  const Complex z = poles_[pole] * rest;
  const Phi weights = phi(z);
  const double slope = (force_[k + 1] - force_[k]) / step_;
  return std::exp(z) * parts[k] +
         rest * (weights.first * force_[k] + weights.second * (slope * rest));
}

double SampledResponse::force(double t) const {
  if (t < 0 || t > duration_) return 0;
  const auto k = std::min(static_cast<std::size_t>(t / step_), force_.size() - 2);
  const double share = t / step_ - static_cast<double>(k);
  return force_[k] + share * (force_[k + 1] - force_[k]);
}

double SampledResponse::impulse(double t) const {
  if (t <= 0) return 0;
  if (t >= duration_) return impulse_.back();
  const auto k = std::min(static_cast<std::size_t>(t / step_), force_.size() - 2);
  const double rest = t - static_cast<double>(k) * step_;
  return impulse_[k] + rest * (force_[k] + force(t)) / 2;
}

Motion SampledResponse::at(double t) const {
  if (!(t > 0)) return {};
  Motion motion;
  const Complex first = pole_part(0, t);
  if (oscillates_) {
    motion.displacement = first.imag() / split_;
    motion.velocity = (poles_[0] * first).imag() / split_;
  } else {
    const double second = pole_part(1, t).real();
    motion.displacement = (first.real() - second) / (2 * split_);
    motion.velocity = (poles_[0].real() * first.real() - poles_[1].real() * second) / (2 * split_);
  }
  motion.acceleration =
      force(t) - 2 * decay_rate_ * motion.velocity - eigenvalue_ * motion.displacement;
  return motion;
}

}  // namespace carillon::synth
