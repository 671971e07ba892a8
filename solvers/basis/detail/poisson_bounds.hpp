#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

namespace carillon::solvers::basis {

/// The largest c with K(to) >= c K(from), K the stiffness at unit Young's modulus and a Poisson's
/// ratio: strain energy is a shear part, in proportion to 1 / (1 + nu), and a volume part, in
/// proportion to 1 / (1 - 2 nu), neither of which is negative. Every eigenvalue at `to` is at least
/// c times the one of the same number at `from`.
/// @param from, to  in (-1, 0.5)
double stiffness_ratio(double from, double to);

/// Weights w >= 0 with K(to) >= sum of w_i K(ratios_i): an exact combination of the two neighbours
/// where `to` lies between them, else stiffness_ratio() of the nearest.
/// @param ratios  ascending
std::vector<double> stiffness_weights(std::span<const double> ratios, double to);

/// Eigenpairs of a matrix of which none is missing below a value.
struct KnownSpectrum {
  double weight = 1;            ///< how often the matrix is counted
  Eigen::VectorXd eigenvalues;  ///< all that lie below `complete_below`
  double complete_below = 0;
  Eigen::MatrixXd vectors;  ///< orthonormal columns
};

/// Lower bound of x^T K x / x^T x over the x that are orthogonal to some trial vectors, where K is
/// at least the weighted sum of matrices of which a part of the spectrum is known.
///
/// Each is at least U L U^T + s (1 - U U^T), with eigenvectors U of eigenvalues L < s; the sum of
/// these minorants is minimised exactly.
///
/// @param trials  orthonormal columns, in the same coordinates
/// @return not above zero when nothing is known
double complement_bound(std::span<const KnownSpectrum> known, const Eigen::MatrixXd& trials);

/// What is known of the eigenvalues near Ritz values.
struct RitzBounds {
  /// The eigenvalue of number k lies in [lower[k], Ritz value k].
  Eigen::VectorXd lower;
  /// Below this there are as many eigenvalues as Ritz values, but for those between a Ritz value
  /// and its lower bound.
  double counted_below = 0;
};

/// Bounds from Schur's complement. With Ritz pairs (T, Y), their residuals R = K Y - M Y T, and K
/// at least `ceiling` M on the complement of Y, the number of eigenvalues below s < ceiling is that
/// of negative eigenvalues of T - s - R^T (K_c - s M_c)^-1 R (Haynsworth), K_c and M_c on the
/// complement, and R^T (K_c - s M_c)^-1 R <= G / (1 - s / ceiling) with
/// G >= R^T K_c^-1 R. So eigenvalues of T - G / (1 - s / ceiling) bound those below s.
///
/// @param ritz_values  ascending
/// @param gram         G
/// @param ceiling      complement_bound()
/// @param tightness    relative distance of a Ritz value and its bound from which on the count ends
RitzBounds bound_ritz_values(const Eigen::VectorXd& ritz_values, const Eigen::MatrixXd& gram,
                             double ceiling, double tightness);

}  // namespace carillon::solvers::basis
