#include "solvers/axisymmetric/detail/harmonic_search.hpp"

#include <fmt/core.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <unsupported/Eigen/KroneckerProduct>

#include "core/error.hpp"
#include "solvers/assembly/products.hpp"
#include "solvers/eigen/search_checks.hpp"
#include "solvers/elements/lobatto.hpp"

namespace carillon::solvers::axisymmetric {
namespace {

constexpr double target_residual = 1e-8;
constexpr std::int64_t spare_modes = 3;
constexpr int max_solves = 3;
/// Eigenvalues this close (relative) to where they were counted may fall on either side.
constexpr double smallest_gap = 1e-6;

int rigid_motions(int n) {
  return n < 2 ? 2 : 0;
}

/// Share of each pair's kinetic energy that is rigid.
Eigen::VectorXd rigid_fractions(const HarmonicForms& forms, int n, const eigen::EigenPairs& pairs) {
  const auto rigid = rigid_fields(forms, n);
  if (rigid.cols() == 0) return Eigen::VectorXd::Zero(pairs.size());
  Eigen::MatrixXd weighted = Eigen::MatrixXd::Zero(rigid.rows(), rigid.cols());
  const auto& graph = forms.graph;
  const double angle = n == 0 ? 2 * std::numbers::pi : std::numbers::pi;
  for (Eigen::Index row = 0; row < graph.rows(); ++row) {
    const auto r = static_cast<std::size_t>(row);
    for (auto i = graph.first[r]; i < graph.first[r + 1]; ++i) {
      const auto at = static_cast<std::size_t>(i);
      const Eigen::Index column = graph.column[at];
      weighted.middleRows<3>(3 * row) += angle * forms.mass[at] * rigid.middleRows<3>(3 * column);
    }
  }
  const Eigen::MatrixXd gram = rigid.transpose() * weighted;
  const Eigen::MatrixXd normal = gram.llt().matrixL().solve(weighted.transpose() * pairs.vectors);
  return normal.colwise().squaredNorm().transpose();
}

/// Splits off the rigid pairs. @return indices of flexible ones, ascending
std::vector<std::size_t> flexible_pairs(const HarmonicForms& forms, const eigen::EigenPairs& pairs,
                                        Harmonic& harmonic) {
  const auto fraction = rigid_fractions(forms, harmonic.n, pairs);
  std::vector<std::size_t> flexible;
  double contained = 0;
  harmonic.rigid = 0;
  for (Eigen::Index k = 0; k < pairs.size(); ++k) {
    if (fraction[k] > 0.5) {
      ++harmonic.rigid;
      contained += fraction[k];
    } else {
      flexible.push_back(static_cast<std::size_t>(k));
    }
  }
  const int wanted = rigid_motions(harmonic.n);
  if (harmonic.rigid != wanted || contained < wanted * (1 - 1e-6)) {
    throw core::SolverError(
        fmt::format("{} rigid motions found in harmonic {} of a body of revolution, which has {}",
                    harmonic.rigid, harmonic.n, wanted),
        "the section may have parts of almost no thickness");
  }
  return flexible;
}

/// The shift that modes are sought about, dimensionless: below the first of them by its size or
/// less, but not so little that rigid motions are nearly singular.
double first_shift(const HarmonicForms& forms, double estimate) {
  const double first = forms.scales.from_frequency(estimate);
  return -std::max(0.01 * first, std::min(forms.scales.from_frequency(20), first));
}

/// Values at the nodes of the same cells at a higher order.
/// @param fields  unknowns x fields
Eigen::MatrixXd prolong(const HarmonicForms& forms, const HarmonicForms& finer,
                        const Eigen::Ref<const Eigen::MatrixXd>& fields) {
  const Eigen::VectorXd& points = elements::lobatto_nodes(finer.mesh.order);
  Eigen::MatrixXd line(points.size(), forms.mesh.order + 1);
  for (Eigen::Index i = 0; i < points.size(); ++i)
    line.row(i) = elements::line_shapes(forms.mesh.order, points[i]).values.transpose();
  const Eigen::MatrixXd square = Eigen::kroneckerProduct(line, line);
  const auto nodes = static_cast<Eigen::Index>(finer.mesh.nodes.size());
  Eigen::MatrixXd out(3 * nodes, fields.cols());
  Eigen::MatrixXd own(square.cols(), fields.cols());
  for (std::size_t e = 0; e < forms.mesh.element_count(); ++e) {
    const auto coarse = forms.mesh.element(e), fine = finer.mesh.element(e);
    for (Eigen::Index c = 0; c < 3; ++c) {
      for (std::size_t k = 0; k < coarse.size(); ++k)
        own.row(static_cast<Eigen::Index>(k)) = fields.row(3 * coarse[k] + c);
      const Eigen::MatrixXd values = square * own;
      for (std::size_t k = 0; k < fine.size(); ++k)
        out.row(3 * fine[k] + c) = values.row(static_cast<Eigen::Index>(k));
    }
  }
  return out;
}

/// The flexible pairs become the harmonic's.
void keep(const eigen::SearchResult& found, Harmonic& harmonic) {
  const auto& pairs = found.pairs;
  harmonic.values.clear();
  harmonic.residuals.clear();
  for (const auto k : found.flexible) {
    harmonic.values.push_back(pairs.values[k]);
    harmonic.residuals.push_back(pairs.residuals[k]);
  }
  harmonic.vectors = pairs.vectors(Eigen::all, found.flexible);
  harmonic.orthonormality = pairs.orthonormality;
  harmonic.solver = pairs.solver;
}

}  // namespace

double largest_wave_number(const mesh::MeridianSize& size, const elements::Elastic& material,
                           double frequency) {
  const double omega = 2 * std::numbers::pi * frequency;
  const double nu = material.poisson_ratio;
  const double bar = std::sqrt(material.youngs_modulus / material.density);
  const double shear = bar / std::sqrt(2 * (1 + nu));
  const double bending = std::sqrt(omega * std::sqrt(12 * (1 - nu * nu)) / (bar * 0.5 * size.wall));
  // Viktorov 1967: c_R / c_T = (0.87 + 1.12 nu) / (1 + nu); below nu = 0 it falls to 0.69.
  const double rayleigh = shear * (nu > 0 ? (0.87 + 1.12 * nu) / (1 + nu) : 0.69);
  return 1.1 * std::max(bending, omega / rayleigh);
}

double estimate_first_frequency(const mesh::MeridianSize& size, const elements::Elastic& material) {
  const double speed = std::sqrt(material.youngs_modulus / material.density);
  const double length = size.longest_side();
  return speed * (2 * size.volume / size.surface) / (length * length);
}

std::vector<Harmonic> count_harmonics(const HarmonicForms& forms, const mesh::MeridianSize& size,
                                      double frequency, core::Trace& trace) {
  const core::ScopedTimer timer(trace.stages["count"]);
  const double maximum = largest_wave_number(size, forms.material, frequency) * size.largest_radius;
  const double top = forms.scales.from_frequency(frequency);
  std::vector<Harmonic> out;
  int empty = 0;
  for (int n = 0; empty < 3 || n <= maximum; ++n) {
    Harmonic harmonic;
    harmonic.n = n;
    harmonic.counted =
        eigen::count_below(harmonic_system(forms, n), top, forms.plan, MPI_COMM_SELF) -
        rigid_motions(n);
    if (harmonic.counted < 0) {
      throw core::SolverError(
          fmt::format("harmonic {} has fewer modes below {:.6g} Hz than rigid motions", n,
                      frequency),
          "the section may have parts of almost no thickness");
    }
    empty = harmonic.counted == 0 ? empty + 1 : 0;
    out.push_back(std::move(harmonic));
  }
  return out;
}

void solve_harmonic(const HarmonicForms& forms, double frequency, double estimate, double tolerance,
                    Harmonic& harmonic, core::Trace& trace) {
  const core::ScopedTimer timer(trace.stages["solve"]);
  const auto system = harmonic_system(forms, harmonic.n);
  const double top = forms.scales.from_frequency(frequency);
  double shift = first_shift(forms, estimate);
  const auto rigid = rigid_motions(harmonic.n);
  for (int solves = 1; solves <= max_solves; ++solves) {
    auto pairs = static_cast<int>(
        std::min(harmonic.counted + rigid + spare_modes * solves, system.unknowns()));
    const auto shifted = eigen::factor_shifted(system, shift, forms.plan, MPI_COMM_SELF);
    eigen::SearchResult found;
    found.pairs = eigen::lowest_pairs(
        system, {pairs, tolerance, static_cast<std::uint64_t>(solves)}, shifted, MPI_COMM_SELF);
    found.flexible = flexible_pairs(forms, found.pairs, harmonic);
    keep(found, harmonic);
    std::int64_t below = 0, doubtful = 0;
    for (const double value : harmonic.values) {
      below += value < top;
      doubtful += std::abs(value / top - 1) < 4 * smallest_gap;
    }
    // Near a shift that is too small rigid motions are nearly singular and residuals grow.
    const bool may_retry = solves < max_solves;
    if (eigen::worst_residual(found, below) > target_residual && may_retry &&
        -0.01 * harmonic.values[0] < 2 * shift) {
      shift = -0.01 * harmonic.values[0];
      continue;
    }
    eigen::refuse_bad_residuals(found, harmonic.counted, forms.scales);
    if (std::abs(below - harmonic.counted) <= doubtful) return;
    if (may_retry) continue;
    harmonic.verified_below = eigen::verified_prefix(found, rigid, [&](double value) {
      return eigen::count_below(system, value, forms.plan, MPI_COMM_SELF);
    });
  }
}

std::vector<double> next_order_values(const HarmonicForms& finer, const HarmonicForms& forms,
                                      const Harmonic& harmonic, double estimate) {
  const auto modes = std::min<Eigen::Index>(harmonic.counted, harmonic.vectors.cols());
  const auto system = harmonic_system(finer, harmonic.n);
  const double shift = first_shift(finer, estimate);
  const auto inverse = eigen::factored_inverse(system, shift, finer.plan, MPI_COMM_SELF);
  const assembly::Products products(system, MPI_COMM_SELF);
  // Rigid motions, modes, and what a step of inverse iteration adds to them.
  const Eigen::MatrixXd rigid = rigid_fields(finer, harmonic.n);
  const auto given = rigid.cols() + modes;
  Eigen::MatrixXd basis(system.unknowns(), given + modes);
  basis << rigid, prolong(forms, finer, harmonic.vectors.leftCols(modes)),
      Eigen::MatrixXd::Zero(system.unknowns(), modes);
  Eigen::MatrixXd forces(basis.rows(), basis.cols()), inertia = forces;
  const auto fill = [&](Eigen::Index first, Eigen::Index count) {
    products.shifted(shift, basis.middleCols(first, count), forces.middleCols(first, count));
    products.mass(basis.middleCols(first, count), inertia.middleCols(first, count));
  };
  fill(0, given);
  const auto fields = basis.middleCols(rigid.cols(), modes);
  const Eigen::ArrayXd theta =
      fields.cwiseProduct(forces.middleCols(rigid.cols(), modes)).colwise().sum().array() /
      fields.cwiseProduct(inertia.middleCols(rigid.cols(), modes)).colwise().sum().array();
  const Eigen::MatrixXd residual =
      inertia.middleCols(rigid.cols(), modes) * theta.matrix().asDiagonal() -
      forces.middleCols(rigid.cols(), modes);
  inverse(residual, basis.rightCols(modes));
  fill(given, modes);

  // Columns as long as each other.
  const Eigen::VectorXd scale = basis.cwiseProduct(inertia)
                                    .colwise()
                                    .sum()
                                    .transpose()
                                    .cwiseMax(std::numeric_limits<double>::min())
                                    .cwiseSqrt()
                                    .cwiseInverse();
  const auto projected = [&](const Eigen::MatrixXd& products) {
    const Eigen::MatrixXd form =
        scale.asDiagonal() * (basis.transpose() * products) * scale.asDiagonal();
    return Eigen::MatrixXd((form + form.transpose()) / 2);
  };
  const Eigen::MatrixXd a = projected(forces), m = projected(inertia);
  // Corrections that depend on the others but for rounding are left out.
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> independent(m);
  const auto kept = (independent.eigenvalues().array() > 1e-10).count();
  const Eigen::MatrixXd white =
      independent.eigenvectors().rightCols(kept) *
      independent.eigenvalues().tail(kept).cwiseSqrt().cwiseInverse().asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> ritz(white.transpose() * a * white);
  const Eigen::MatrixXd weights =
      scale.asDiagonal() * white * ritz.eigenvectors().middleCols(rigid.cols(), modes);
  auto values = rayleigh_quotients(finer, harmonic.n, basis * weights);
  std::sort(values.begin(), values.end());
  return values;
}

}  // namespace carillon::solvers::axisymmetric
