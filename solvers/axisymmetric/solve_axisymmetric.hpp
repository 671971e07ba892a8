#pragma once

#include <span>
#include <vector>

#include "core/trace.hpp"
#include "solvers/eigen/solve_modes.hpp"
#include "solvers/mesh/meridian.hpp"

namespace carillon::solvers::axisymmetric {

/// How finely a section is solved.
struct AxisymmetricOptions {
  /// Of the cells, 2 to 14; 0: 6 for a pitch target below 0.5 cents, else 4, or 2 where the outline
  /// has so many points that its parts are far smaller than waves ask for.
  int order = 0;
  double cell = 0;  ///< largest side of a cell [m]; 0: from the wave number at the band's top
  /// Wanted pitch error [cents]: while the estimate is above it, the order is raised by 2 and then
  /// cells are halved, as long as that at least halves the error. Needs
  /// SolveOptions::estimate_errors and no `cell` of one's own. 0: as it comes.
  double pitch_target = 0.01;
};

/// What is wanted of a body in one material.
struct MaterialBand {
  elements::Elastic material;
  modes::Band band;
};

/// What solve_axisymmetric() should come to, before it begins.
struct ExpectedSection {
  double rings = 0;           ///< nodes of the surface's outline
  double surface_nodes = 0;   ///< of these turned
  double surface_faces = 0;   ///< triangles of order 3
  std::vector<double> modes;  ///< of each of `wanted`, within a factor of about 1.3
};
/// @throws InputError  as solve_axisymmetric()
ExpectedSection expected_section(const mesh::Meridian& meridian,
                                 std::span<const MaterialBand> wanted,
                                 const AxisymmetricOptions& axisymmetric);

/// Modes of a free body of revolution: displacements are Fourier series in the angle, and each
/// harmonic n is a problem on the section alone, with three unknowns (u_r, u_theta, u_z) at every
/// node of quadrilaterals of high order. Shares nothing with the tetrahedra but the eigensolver, at
/// a small part of their cost: bowls, cups and bells have their independent truth in it.
///
/// Modes of harmonics above 0 come in pairs of exactly equal frequency, the second turned by a
/// quarter of a wave; Modes::harmonics names n. Each harmonic's count is verified by inertia.
/// Where the band holds far more modes than max_modes (and more than 2000), they are counted and
/// sought only as far up as needed: the certificate's modes_in_band counts those, with
/// count_verified off.
///
/// All materials share the section's cells, as fine as the most demanding of them asks, and the
/// surface: a place on it is the same in every one's modes.
///
/// Modes::surface is the outline turned about z, triangles of order 3. Pitch errors are 1.25 times
/// the differences to the same cells at the next order, 1.5 times where corners turn inward
/// (Meridian::is_graded), as one step of inverse iteration from the modes and Rayleigh and Ritz's
/// procedure give them.
///
/// Of the options tolerance, time and estimate_errors apply. A SolverEnvironment must be alive.
///
/// @param trace  stages mesh, assemble, count, solve, extract, estimate are added
/// @return one for each of `wanted`
/// @throws InputError   constants or a band that solve_modes refuses too
/// @throws SolverError  a cell turned inside out, too many nodes, no convergence, bad residuals, or
///                      rigid motions missing
/// Zienkiewicz and Taylor, The Finite Element Method 2 (5th edition), section 9.6, for the strains.
std::vector<modes::Modes> solve_axisymmetric(const mesh::Meridian& meridian,
                                             std::span<const MaterialBand> wanted,
                                             const eigen::SolveOptions& options,
                                             const AxisymmetricOptions& axisymmetric,
                                             core::Trace& trace);

/// The same of one material, in the band of `options`.
modes::Modes solve_axisymmetric(const mesh::Meridian& meridian, const elements::Elastic& material,
                                const eigen::SolveOptions& options,
                                const AxisymmetricOptions& axisymmetric, core::Trace& trace);

}  // namespace carillon::solvers::axisymmetric
