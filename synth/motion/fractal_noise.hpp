#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "solvers/mesh/surface_mesh.hpp"

namespace carillon::synth::motion {

/// Roughness too fine for any map: noise that belongs to the places of a body, so that the same way
/// over it gives the same course. A profile's power falls as wave number to the power -exponent:
/// octaves of gradient noise (Perlin 1985) on lattices of `longest`, `longest` / 2, ...
class FractalNoise {
 public:
  /// @param seed     of the body's surface
  /// @param longest  wave [m]
  /// @param exponent > 1
  /// @throws InputError  values that cannot be
  FractalNoise(std::uint64_t seed, double longest, double exponent);

  /// Two that know nothing of each other, of unit variance with all their octaves; those finer than
  /// `shortest` [m] are left out, the last one fades in.
  Eigen::Vector2d at(const Vec3& place, double shortest) const;

 private:
  std::uint64_t key_;
  double longest_;
  double exponent_;
};

}  // namespace carillon::synth::motion
