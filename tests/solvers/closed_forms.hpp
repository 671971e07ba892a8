#pragma once

#include <Eigen/Core>
#include <array>
#include <string>
#include <vector>

namespace carillon::test {

/// Flexible frequencies [Hz] of a free box by Rayleigh-Ritz with products of Legendre polynomials
/// (Visscher et al. 1991), ascending, from above. Shares nothing with the elements.
/// @param sides    [m]
/// @param degrees  highest degree along each axis
std::vector<double> box_frequencies(const std::array<double, 3>& sides,
                                    const std::array<int, 3>& degrees, double youngs_modulus,
                                    double poisson_ratio, double density, std::size_t count);
/// The same of an orthotropic solid whose axes are the box's, by its stiffness [Pa] in Voigt's
/// order.
std::vector<double> box_frequencies(const std::array<double, 3>& sides,
                                    const std::array<int, 3>& degrees,
                                    const Eigen::Matrix<double, 6, 6>& stiffness, double density,
                                    std::size_t count);

/// A root of the free sphere's characteristic equations (Lamb 1882).
struct SphereMode {
  char type;   ///< T torsional, S spheroidal
  int degree;  ///< l; the mode comes 2 l + 1 times
  double frequency;
};

/// Every mode of a free sphere below a frequency, ascending, each root once.
std::vector<SphereMode> sphere_modes(double radius, double youngs_modulus, double poisson_ratio,
                                     double density, double max_frequency);

/// Pitch distance in cents, a above b.
double cents(double a, double b);

/// Column of a CSV file by the name in its header line; lines that begin with # are left out.
std::vector<std::string> csv_column(const std::string& path, const std::string& name);

}  // namespace carillon::test
