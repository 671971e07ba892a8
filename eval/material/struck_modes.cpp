#include "eval/material/struck_modes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

#include "core/error.hpp"
#include "synth/modal/modal_response.hpp"

namespace carillon::eval::material {

namespace {

/// Of eigenvalues, for modes to count as equal: as solvers::modes::whole_clusters() has it.
constexpr double same = 1e-4;

synth::modal::Weights weights_of(HeardMotion motion) {
  synth::modal::Weights weights;
  if (motion == HeardMotion::displacement) weights.displacement = 1;
  if (motion == HeardMotion::velocity) weights.velocity = 1;
  if (motion == HeardMotion::acceleration) weights.acceleration = 1;
  return weights;
}

StruckModes without_gains(const solvers::modes::Modes& modes, double specific_modulus) {
  StruckModes struck;
  struck.specific_modulus = specific_modulus;
  struck.complete_to_hz = modes.certificate.complete_to_hz;
  return struck;
}

/// Whether a mode's frequency is that of the last one.
bool joins(const StruckModes& struck, double eigenvalue) {
  return !struck.eigenvalues.empty() && eigenvalue <= struck.eigenvalues.back() * (1 + same);
}

}  // namespace

HeardMotion parse_heard_motion(std::string_view name) {
  for (const HeardMotion motion :
       {HeardMotion::displacement, HeardMotion::velocity, HeardMotion::acceleration}) {
    if (name == name_of(motion)) return motion;
  }
  throw core::InputError(fmt::format("\"{}\" is no motion that is heard", name),
                         "displacement, velocity or acceleration");
}

std::string_view name_of(HeardMotion motion) {
  switch (motion) {
    case HeardMotion::displacement:
      return "displacement";
    case HeardMotion::velocity:
      return "velocity";
    default:
      return "acceleration";
  }
}

StruckModes struck_modes(const solvers::modes::Modes& modes,
                         const synth::modal::SurfacePoint& point, const Vec3& direction,
                         double specific_modulus) {
  const Eigen::MatrixX3d shapes = synth::modal::shapes_at(modes, point);
  const Vec3 normal = synth::modal::frame_at(modes.surface, point).normal;
  StruckModes struck = without_gains(modes, specific_modulus);
  for (std::size_t i = 0; i < modes.size(); ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    const double gain = shapes.row(row).dot(normal) * shapes.row(row).dot(direction);
    if (joins(struck, modes.eigenvalues[i])) {
      struck.gains.back() += gain;
    } else {
      struck.eigenvalues.push_back(modes.eigenvalues[i]);
      struck.gains.push_back(gain);
    }
  }
  return struck;
}

StruckModes radiated_modes(const solvers::modes::Modes& modes,
                           const synth::modal::SurfacePoint& point, const Vec3& direction,
                           double specific_modulus, const synth::radiation::ModalPressure& pressure,
                           std::size_t row, std::span<const double> radiated) {
  const auto listener = static_cast<Eigen::Index>(row);
  if (pressure.pressure.cols() != static_cast<Eigen::Index>(modes.size()) ||
      listener >= pressure.pressure.rows() ||
      (!radiated.empty() && radiated.size() != modes.size())) {
    throw core::InputError(fmt::format(
        "radiation of {} modes, {} decay rates and {} listeners does not fit {} modes",
        pressure.pressure.cols(), radiated.size(), pressure.pressure.rows(), modes.size()));
  }
  const Eigen::VectorXd impulses = synth::modal::shapes_at(modes, point) * direction;
  StruckModes struck = without_gains(modes, specific_modulus);
  std::complex<double> sum;
  for (std::size_t i = 0; i < modes.size(); ++i) {
    const auto mode = static_cast<Eigen::Index>(i);
    const std::complex<double> gain = pressure.pressure(listener, mode) * impulses[mode];
    if (joins(struck, modes.eigenvalues[i])) {
      sum += gain;
      struck.gains.back() = std::abs(sum);
    } else {
      sum = gain;
      struck.eigenvalues.push_back(modes.eigenvalues[i]);
      struck.gains.push_back(std::abs(gain));
      if (!radiated.empty()) struck.radiated.push_back(radiated[i]);
    }
  }
  return struck;
}

HeardCandidate heard_candidate(const StruckModes& modes, const Candidate& candidate,
                               HeardMotion motion, double low, double high) {
  HeardCandidate heard;
  const double ratio = candidate.specific_modulus / modes.specific_modulus;
  const auto coefficient = synth::damping::damping_function(candidate.damping);
  const synth::modal::Weights weights = weights_of(motion);
  std::size_t audible = 0;
  for (std::size_t i = 0; i < modes.eigenvalues.size(); ++i) {
    const double lambda = ratio * modes.eigenvalues[i];
    const double omega = std::sqrt(lambda);
    if (omega < 2 * std::numbers::pi * low || omega > 2 * std::numbers::pi * high) continue;
    ++audible;
    double decay = 0.5 * coefficient(lambda);
    if (!(decay >= 0)) {
      // As large as the frequency is by far; not a number counts like it.
      heard.negative += decay < 0 ? 0.5 + 0.5 * std::min(1.0, -decay / omega) : 1.0;
      continue;
    }
    if (!modes.radiated.empty()) decay += modes.radiated[i];
    if (!std::isfinite(decay)) continue;
    const synth::modal::ModalResponse response(lambda, decay, candidate.contact_time);
    const double frequency = response.damped_frequency() / (2 * std::numbers::pi);
    if (response.near_critical() || frequency < low) continue;
    const auto partial = response.partials(weights)[0];
    features::Feature tone;
    tone.frequency = frequency;
    tone.decay_rate = decay;
    tone.amplitude = std::abs(candidate.scale * modes.gains[i]) * std::abs(partial.amplitude) *
                     std::exp(decay * candidate.contact_time);
    if (!(tone.amplitude > 0) || !std::isfinite(tone.amplitude)) continue;
    heard.tones.push_back(tone);
    heard.modes.push_back(i);
  }
  if (audible > 0) heard.negative /= static_cast<double>(audible);
  return heard;
}

}  // namespace carillon::eval::material
