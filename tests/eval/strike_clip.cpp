#include "tests/eval/strike_clip.hpp"

#include <Eigen/Dense>
#include <cmath>
#include <numbers>

namespace carillon::eval {

double TestRandom::uniform() {
  // xorshift64*
  state_ ^= state_ >> 12;
  state_ ^= state_ << 25;
  state_ ^= state_ >> 27;
  return static_cast<double>((state_ * 2685821657736338717ull) >> 11) * 0x1p-53;
}

double TestRandom::normal() {
  const double radius = std::sqrt(-2 * std::log(1 - uniform()));
  return radius * std::cos(2 * std::numbers::pi * uniform());
}

std::vector<double> strike_clip(std::span<const Partial> partials, const ClipShape& shape) {
  std::vector<double> samples(
      static_cast<std::size_t>(std::llround(shape.seconds * shape.sample_rate)));
  const auto onset = static_cast<std::size_t>(std::llround(shape.onset * shape.sample_rate));
  for (std::size_t n = onset; n < samples.size(); ++n) {
    const double t = static_cast<double>(n - onset) / shape.sample_rate;
    for (const Partial& p : partials) {
      samples[n] += p.amplitude * std::exp(-p.decay_rate * t) *
                    std::cos(2 * std::numbers::pi * p.frequency * t + p.phase);
    }
  }
  return samples;
}

std::vector<double> strike_in_room(std::span<const Partial> partials, const ClipShape& shape,
                                   double rt60, TestRandom& random) {
  const auto count = static_cast<std::size_t>(shape.seconds * shape.sample_rate);
  std::vector<double> response(count), samples(count, 0.0);
  for (std::size_t n = 0; n < count; ++n) {
    const double time = static_cast<double>(n) / shape.sample_rate;
    response[n] = 0.02 * std::exp(-std::log(1000.0) / rt60 * time) * random.normal();
  }
  response[0] = 1;
  for (const Partial& partial : partials) {
    const std::complex<double> turn = std::exp(
        std::complex<double>(-partial.decay_rate, 2 * std::numbers::pi * partial.frequency) /
        shape.sample_rate);
    std::complex<double> ringing = 0;
    for (std::size_t n = 0; n < count; ++n) {
      ringing = turn * ringing + std::polar(partial.amplitude, partial.phase) * response[n];
      samples[n] += ringing.real();
    }
  }
  return samples;
}

double add_noise(std::vector<double>& samples, const ClipShape& shape, double snr_db,
                 TestRandom& random) {
  const auto onset = static_cast<std::size_t>(std::llround(shape.onset * shape.sample_rate));
  const auto count = static_cast<std::size_t>(0.1 * shape.sample_rate);
  double power = 0;
  for (std::size_t n = onset; n < onset + count; ++n) power += samples[n] * samples[n];
  const double deviation =
      std::sqrt(power / static_cast<double>(count) * std::pow(10, -snr_db / 10));
  for (double& sample : samples) sample += deviation * random.normal();
  return deviation;
}

std::vector<Bound> cramer_rao(std::span<const Partial> partials, const ClipShape& shape,
                              double from, double noise) {
  const auto count =
      static_cast<Eigen::Index>((shape.seconds - shape.onset - from) * shape.sample_rate);
  Eigen::MatrixXd jacobian(count, static_cast<Eigen::Index>(4 * partials.size()));
  for (std::size_t i = 0; i < partials.size(); ++i) {
    const Partial& p = partials[i];
    const auto at = static_cast<Eigen::Index>(4 * i);
    for (Eigen::Index n = 0; n < count; ++n) {
      const double t = from + static_cast<double>(n) / shape.sample_rate;
      const double angle = 2 * std::numbers::pi * p.frequency * t + p.phase;
      const double envelope = std::exp(-p.decay_rate * t);
      jacobian(n, at) =
          -p.amplitude * envelope * 2 * std::numbers::pi * t * std::sin(angle) / noise;
      jacobian(n, at + 1) = -p.amplitude * envelope * t * std::cos(angle) / noise;
      jacobian(n, at + 2) = envelope * std::cos(angle) / noise;
      jacobian(n, at + 3) = -p.amplitude * envelope * std::sin(angle) / noise;
    }
  }
  // Parameters differ by powers of ten.
  const Eigen::VectorXd scale = jacobian.colwise().norm().transpose().cwiseInverse();
  const Eigen::MatrixXd scaled = jacobian * scale.asDiagonal();
  const Eigen::MatrixXd inverse = (scaled.transpose() * scaled).inverse();
  std::vector<Bound> bounds;
  for (std::size_t i = 0; i < partials.size(); ++i) {
    const auto at = static_cast<Eigen::Index>(4 * i);
    bounds.push_back({scale(at) * std::sqrt(inverse(at, at)),
                      scale(at + 1) * std::sqrt(inverse(at + 1, at + 1))});
  }
  return bounds;
}

}  // namespace carillon::eval
