#pragma once

#include <span>
#include <string_view>
#include <vector>

#include "eval/features/feature.hpp"
#include "solvers/modes/modes.hpp"
#include "synth/damping/damping.hpp"
#include "synth/modal/ring_down.hpp"
#include "synth/radiation/modal_pressure.hpp"

namespace carillon::eval::material {

/// Which motion of the struck point a recording is taken to follow. Pressure far from a small
/// object follows its acceleration; `carillon strike` without listeners gives the velocity.
enum class HeardMotion { displacement, velocity, acceleration };

/// @throws InputError  no such name
HeardMotion parse_heard_motion(std::string_view name);
std::string_view name_of(HeardMotion motion);

/// Modes of an object of assumed material, struck at a point by a unit impulse.
struct StruckModes {
  std::vector<double> eigenvalues;  ///< with the assumed specific modulus [rad^2/s^2], ascending
  /// Outward motion at the point per motion of the modal coordinate, times the coordinate's
  /// impulse [1/kg], signed; entries of Phi (Phi^T f).
  std::vector<double> gains;
  double specific_modulus = 0;  ///< assumed E / density [m^2/s^2]
  double complete_to_hz = 0;    ///< no mode below is missing
  /// Decay rates by what is radiated [1/s], on top of a candidate's damping; empty: none.
  std::vector<double> radiated;
};

/// Modes of equal frequency (within 0.1 cents) are one, whose gain is the sum: it does not depend
/// on the basis that a solver found for them.
/// @param direction  unit vector the strike points along
/// @throws InputError  a point or direction that is none
StruckModes struck_modes(const solvers::modes::Modes& modes,
                         const synth::modal::SurfacePoint& point, const Vec3& direction,
                         double specific_modulus);

/// The same modes as a listener hears them: gains are pressures per modal acceleration times the
/// coordinate's impulse [Pa s^2/(m kg)], their magnitudes, to be heard as
/// HeardMotion::acceleration.
/// @param pressure  at one or more listeners; `row` is the one that hears
/// @param radiated  decay rate of each mode by radiation [1/s]; empty: none
/// @throws InputError  a point or direction that is none, sizes that do not match
StruckModes radiated_modes(const solvers::modes::Modes& modes,
                           const synth::modal::SurfacePoint& point, const Vec3& direction,
                           double specific_modulus, const synth::radiation::ModalPressure& pressure,
                           std::size_t row, std::span<const double> radiated);

/// What a sound might have been made with.
struct Candidate {
  double specific_modulus = 0;  ///< gamma = E / density [m^2/s^2]
  double scale = 1;             ///< of all amplitudes: impulse, channel gain, density
  double contact_time = 0;      ///< [s]
  synth::damping::DampingModel damping;
};

/// What is heard of a candidate.
struct HeardCandidate {
  std::vector<features::Feature> tones;  ///< ascending
  std::vector<std::size_t> modes;        ///< which of the struck modes each one is
  double negative = 0;  ///< how negative the damping is: 0 nowhere, 1 at every mode and by far
};

/// Features that a candidate would show: lambda scales with gamma, shapes stay; d = c(lambda) / 2
/// and what is radiated;
/// amplitudes are those of the free decay after a raised-cosine contact, referred to its begin.
/// Modes that do not oscillate, nearly so, or that lie outside the band are no tones; nor are those
/// whose damping is negative or not a number.
/// @param low, high  band of what can be heard [Hz]
HeardCandidate heard_candidate(const StruckModes& modes, const Candidate& candidate,
                               HeardMotion motion, double low, double high);

}  // namespace carillon::eval::material
