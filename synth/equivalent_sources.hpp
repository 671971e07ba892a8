#pragma once

#include <span>
#include <vector>

#include "synth/modal_pressure.hpp"

namespace carillon::synth {

/// How finely a body's surface is sampled for its radiation.
struct EquivalentSourcesOptions {
  double per_wavelength = 4;  ///< sources along the wavelength of the highest mode
  int least = 200;  ///< sources of any body: bending is shorter than the wavelength in air
  int most = 400;   ///< cap; the cost of a mode grows with its square
};

/// What a fit of equivalent sources came to.
struct EquivalentSourcesFit {
  ModalPressure radiated;
  /// L2 norm over the surface of what the fit leaves of the normal velocity, by the norm of the
  /// normal velocity; one per mode. What varies too fast for the patches counts as left.
  std::vector<double> residuals;
  /// Decay rate that each mode has from what it radiates [1/s]: the power sent out in all
  /// directions over twice the mode's energy.
  std::vector<double> decay_rates;
  std::size_t sources = 0;
  std::size_t patches = 0;
};

/// Modes whose residual is larger are not to be trusted: the field may be off by more than 1 dB.
inline constexpr double kResidualLimit = 0.3;

/// Radiation of every mode into free air by equivalent sources inside the body's outer surface
/// (wave superposition: Koopmann, Song and Fahnline 1989; volume velocities as boundary condition:
/// Fahnline and Koopmann 1991). Each source is a smooth layer of points behind the surface, dipoles
/// along the normal with monopoles, (1/R + i k) of them per dipole, so that no frequency is one of
/// an inner resonance (Brakhage and Werner 1965). Their strengths make the volume velocity through
/// patches of the surface, weighted by each layer's own smooth function in turn, that of the mode,
/// each mode at its own k = omega_n / c. Twice as many patches as layers judge the fit.
/// The static part of the flux through near patches is exact, so walls may be far thinner than a
/// patch is wide. Cavities do not radiate.
///
/// @throws InputError  a listener inside the body, on it, or nearer to it than the spacing of the
///                     patches; no outer surface; shapes that are not finite
EquivalentSourcesFit fit_equivalent_sources(const solvers::Modes& modes,
                                            std::span<const Listener> listeners,
                                            const EquivalentSourcesOptions& options = {});

}  // namespace carillon::synth
