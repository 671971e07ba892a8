#pragma once

#include <Eigen/Core>
#include <span>
#include <string>
#include <vector>

#include "solvers/modes/modes.hpp"
#include "synth/support/support_contacts.hpp"
#include "synth/surface/rigid_body.hpp"

namespace carillon::synth::support {

/// What holds a body. A contact pressed with a force F resists velocity v with
/// -c (n n^T + friction (I - n n^T)) v, c = coefficient F. Whatever the force, a spring k and a
/// dashpot r beside it resist displacement u and velocity with -(n n^T + shear (I - n n^T)) times
/// (k u + r v): k = stiffness + bed_stiffness A, r likewise, A the area that touches.
struct SupportKind {
  std::string name;
  double coefficient = 0;  ///< dashpot per contact force [s/m], >= 0
  double friction = 0;     ///< mu: fraction of the dashpot that acts along the surface, >= 0
  std::string source = {};
  double stiffness = 0;       ///< of each place [N/m]; all these are >= 0
  double resistance = 0;      ///< [N s/m]
  double bed_stiffness = 0;   ///< for the area that touches [N/m^3]
  double bed_resistance = 0;  ///< [N s/m^3]
  double shear = 0.8;  ///< Mindlin 1949: 2 (1 - nu) / (2 - nu) of a contact that sticks, nu 1/3

  double spring(double area) const { return stiffness + bed_stiffness * area; }     ///< [N/m]
  double dashpot(double area) const { return resistance + bed_resistance * area; }  ///< [N s/m]
  bool gives_way() const { return stiffness > 0 || bed_stiffness > 0; }
};

/// What touches (`finger`, `string`, `foam`, `table`) and what bears and fixes (`felt`, `rubber`,
/// `screw`, `soil`). The papers give the form of the damping and no numbers for it: the first are
/// chosen, and `source` says so.
const std::vector<SupportKind>& preset_supports();

/// A preset by name.
/// @throws InputError  unknown; names the nearest
SupportKind parse_support(const std::string& name);

/// @throws InputError  a number that is negative or not finite
void check_support(const SupportKind& kind);

/// Factor L of the damping that contacts add for coefficient times force = 1 N s/m, and of the
/// stiffness that they add for 1 N/m:
///   L L^T = sum_k share_k Phi_k^T (mu I + (1 - mu) n_k n_k^T) Phi_k,
/// Phi_k the mode shapes at contact k, 3 x n (Sterling et al. 2019, eq. 21; dissertation eq. 4.16,
/// after Zheng and James 2011). The bracket is n n^T + mu (I - n n^T), so L L^T is positive
/// semidefinite for every mu >= 0. The damping of q'' + (2 diag(d) + G) q' + Lambda q = f is then
/// G = (coefficient force) L L^T [1/s].
/// @param rigid  the body as a whole, whose six shapes follow below those of the modes; null: none
/// @return n rows, and six with `rigid` [kg^-1/2], at most 3 columns per contact and as many as
/// rows
/// @throws InputError  friction negative or not finite, a normal that is no unit vector, a fraction
///                     that is negative or not finite, a point that is not on the surface
Eigen::MatrixXd contact_factor(const solvers::modes::Modes& modes,
                               std::span<const Contact> contacts, double friction,
                               const surface::RigidBody* rigid = nullptr);

/// L for a force: sqrt(coefficient force) times that of contact_factor().
/// @throws InputError  a force that is negative or not finite, or more damping than can be computed
///                     with (above 1e50 1/s)
Eigen::MatrixXd dashpots(const Eigen::MatrixXd& unit, double coefficient, double force);

/// The diagonal answer: adds coefficient force G_ii / 2 to decay rates, from the diagonal of
/// contact_factor()' L L^T alone.
/// @param unit_diagonal  of L L^T, n values [1/kg]
/// @throws InputError  as dashpots(); sizes that do not match
void add_support_damping(std::vector<double>& decay_rates, const Eigen::VectorXd& unit_diagonal,
                         double coefficient, double force);

/// Weight of a body [N] where g = 9.80665 m/s^2 (standard gravity).
double weight(const solvers::modes::Modes& modes);

}  // namespace carillon::synth::support
