#pragma once

#include <span>
#include <vector>

#include "eval/damping/fit_damping.hpp"
#include "eval/material/struck_modes.hpp"

namespace carillon::eval::material {

/// A candidate as the optimiser sees it: coordinates without bounds, of similar size. Logarithms of
/// specific modulus, scale and contact time (where that is sought), then the damping model's:
/// logarithms of what must be positive, exponents as they are, Caughey's and an expression's
/// parameters relative to a size. Power laws are taken at a middle eigenvalue, so that factor and
/// exponent do not pull at each other.
struct Coordinates {
  damping::DampingLaw law;
  double eigenvalue = 1;      ///< the middle one [rad^2/s^2]
  std::vector<double> sizes;  ///< of Caughey's or an expression's parameters
  bool contact_sought = false;
  double contact_time = 0;  ///< [s], where it is given
};

/// @param law    model that is sought
/// @param start  a model of that law; gives an expression's sizes
/// @param eigenvalue  middle of those that matter [rad^2/s^2]
/// @param coefficient  a usual c [1/s]
Coordinates make_coordinates(const damping::DampingLaw& law,
                             const synth::damping::DampingModel& start, double eigenvalue,
                             double coefficient);

std::vector<double> to_coordinates(const Coordinates& coordinates, const Candidate& candidate);
Candidate from_coordinates(const Coordinates& coordinates, std::span<const double> x);
/// First steps of a search, one for each coordinate.
std::vector<double> first_steps(const Coordinates& coordinates);
/// Whether a coordinate is a logarithm: far down, its parameter is nothing.
bool is_logarithm(const Coordinates& coordinates, std::size_t place);
/// Where the damping's coordinates begin.
std::size_t first_damping(const Coordinates& coordinates);

}  // namespace carillon::eval::material
