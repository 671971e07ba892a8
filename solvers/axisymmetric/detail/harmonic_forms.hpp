#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "solvers/assembly/assemble.hpp"
#include "solvers/eigen/factor.hpp"
#include "solvers/mesh/meridian.hpp"

namespace carillon::solvers::axisymmetric {

/// Displacements of harmonic n about the axis: u_r = U cos n theta, u_theta = V sin n theta,
/// u_z = W cos n theta (n = 0: V is a rotation by itself, taken with cos). The unknowns at a node
/// are A = (U - V) / sqrt 2, B = (U + V) / sqrt 2 and W: in them the conditions on the axis hold
/// single unknowns, and the mass is the same number for all three.
struct CylinderFields {
  Eigen::VectorXd radial, around, axial;  ///< U, V, W
};
/// @param unknowns  A B W of each node
CylinderFields cylinder_fields(const Eigen::Ref<const Eigen::VectorXd>& unknowns);
Eigen::VectorXd unknowns_of(const CylinderFields& fields);

/// Integrals over a section from which the matrices of every harmonic are made, dimensionless.
struct HarmonicForms {
  mesh::MeridianMesh mesh;
  assembly::Scales scales;
  elements::Elastic material;
  assembly::NodeGraph graph;
  /// For each graph.column the integrals of phi_i phi_j r over the section, i and j running over
  /// d/dr, d/dz and 1/r of the two shape functions; row-major.
  std::vector<std::array<double, 9>> products;
  std::vector<double> mass;  ///< of shape functions
  eigen::FactorPlan plan;    ///< every harmonic's matrices have the same pattern
};

/// In a material of modulus and density 1.
/// @throws core::SolverError  a cell is turned inside out
HarmonicForms harmonic_forms(mesh::MeridianMesh mesh);

/// The same section in another material: integrals and plan are kept.
HarmonicForms in_material(HarmonicForms forms, const elements::Elastic& material);

/// K and M of one harmonic, exact in the angle. Unknowns that are zero on the axis by regularity
/// (n = 0: U and V; n = 1: U + V and W; above: all three) are cut off from the rest and held by
/// springs so stiff that eigenvalues change by less than rounding.
assembly::System harmonic_system(const HarmonicForms& forms, int n);

/// u^T K u / u^T M u of fields of one harmonic, dimensionless, from strains at quadrature points:
/// keeps its digits on thin walls.
/// @param vectors  unknowns x modes
std::vector<double> rayleigh_quotients(const HarmonicForms& forms, int n,
                                       const Eigen::Ref<const Eigen::MatrixXd>& vectors);

/// Rigid motions among the fields of harmonic n, as columns: n = 0 along and about the axis,
/// n = 1 across it and about a line across it; none above.
Eigen::MatrixXd rigid_fields(const HarmonicForms& forms, int n);

/// Volume of the body times density [kg].
double mass_of(const HarmonicForms& forms);

}  // namespace carillon::solvers::axisymmetric
