#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "solvers/modes/mode_shapes.hpp"

namespace carillon::solvers::modes {

struct Band {
  double min_frequency = 20;     ///< [Hz]
  double max_frequency = 20000;  ///< [Hz]
  int max_modes = 300;
  /// max_modes counts the modes above this [Hz]; those between min_frequency and it come on top.
  /// 0: above min_frequency. For sets that serve bands with different bottoms.
  double counted_from = 0;

  double bottom() const { return std::max(min_frequency, counted_from); }
};

enum class EigenSolver {
  block_lanczos,  ///< thick-restarted block Lanczos (block_lanczos.hpp)
  krylov_schur,   ///< SLEPc's
  /// Block-preconditioned conjugate gradients (lobpcg.hpp), in certificates alone: what
  /// block_lanczos becomes over an iterative linear solver.
  lobpcg,
  /// LAPACK's, in certificates alone: taken by itself for a few hundred unknowns, or where a good
  /// part of all modes is asked for.
  dense,
  slepc,  ///< another type of SLEPc's that PETSC_OPTIONS asked for, in certificates alone
};

enum class LinearSolver {
  automatic,  ///< direct while the factors fit the memory limit, else iterative
  direct,     ///< Cholesky: CHOLMOD on one rank, MUMPS on a group
  iterative,  ///< multigrid, with LOBPCG or conjugate gradients; the count of modes is then not
              ///< verified
};

/// What is known of a mode set's completeness and accuracy.
struct Certificate {
  double min_frequency = 0;  ///< the band that was asked for [Hz]
  double max_frequency = 0;
  std::int64_t modes_in_band = 0;  ///< flexible modes between the band's ends, by Sylvester inertia
  std::int64_t modes_found = 0;    ///< of them, those in this set
  bool complete = false;           ///< every mode in the band is in the set
  double complete_to_hz = 0;       ///< no mode below this frequency is missing
  int rigid_modes = 0;             ///< recognised by projection on the rigid-body space
  int components = 0;
  /// ||K x - lambda M x|| / (lambda ||M x||), worst mode. Below 1e-8 as a rule; on very thin bodies
  /// (1 to 1000) the rounding of x alone raises it to 1e-2, without harm to the frequencies.
  double max_residual = 0;
  double orthonormality = 0;  ///< max |X^T M X - I|, rigid modes included
  std::int64_t unknowns = 0;
  int mirror_planes = 0;        ///< of symmetry, by whose classes the body was solved
  bool count_verified = false;  ///< modes_in_band was counted by inertia, not taken from the search
  EigenSolver eigen_solver = EigenSolver::block_lanczos;  ///< the one that was used
  LinearSolver linear_solver = LinearSolver::direct;      ///< likewise
  /// The set comes from a basis of modes at so many other Poisson's ratios; 0: a solve of its own.
  /// Residuals are then those of the energy norm, whose square bounds an eigenvalue's error.
  int snapshots = 0;
  /// Bound of what the basis adds to any pitch of the set [cents]; 0 for a solve of its own.
  double basis_error = 0;
};

/// The body's surface as the modes see it: node positions and curved faces.
struct ModeSurface {
  int order = 1;
  std::vector<Vec3> nodes;          ///< [m]
  std::vector<std::int32_t> faces;  ///< n x nodes_per_face(order), outward, triangle_lattice order
};

/// Free vibration modes of a body, ascending, flexible ones inside the band only.
struct Modes {
  std::vector<double> eigenvalues;  ///< lambda = omega_n^2 [rad^2/s^2], n
  std::vector<double> residuals;    ///< n
  /// Estimated distance to the pitch of the body itself (its true surface, no discretisation)
  /// [cents], n values; empty where none was asked for.
  std::vector<double> pitch_errors;
  /// Decay rates that came with the modes [1/s], n values, where a file of another program holds
  /// them; empty: the materials' damping gives them.
  std::vector<double> given_decay_rates;
  ModeShapes shapes;  ///< at the nodes of `surface`
  /// Share of each region in a mode's kinetic and strain energy: n rows x regions, rows sum to 1.
  Eigen::MatrixXd kinetic_fraction;
  Eigen::MatrixXd strain_fraction;
  ModeSurface surface;
  double mass = 0;  ///< [kg]
  Certificate certificate;

  std::size_t size() const { return eigenvalues.size(); }
  /// Undamped frequency [Hz].
  double frequency(std::size_t mode) const;
};

/// Modes of the same body with every length, Young's modulus and density multiplied by a factor:
/// lambda scales with modulus / (density length^2), shapes with (density length^3)^-1/2. Exact.
/// Given decay rates stay as they are: how they would change is not known.
Modes rescale(const Modes& modes, double length, double modulus, double density);

/// How many of ascending eigenvalues to take when at most `maximum` are wanted: a cluster of
/// repeated ones (within 1e-4) is taken whole or left out, so that a sum over modes does not depend
/// on the basis within it. Only a cluster that begins the list is cut.
std::size_t whole_clusters(std::span<const double> eigenvalues, std::size_t maximum);

/// The modes of a set that lie in a band within the one it was made for, the lowest max_modes of
/// them. The certificate is exact as far as the set was complete; beyond, modes_in_band still
/// counts up to the first band's top.
Modes restrict_to(const Modes& modes, const Band& band);

/// "automatic", "direct" or "iterative".
std::string_view name_of(LinearSolver solver);
/// "block_lanczos", "krylov_schur", "lobpcg" or "dense".
std::string_view name_of(EigenSolver solver);
/// @throws InputError  no such name
LinearSolver parse_linear_solver(std::string_view name);
/// @param name  as name_of() gives it
/// @throws InputError  no such name
EigenSolver parse_eigen_solver(std::string_view name);

/// Straight triangles that follow the curved faces: each face cut into order^2 pieces. Vertices
/// are the surface's nodes, so mode shapes index alike.
mesh::SurfaceMesh flatten(const ModeSurface& surface);

}  // namespace carillon::solvers::modes
