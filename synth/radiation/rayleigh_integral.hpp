#pragma once

#include <span>

#include "synth/radiation/modal_pressure.hpp"

namespace carillon::synth::radiation {

/// A body is a flat sheet when it is at most this fraction as thick as it is wide (its smaller
/// lateral extent; thickness with any bulge), ...
inline constexpr double sheet_thickness = 0.05;
/// ... and each of its two faces lies within this fraction of its width of a plane.
inline constexpr double sheet_flatness = 0.005;

/// Pressure at listeners from a flat sheet in a rigid baffle of the same plane (Rayleigh's
/// integral; Pierce, Acoustics, eq. 5.2.6): p = i omega rho / (2 pi) times the integral of v_n
/// exp(-i k r) / r over the face on the listener's side, each mode at its own k = omega_n / c. A
/// listener on the other side hears the other face; one in the plane beside the sheet hears the
/// pressure on the baffle.
///
/// @throws InputError  the body is not a flat sheet (says how thick and flat it is); a listener on
///                     the sheet or nearer to it than the integral's points are apart, or between
///                     the planes of its faces; shapes or positions that are not finite
ModalPressure rayleigh_pressure(const solvers::modes::Modes& modes,
                                std::span<const modal::Listener> listeners);

}  // namespace carillon::synth::radiation
