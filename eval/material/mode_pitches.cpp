#include "eval/material/mode_pitches.hpp"

#include <algorithm>
#include <cmath>

#include "core/numbers.hpp"
#include "core/random.hpp"

namespace carillon::eval::material {

namespace {

constexpr int points = 64;              // that stand for the surface
constexpr double faintest = 0.02;       // weight of a mode that should not be heard
constexpr double decade_of_level = 50;  // over so many dB a weight falls to a tenth
constexpr double pair_width = 12;       // of modes that count as one [cents]

/// How much each mode moves along the normal: at points, and over the whole surface on average.
/// @return modes x points
Eigen::MatrixXd normal_motion(const solvers::modes::Modes& modes,
                              const std::optional<synth::modal::Strike>& strike) {
  const synth::modal::SurfaceSampler sampler(modes.surface);
  core::RandomStream random(1, 0, "material.points");
  const auto count = static_cast<Eigen::Index>(modes.size());
  Eigen::MatrixXd motion(count, points);
  for (int p = 0; p < points; ++p) {
    const synth::modal::SurfacePoint point = sampler.sample(random);
    motion.col(p) = (synth::modal::shapes_at(modes, point) *
                     synth::modal::frame_at(modes.surface, point).normal)
                        .cwiseAbs();
  }
  const Eigen::VectorXd heard = motion.rowwise().norm() / std::sqrt(static_cast<double>(points));
  if (strike)
    motion = (synth::modal::shapes_at(modes, strike->point) * strike->direction).cwiseAbs();
  return heard.asDiagonal() * motion;
}

}  // namespace

std::vector<double> audibility(std::span<const double> frequencies,
                               const Eigen::MatrixXd& amplitudes) {
  const std::size_t count = frequencies.size();
  std::vector<double> weights(count, 0.0);
  for (Eigen::Index p = 0; p < amplitudes.cols(); ++p) {
    const double loudest = amplitudes.col(p).maxCoeff();
    for (std::size_t i = 0; i < count; ++i) {
      const double ratio = loudest > 0 ? amplitudes(static_cast<Eigen::Index>(i), p) / loudest : 1;
      const double weight = std::pow(ratio, 20 / decade_of_level);
      weights[i] += std::max(faintest, weight) / static_cast<double>(amplitudes.cols());
    }
  }
  for (std::size_t first = 0; first < count;) {
    std::size_t last = first + 1;
    while (last < count && core::cents(frequencies[last] / frequencies[first]) < pair_width) ++last;
    for (std::size_t i = first; i < last; ++i) weights[i] /= static_cast<double>(last - first);
    first = last;
  }
  return weights;
}

ModePitches mode_pitches(const solvers::modes::Modes& modes, double specific_modulus,
                         double poisson_ratio, const std::optional<synth::modal::Strike>& strike) {
  ModePitches pitches;
  pitches.poisson_ratio = poisson_ratio;
  pitches.specific_modulus = specific_modulus;
  pitches.complete_to_hz = modes.certificate.complete_to_hz;
  for (std::size_t i = 0; i < modes.size(); ++i) {
    pitches.frequencies.push_back(modes.frequency(i));
    pitches.errors.push_back(modes.pitch_errors.empty() ? 0 : modes.pitch_errors[i]);
  }
  if (modes.size() > 0) {
    pitches.weights = audibility(pitches.frequencies, normal_motion(modes, strike));
  }
  return pitches;
}

ModePitches between(const ModePitches& low, const ModePitches& high, double poisson_ratio) {
  const double share =
      (poisson_ratio - low.poisson_ratio) / (high.poisson_ratio - low.poisson_ratio);
  const auto mix = [share](double a, double b) { return a + share * (b - a); };
  ModePitches pitches;
  pitches.poisson_ratio = poisson_ratio;
  pitches.specific_modulus = low.specific_modulus;
  const std::size_t count = std::min(low.frequencies.size(), high.frequencies.size());
  for (std::size_t i = 0; i < count; ++i) {
    pitches.frequencies.push_back(mix(low.frequencies[i], high.frequencies[i]));
    pitches.errors.push_back(mix(low.errors[i], high.errors[i]));
    pitches.weights.push_back(mix(low.weights[i], high.weights[i]));
  }
  pitches.complete_to_hz = mix(low.complete_to_hz, high.complete_to_hz);
  if (low.frequencies.size() != high.frequencies.size() && count > 0) {
    pitches.complete_to_hz = std::min(pitches.complete_to_hz, pitches.frequencies.back());
  }
  return pitches;
}

}  // namespace carillon::eval::material
