#include "eval/material/detail/coordinates.hpp"

#include <algorithm>
#include <cmath>

namespace carillon::eval::material {

namespace {

using synth::damping::DampingKind;

/// Parameters that must not be negative, but may be nothing, over what would be usual.
constexpr double nothing = 1e-6;
/// No contact is shorter or longer [s].
constexpr double shortest = 1e-6;
constexpr double longest = 0.02;

double log_of(double value, double usual) {
  return std::log(std::max(value / usual, nothing));
}

std::vector<double> damping_coordinates(const Coordinates& c, const std::vector<double>& alpha) {
  // For these laws the one size is a usual c.
  const double usual = c.sizes.front();
  switch (c.law.kind) {
    case DampingKind::rayleigh:
      return {log_of(alpha[0], usual), log_of(alpha[1] * c.eigenvalue, usual)};
    case DampingKind::power:
      return {log_of(alpha[0] * std::pow(c.eigenvalue, alpha[1]), usual), alpha[1]};
    case DampingKind::hybrid:
      return {log_of(alpha[0], usual), log_of(alpha[1] * std::pow(c.eigenvalue, alpha[2]), usual),
              alpha[2]};
    default: {
      std::vector<double> x(alpha.size());
      for (std::size_t k = 0; k < alpha.size(); ++k) x[k] = alpha[k] / c.sizes[k];
      return x;
    }
  }
}

std::vector<double> damping_parameters(const Coordinates& c, std::span<const double> x) {
  const double usual = c.sizes.front();
  switch (c.law.kind) {
    case DampingKind::rayleigh:
      return {usual * std::exp(x[0]), usual * std::exp(x[1]) / c.eigenvalue};
    case DampingKind::power:
      return {usual * std::exp(x[0]) * std::pow(c.eigenvalue, -x[1]), x[1]};
    case DampingKind::hybrid:
      return {usual * std::exp(x[0]), usual * std::exp(x[1]) * std::pow(c.eigenvalue, -x[2]), x[2]};
    default: {
      std::vector<double> alpha(x.size());
      for (std::size_t k = 0; k < x.size(); ++k) alpha[k] = x[k] * c.sizes[k];
      return alpha;
    }
  }
}

}  // namespace

Coordinates make_coordinates(const damping::DampingLaw& law,
                             const synth::damping::DampingModel& start, double eigenvalue,
                             double coefficient) {
  Coordinates coordinates;
  coordinates.law = law;
  coordinates.eigenvalue = eigenvalue;
  const std::size_t count = start.parameters.size();
  switch (law.kind) {
    case DampingKind::caughey:
      for (std::size_t k = 0; k < count; ++k) {
        coordinates.sizes.push_back(coefficient * std::pow(eigenvalue, -static_cast<double>(k)));
      }
      break;
    case DampingKind::expression:
      for (const double alpha : start.parameters) {
        coordinates.sizes.push_back(alpha != 0 ? std::abs(alpha) : 1);
      }
      break;
    default:
      coordinates.sizes = {coefficient};
  }
  return coordinates;
}

std::size_t first_damping(const Coordinates& coordinates) {
  return coordinates.contact_sought ? 3 : 2;
}

bool is_logarithm(const Coordinates& coordinates, std::size_t place) {
  if (place < first_damping(coordinates)) return true;
  const std::size_t alpha = place - first_damping(coordinates);
  switch (coordinates.law.kind) {
    case DampingKind::rayleigh:
      return true;
    case DampingKind::power:
      return alpha == 0;
    case DampingKind::hybrid:
      return alpha < 2;
    default:
      return false;
  }
}

std::vector<double> to_coordinates(const Coordinates& coordinates, const Candidate& candidate) {
  std::vector<double> x = {std::log(candidate.specific_modulus), std::log(candidate.scale)};
  if (coordinates.contact_sought) x.push_back(std::log(candidate.contact_time));
  const auto damping = damping_coordinates(coordinates, candidate.damping.parameters);
  x.insert(x.end(), damping.begin(), damping.end());
  return x;
}

Candidate from_coordinates(const Coordinates& coordinates, std::span<const double> x) {
  Candidate candidate;
  candidate.specific_modulus = std::exp(x[0]);
  candidate.scale = std::exp(x[1]);
  candidate.contact_time = coordinates.contact_sought
                               ? std::clamp(std::exp(x[2]), shortest, longest)
                               : coordinates.contact_time;
  candidate.damping = {coordinates.law.kind,
                       damping_parameters(coordinates, x.subspan(first_damping(coordinates))),
                       coordinates.law.expression};
  return candidate;
}

std::vector<double> first_steps(const Coordinates& coordinates) {
  // Half a per cent of modulus is what a start may be off; everything else by a fifth.
  std::vector<double> steps = {0.005, 0.2};
  if (coordinates.contact_sought) steps.push_back(0.3);
  switch (coordinates.law.kind) {
    case DampingKind::rayleigh:
      steps.insert(steps.end(), {0.2, 0.2});
      break;
    case DampingKind::power:
      steps.insert(steps.end(), {0.2, 0.05});
      break;
    case DampingKind::hybrid:
      steps.insert(steps.end(), {0.2, 0.2, 0.05});
      break;
    default:
      steps.insert(steps.end(), coordinates.sizes.size(), 0.1);
  }
  return steps;
}

}  // namespace carillon::eval::material
