#include "solvers/axisymmetric/detail/harmonic_search.hpp"

#include <fmt/core.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/error.hpp"
#include "solvers/eigen/search_checks.hpp"

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
  const double first = forms.scales.from_frequency(estimate);
  double shift = -std::max(0.01 * first, std::min(forms.scales.from_frequency(20), first));
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

}  // namespace carillon::solvers::axisymmetric
