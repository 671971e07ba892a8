#pragma once

#include <Eigen/SparseCore>
#include <span>
#include <vector>

#include "synth/radiation/modal_pressure.hpp"
#include "synth/surface/outer_triangles.hpp"

namespace carillon::synth::radiation {

/// How finely a body's surface is sampled for its radiation.
struct EquivalentSourcesOptions {
  double per_wavelength = 4;  ///< sources along the wavelength of the highest mode
  int min_sources = 200;  ///< sources of any body: bending is shorter than the wavelength in air
  int max_sources = 400;  ///< cap; the cost of a mode grows with its square
};

/// Sources inside a body that make the sound of each of its modes: fitted once, heard anywhere.
struct EquivalentSources {
  /// L2 norm over the surface of what the fit leaves of the normal velocity, by the norm of the
  /// normal velocity; one per mode. What varies too fast for the patches counts as left.
  std::vector<double> residuals;
  /// Decay rate that each mode has from what it radiates [1/s]: the power sent out in all
  /// directions over twice the mode's energy.
  std::vector<double> decay_rates;
  std::size_t layers = 0;
  std::size_t patches = 0;

  // What pressure_at() needs.
  double size = 0;                  ///< R of source_layers.hpp [m]
  double nearest = 0;               ///< least distance of a listener from the surface [m]
  Vec3 centroid = Vec3::Zero();     ///< of the enclosed volume [m]
  std::vector<Vec3> points;         ///< of the sources [m]
  std::vector<Vec3> directions;     ///< of their dipoles, unit vectors
  std::vector<double> wavenumbers;  ///< one per mode [1/m]; equal ones share their waves
  /// Area of each point's triangle times each layer's strength there, points x layers [m^2].
  Eigen::SparseMatrix<double, Eigen::RowMajor> strengths;
  Eigen::MatrixXcd amplitudes;         ///< of the layers per modal acceleration, layers x modes
  solvers::mesh::SurfaceMesh outline;  ///< [m]

  std::size_t modes() const { return wavenumbers.size(); }
};

/// Modes whose residual is larger are not to be trusted: the field may be off by more than 1 dB.
inline constexpr double residual_limit = 0.3;

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
/// @throws InputError  no outer surface; shapes that are not finite
EquivalentSources fit_equivalent_sources(const solvers::modes::Modes& modes,
                                         const EquivalentSourcesOptions& options = {});

/// Pressure of a body's modes at any places, for one fit.
class SourceField {
 public:
  explicit SourceField(EquivalentSources sources);

  /// @param listeners  in the body's coordinates
  /// @throws InputError  a listener inside the body, on it, or nearer to it than the spacing of
  ///                     the patches
  ModalPressure pressure_at(std::span<const modal::Listener> listeners) const;
  const EquivalentSources& sources() const { return sources_; }

 private:
  void check(std::size_t row, const Vec3& position) const;

  EquivalentSources sources_;
  double reach_ = 0;             ///< of the outline about the centroid [m]
  Eigen::MatrixXd real_, imag_;  ///< amplitudes of the points, points x modes
};

}  // namespace carillon::synth::radiation
