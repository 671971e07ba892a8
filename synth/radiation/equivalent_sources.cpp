#include "synth/radiation/equivalent_sources.hpp"

#include <Eigen/LU>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "synth/radiation/detail/source_layers.hpp"
#include "synth/surface/outer_surface.hpp"

namespace carillon::synth::radiation {

namespace {

using Complex = std::complex<double>;

constexpr double patches_per_layer = 2;
constexpr double triangles_per_patch = 10;
/// Modes whose phase over the body differs by less share one factorisation [rad].
constexpr double same_phase = 1e-3;

/// Volume velocities of every mode through every patch [m^2], and the part of the normal velocity's
/// squared norm that neither a constant nor a slope over the patch can make.
struct PatchMotion {
  Eigen::MatrixXd flux;        ///< patches x modes
  Eigen::VectorXd norm;        ///< of the normal velocity, squared
  Eigen::VectorXd unresolved;  ///< of it
};

PatchMotion patch_motion(const solvers::modes::Modes& modes, const surface::OuterTriangles& surface,
                         const surface::SurfacePatches& patches) {
  const Eigen::MatrixXd by_triangle =
      (modes.shapes.at_nodes().cast<double>() * surface.flux_weights).transpose();
  PatchMotion motion;
  motion.flux.resize(static_cast<Eigen::Index>(patches.size()), by_triangle.cols());
  motion.norm = Eigen::VectorXd::Zero(by_triangle.cols());
  motion.unresolved = motion.norm;
  for (std::size_t patch = 0; patch < patches.size(); ++patch) {
    const std::vector<int>& members = patches.members[patch];
    const auto count = static_cast<Eigen::Index>(members.size());
    Eigen::MatrixXd velocity = Eigen::MatrixXd::Zero(count, by_triangle.cols());
    Eigen::MatrixXd slopes = Eigen::MatrixXd::Zero(count, 4);
    Eigen::RowVectorXd flux = Eigen::RowVectorXd::Zero(by_triangle.cols());
    for (Eigen::Index row = 0; row < count; ++row) {
      const auto t = static_cast<std::size_t>(members[static_cast<std::size_t>(row)]);
      flux += by_triangle.row(static_cast<Eigen::Index>(t));
      if (!(surface.areas[t] > 0)) continue;
      // Weighted by the root of the area, so that sums of squares are integrals.
      const double root = std::sqrt(surface.areas[t]);
      velocity.row(row) = by_triangle.row(static_cast<Eigen::Index>(t)) / root;
      slopes(row, 0) = root;
      slopes.row(row).tail<3>() =
          root / patches.spacing * (surface.centres[t] - patches.centres[patch]).transpose();
    }
    motion.flux.row(static_cast<Eigen::Index>(patch)) = flux;
    motion.norm += velocity.colwise().squaredNorm().transpose();
    const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> factor(slopes);
    velocity.applyOnTheLeft(factor.householderQ().adjoint());
    const Eigen::Index rank = factor.rank();
    motion.unresolved += velocity.bottomRows(count - rank).colwise().squaredNorm().transpose();
  }
  return motion;
}

std::size_t layer_count(const surface::OuterTriangles& surface, double highest_wavenumber,
                        const EquivalentSourcesOptions& options) {
  const double per_metre = options.per_wavelength * highest_wavenumber / (2 * std::numbers::pi);
  const double wanted = surface.area * per_metre * per_metre;
  return static_cast<std::size_t>(std::clamp(wanted, static_cast<double>(options.min_sources),
                                             static_cast<double>(options.max_sources)));
}

}  // namespace

EquivalentSources fit_equivalent_sources(const solvers::modes::Modes& modes,
                                         const EquivalentSourcesOptions& options) {
  const std::vector<double> k_of = wavenumbers(modes);
  const double highest = k_of.empty() ? 0 : *std::max_element(k_of.begin(), k_of.end());
  // The number of layers follows from the area, which any cut gives nearly enough.
  const std::size_t layer_number =
      layer_count(surface::outer_triangles(modes.surface, 1), highest, options);
  const auto patch_number =
      static_cast<std::size_t>(patches_per_layer * static_cast<double>(layer_number));
  const surface::OuterTriangles surface = surface::outer_triangles(
      modes.surface, static_cast<std::size_t>(triangles_per_patch) * patch_number);
  SourceLayers layers = source_layers(surface, patch_number, layer_number);
  const PatchMotion motion = patch_motion(modes, surface, layers.patches);

  EquivalentSources fit;
  fit.layers = static_cast<std::size_t>(layers.strengths.cols());
  fit.patches = layers.patches.size();
  fit.nearest = std::sqrt(surface.area / static_cast<double>(patch_number));
  fit.centroid = surface::outer_hull(modes.surface).centroid;
  fit.amplitudes.resize(layers.strengths.cols(), static_cast<Eigen::Index>(modes.size()));
  fit.residuals.resize(modes.size());
  fit.decay_rates.resize(modes.size());
  fit.wavenumbers.resize(modes.size());

  // The boundary condition is tested by the layers' own functions, averaged over patches: they sum
  // to one, so that the body's whole volume velocity is exact, and the singular velocities beside
  // sharp rims, which no smooth layer has, do not weigh as they would in a sum of squares.
  Eigen::VectorXd areas(static_cast<Eigen::Index>(fit.patches));
  for (std::size_t patch = 0; patch < fit.patches; ++patch) {
    areas[static_cast<Eigen::Index>(patch)] = layers.patches.areas[patch];
  }
  const Eigen::SparseMatrix<double> tests =
      (areas.cwiseInverse().asDiagonal() * layers.patch_strengths).transpose();
  const Eigen::SparseMatrix<Complex> complex_tests = tests.cast<Complex>();
  for (std::size_t first = 0; first < modes.size();) {
    std::size_t last = first + 1;
    while (last < modes.size() && std::abs(k_of[last] - k_of[first]) * layers.size < same_phase) {
      ++last;
    }
    const double k = (k_of[first] + k_of[last - 1]) / 2;
    const Eigen::MatrixXcd fluxes = layer_fluxes(layers, k);
    // Motion of unit modal acceleration: the gradient of pressure is -rho times the acceleration.
    const Eigen::MatrixXd wanted =
        -modal::air_density * motion.flux.middleCols(static_cast<Eigen::Index>(first),
                                                     static_cast<Eigen::Index>(last - first));
    const Eigen::MatrixXcd system = complex_tests * fluxes;
    const Eigen::MatrixXcd tested = (tests * wanted).cast<Complex>();
    const Eigen::MatrixXcd strengths = system.partialPivLu().solve(tested);
    const Eigen::MatrixXcd left = wanted - fluxes * strengths;
    const Eigen::VectorXd power = radiated_power(layers, k, strengths);
    for (std::size_t mode = first; mode < last; ++mode) {
      const auto column = static_cast<Eigen::Index>(mode - first);
      const auto m = static_cast<Eigen::Index>(mode);
      const double norm = motion.norm[m];
      const double rest = left.col(column).cwiseAbs2().cwiseQuotient(areas).sum() /
                          (modal::air_density * modal::air_density);
      fit.wavenumbers[mode] = k;
      // Of unit acceleration the energy is 1 / (2 lambda), and power is 2 d times it.
      fit.decay_rates[mode] = power[column] * modes.eigenvalues[mode];
      fit.residuals[mode] = norm > 0 ? std::sqrt((rest + motion.unresolved[m]) / norm) : 0;
    }
    fit.amplitudes.middleCols(static_cast<Eigen::Index>(first), strengths.cols()) = strengths;
    first = last;
  }
  fit.size = layers.size;
  fit.points = std::move(layers.points);
  fit.directions = std::move(layers.directions);
  fit.strengths = layers.strengths;
  fit.outline = surface.mesh;
  return fit;
}

}  // namespace carillon::synth::radiation
