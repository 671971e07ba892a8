#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "solvers/elements/elastic.hpp"

namespace carillon::solvers::elements {

/// Constants of an element in whatever unit the caller works in: Lame's or, where there is one, a
/// stiffness in their place.
struct ElasticConstants {
  double lambda = 0;
  double mu = 0;
  double density = 0;
  std::optional<Voigt> stiffness = {};
};
ElasticConstants isotropic_constants(double youngs_modulus, double poisson_ratio, double density);

using Coordinates = Eigen::Matrix<double, 3, Eigen::Dynamic>;

/// Stiffness and mass of one Lagrange tetrahedron. Straight elements are integrated exactly;
/// curved ones with rules that are exact for the polynomial part (mass of order 2: exact too).
class ElementKernel {
 public:
  explicit ElementKernel(int order);

  /// Prepares an element at its nodes (3 x nodes).
  /// @return the smallest Jacobian determinant at the quadrature points and corners; the element
  ///         is unusable when it is not positive
  double place(const Coordinates& nodes);

  /// Of the element placed last: stiffness, 3 nodes x 3 nodes, unknowns node by node (x, y, z).
  void stiffness(const ElasticConstants& material, Eigen::MatrixXd& k);
  /// Consistent mass of one displacement component, nodes x nodes.
  void mass(double density, Eigen::MatrixXd& m);

  /// Energies of displacement fields on the element placed last, from strains at the quadrature
  /// points: the rigid part cancels before it is squared, so they are far more accurate than
  /// x^T K x.
  /// @param u  nodes x 3 fields: columns 3 f + component
  /// @param strain, kinetic  u^T K u and u^T M u, added to, one for each field
  void add_energies(const ElasticConstants& material, const Eigen::Ref<const Eigen::MatrixXd>& u,
                    Eigen::Ref<Eigen::ArrayXd> strain, Eigen::Ref<Eigen::ArrayXd> kinetic);

  int nodes() const { return nodes_; }

 private:
  /// Shape functions at the points of one rule.
  struct Table {
    Eigen::VectorXd weights;
    Eigen::MatrixXd values;               ///< nodes x points
    std::vector<Eigen::MatrixXd> slopes;  ///< at each point nodes x 3, by the last 3 barycentric
  };
  Table tabulate(int points) const;
  double map(const Coordinates& nodes, const Table& table, Eigen::MatrixXd& gradients,
             Eigen::VectorXd& volumes) const;

  int order_;
  int nodes_;
  Eigen::MatrixXd to_straight_;  ///< corners (4) -> nodes of the straight element
  Table straight_, curved_, curved_mass_;
  std::vector<Eigen::MatrixXd> corner_slopes_;
  Eigen::MatrixXd reference_mass_;  ///< for unit determinant, exact
  Eigen::MatrixXd reference_root_;  ///< its Cholesky factor, transposed

  bool is_straight_ = true;
  double determinant_ = 0;        ///< of a straight element
  Eigen::MatrixXd gradients_;     ///< nodes x 3 points, physical: point after point, x y z
  Eigen::VectorXd volumes_;       ///< weight times determinant at each point
  Eigen::VectorXd mass_volumes_;  ///< the same on the mass rule; curved only
  Eigen::MatrixXd weighted_, products_;
};

}  // namespace carillon::solvers::elements
