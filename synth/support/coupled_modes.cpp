#include "synth/support/coupled_modes.hpp"

#include <fmt/format.h>

#include <Eigen/LU>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <complex>
#include <numeric>

#include "core/error.hpp"
#include "solvers/dense/eigenpairs.hpp"

namespace carillon::synth::support {

namespace {

/// Condition of the eigenvectors up to which they are taken: 1e9 times rounding is -140 dB.
constexpr double smallest_reciprocal_condition = 1e-9;
/// What a mode feels of the dashpots, relative to its frequency, below which it is left as it is:
/// rounding in the eigenproblem is of that size.
constexpr double untouched = 1e-15;

}  // namespace

/// Column pair (2 j, 2 j + 1) belongs to oscillator j of the coupled part: real and imaginary part
/// of one eigenvector, or the eigenvectors of two real poles.
struct CoupledModes::Vectors {
  Eigen::MatrixXd displacement;  ///< of the m coupled modes, m x (2 m + r), r rigid coordinates
  Eigen::MatrixXd velocity;      ///< likewise
  Eigen::MatrixXd turn;          ///< to the turned velocities, m x (m + r)
  Eigen::PartialPivLU<Eigen::MatrixXd> amplitudes;  ///< state -> amplitudes of the columns
  std::vector<int> oscillator;                      ///< of column pair j: its place among all n
};

namespace {

void check(std::span<const double> eigenvalues, std::span<const double> decay_rates,
           const Eigen::MatrixXd& dashpots) {
  const std::size_t n = eigenvalues.size();
  if (decay_rates.size() != n ||
      (dashpots.cols() > 0 && dashpots.rows() < static_cast<Eigen::Index>(n))) {
    throw core::InputError(
        fmt::format("coupled modes: {} eigenvalues, {} decay rates and dashpots of {} coordinates",
                    n, decay_rates.size(), dashpots.rows()));
  }
  if (!dashpots.allFinite()) throw core::InputError("coupled modes: a dashpot is not finite");
  for (std::size_t i = 0; i < n; ++i) {
    if (!(eigenvalues[i] > 0) || !std::isfinite(eigenvalues[i])) {
      throw core::InputError(
          fmt::format("coupled modes: eigenvalue of mode {} must be positive and finite, not {}", i,
                      eigenvalues[i]),
          "rigid motions are rows of the dashpots below those of the modes");
    }
    if (!(decay_rates[i] >= 0) || !std::isfinite(decay_rates[i])) {
      throw core::InputError(
          fmt::format("coupled modes: decay rate of mode {} must be finite and not negative, "
                      "not {} 1/s",
                      i, decay_rates[i]));
    }
  }
}

/// Modes that feel the dashpots: an entry of L L^T is no larger than the product of its rows'
/// norms.
std::vector<int> touched_modes(std::span<const double> eigenvalues,
                               const Eigen::MatrixXd& dashpots) {
  std::vector<int> touched;
  if (dashpots.cols() == 0) return touched;
  const Eigen::VectorXd norms = dashpots.rowwise().norm();
  const double largest = norms.maxCoeff();
  for (Eigen::Index i = 0; i < static_cast<Eigen::Index>(eigenvalues.size()); ++i) {
    const double omega = std::sqrt(eigenvalues[static_cast<std::size_t>(i)]);
    if (norms[i] * largest > untouched * omega) touched.push_back(static_cast<int>(i));
  }
  return touched;
}

/// The rigid coordinates turned so that as few as can be feel the dashpots; the others drop out. An
/// even number: one that feels nothing is added where needed, so that all poles have a partner.
Eigen::MatrixXd touched_rigid(const Eigen::MatrixXd& rows) {
  if (rows.size() == 0 || rows.squaredNorm() == 0) return Eigen::MatrixXd(0, rows.cols());
  Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(rows);
  qr.setThreshold(1e-12);
  const Eigen::Index rank = qr.rank();
  const Eigen::MatrixXd upper = qr.matrixR().topRows(rank).triangularView<Eigen::Upper>();
  Eigen::MatrixXd touched = Eigen::MatrixXd::Zero(rank + rank % 2, rows.cols());
  touched.topRows(rank) = upper * qr.colsPermutation().transpose();
  return touched;
}

/// The coupled part in its first-order form: state (Q^T (q', rigid velocities), Omega q), whose
/// energy is its norm.
struct FirstOrder {
  Eigen::VectorXd omega;
  Eigen::MatrixXd turn;    ///< Q, (m + r) x (m + r)
  Eigen::MatrixXd matrix;  ///< 2 m + r rows
};

FirstOrder first_order(std::span<const double> eigenvalues, std::span<const double> decay_rates,
                       const Eigen::MatrixXd& dashpots, const std::vector<int>& coupled) {
  const auto n = static_cast<Eigen::Index>(eigenvalues.size());
  const auto m = static_cast<Eigen::Index>(coupled.size());
  const Eigen::MatrixXd rigid = touched_rigid(dashpots.bottomRows(dashpots.rows() - n));
  const Eigen::Index v = m + rigid.rows();
  FirstOrder form;
  form.omega.resize(m);
  Eigen::VectorXd own = Eigen::VectorXd::Zero(v);
  Eigen::MatrixXd columns(v, dashpots.cols());
  columns.bottomRows(rigid.rows()) = rigid;
  for (Eigen::Index i = 0; i < m; ++i) {
    const auto mode = static_cast<std::size_t>(coupled[static_cast<std::size_t>(i)]);
    form.omega[i] = std::sqrt(eigenvalues[mode]);
    own[i] = 2 * decay_rates[mode];
    columns.row(i) = dashpots.row(static_cast<Eigen::Index>(mode));
  }
  // L P = Q R: the strongest dashpots come first, and those of all columns stay in the first rows.
  const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(columns);
  form.turn = qr.householderQ() * Eigen::MatrixXd::Identity(v, v);
  const Eigen::Index rank = std::min(v, columns.cols());
  const Eigen::MatrixXd upper = qr.matrixR().topRows(rank).triangularView<Eigen::Upper>();
  Eigen::MatrixXd damping = form.turn.transpose() * own.asDiagonal() * form.turn;
  damping.topLeftCorner(rank, rank) += upper * upper.transpose();
  form.matrix.setZero(v + m, v + m);
  form.matrix.topLeftCorner(v, v) = -damping;
  form.matrix.bottomLeftCorner(m, v) = form.omega.asDiagonal() * form.turn.topRows(m);
  form.matrix.topRightCorner(v, m) = -form.matrix.bottomLeftCorner(m, v).transpose();
  return form;
}

/// Two poles of one oscillator and the columns of the eigenvectors that belong to them.
struct PolePair {
  double eigenvalue;
  double decay_rate;
  Eigen::Index first;
  Eigen::Index second;
};

std::vector<PolePair> pair_poles(const Eigen::VectorXcd& poles) {
  std::vector<PolePair> pairs;
  std::vector<Eigen::Index> real;
  for (Eigen::Index k = 0; k < poles.size(); ++k) {
    if (poles[k].imag() == 0) {
      real.push_back(k);
    } else {
      // Rounding may leave a pole without damping on the wrong side of the axis.
      pairs.push_back({std::norm(poles[k]), std::max(0.0, -poles[k].real()), k, k + 1});
      ++k;
    }
  }
  std::sort(real.begin(), real.end(),
            [&](Eigen::Index a, Eigen::Index b) { return poles[a].real() > poles[b].real(); });
  for (std::size_t k = 0; k + 1 < real.size(); k += 2) {
    const double first = std::max(0.0, -poles[real[k]].real());
    const double second = std::max(0.0, -poles[real[k + 1]].real());
    pairs.push_back({first * second, (first + second) / 2, real[k], real[k + 1]});
  }
  return pairs;
}

/// Gives each mode a pole pair, largest shares first; -1 for pairs that are left, those of rigid
/// motion. `fractions` is modes x pairs.
std::vector<int> match(const Eigen::MatrixXd& fractions) {
  const Eigen::Index m = fractions.rows();
  std::vector<Eigen::Index> order(static_cast<std::size_t>(fractions.size()));
  std::iota(order.begin(), order.end(), Eigen::Index{0});
  std::sort(order.begin(), order.end(), [&](Eigen::Index a, Eigen::Index b) {
    return fractions.data()[a] != fractions.data()[b] ? fractions.data()[a] > fractions.data()[b]
                                                      : a < b;
  });
  std::vector<int> mode_of(static_cast<std::size_t>(fractions.cols()), -1);
  std::vector<bool> taken(static_cast<std::size_t>(m), false);
  for (const Eigen::Index entry : order) {
    const auto mode = static_cast<std::size_t>(entry % m);
    const auto pair = static_cast<std::size_t>(entry / m);
    if (taken[mode] || mode_of[pair] >= 0) continue;
    mode_of[pair] = static_cast<int>(mode);
    taken[mode] = true;
  }
  return mode_of;
}

/// Adds the coupled part's oscillators; false when the eigenvectors are dependent.
bool add_coupled(CoupledModes& modes, const FirstOrder& form) {
  const Eigen::Index m = form.omega.size(), v = form.turn.rows();
  const solvers::dense::GeneralEigenpairs solution =
      solvers::dense::general_eigenpairs(form.matrix);
  const std::vector<PolePair> pairs = pair_poles(solution.values);
  Eigen::MatrixXd columns(m + v, m + v);
  for (std::size_t j = 0; j < pairs.size(); ++j) {
    const auto at = 2 * static_cast<Eigen::Index>(j);
    columns.col(at) = solution.vectors.col(pairs[j].first);
    columns.col(at + 1) = solution.vectors.col(pairs[j].second);
  }
  auto vectors = std::make_shared<CoupledModes::Vectors>();
  vectors->amplitudes.compute(columns);
  if (!(vectors->amplitudes.rcond() > smallest_reciprocal_condition)) return false;
  vectors->turn = form.turn.topRows(m);
  const Eigen::MatrixXd velocity = form.turn * columns.topRows(v);
  vectors->velocity = velocity.topRows(m);
  vectors->displacement = columns.bottomRows(m);
  Eigen::MatrixXd fractions(m, (m + v) / 2);
  for (Eigen::Index j = 0; j < fractions.cols(); ++j) {
    Eigen::VectorXd energy = velocity.middleCols<2>(2 * j).rowwise().squaredNorm();
    energy.head(m) += vectors->displacement.middleCols<2>(2 * j).rowwise().squaredNorm();
    fractions.col(j) = energy.head(m) / energy.sum();
  }
  vectors->displacement = form.omega.cwiseInverse().asDiagonal() * vectors->displacement;
  const std::vector<int> mode_of = match(fractions);
  for (std::size_t j = 0; j < pairs.size(); ++j) {
    if (mode_of[j] < 0) {
      vectors->oscillator.push_back(static_cast<int>(modes.eigenvalues.size()));
      modes.eigenvalues.push_back(pairs[j].eigenvalue);
      modes.decay_rates.push_back(pairs[j].decay_rate);
      continue;
    }
    const auto place =
        static_cast<std::size_t>(modes.coupled[static_cast<std::size_t>(mode_of[j])]);
    vectors->oscillator.push_back(static_cast<int>(place));
    modes.eigenvalues[place] = pairs[j].eigenvalue;
    modes.decay_rates[place] = pairs[j].decay_rate;
    modes.overlaps[place] = fractions(mode_of[j], static_cast<Eigen::Index>(j));
  }
  modes.vectors = std::move(vectors);
  return true;
}

}  // namespace

std::optional<CoupledModes> couple(std::span<const double> eigenvalues,
                                   std::span<const double> decay_rates,
                                   const Eigen::MatrixXd& dashpots) {
  check(eigenvalues, decay_rates, dashpots);
  CoupledModes modes;
  modes.eigenvalues.assign(eigenvalues.begin(), eigenvalues.end());
  modes.decay_rates.assign(decay_rates.begin(), decay_rates.end());
  modes.overlaps.assign(eigenvalues.size(), 1.0);
  modes.coupled = touched_modes(eigenvalues, dashpots);
  if (dashpots.cols() > 0) {
    // What is too little to couple still damps.
    std::vector<bool> is_coupled(eigenvalues.size(), false);
    for (const int mode : modes.coupled) is_coupled[static_cast<std::size_t>(mode)] = true;
    for (std::size_t i = 0; i < is_coupled.size(); ++i) {
      if (!is_coupled[i]) {
        modes.decay_rates[i] += dashpots.row(static_cast<Eigen::Index>(i)).squaredNorm() / 2;
      }
    }
  }
  if (modes.coupled.empty()) return modes;
  if (modes.coupled.size() > max_coupled_modes) {
    throw core::InputError(
        fmt::format("coupled modes: the supports touch {} modes, and at most {} can be coupled",
                    modes.coupled.size(), max_coupled_modes),
        "lower modes.max_modes or modes.max_frequency, or take supports.coupling: diagonal");
  }
  for (const double perturbation : {0.0, 1e-6, 1e-5, 1e-4}) {
    modes.perturbation = perturbation;
    if (add_coupled(modes, first_order(eigenvalues, decay_rates,
                                       std::sqrt(1 + perturbation) * dashpots, modes.coupled))) {
      return modes;
    }
  }
  return std::nullopt;
}

modal::RingDown coupled_ring_down(const CoupledModes& modes, const modal::RingDown& rings) {
  const auto n = static_cast<Eigen::Index>(modes.overlaps.size());
  const auto count = static_cast<Eigen::Index>(modes.eigenvalues.size());
  const modal::Readout& in = rings.readout;
  const auto rows = static_cast<Eigen::Index>(in.delays.size());
  bool fits = rings.excitation.size() == n;
  for (const Eigen::MatrixXd* gains : modal::gains_of(in)) {
    fits = fits && (gains->size() == 0 || (gains->rows() == rows && gains->cols() == n));
  }
  if (!fits) {
    throw core::InputError(fmt::format("coupled modes: {} oscillators for a ring-down of {} modes",
                                       n, rings.excitation.size()));
  }
  modal::RingDown out;
  out.eigenvalues = modes.eigenvalues;
  out.decay_rates = modes.decay_rates;
  out.excitation = Eigen::VectorXd::Ones(count);
  out.readout.delays = in.delays;
  out.readout.unit = in.unit;
  const auto scaled = [&](const Eigen::MatrixXd& gains) -> Eigen::MatrixXd {
    Eigen::MatrixXd all = Eigen::MatrixXd::Zero(rows, count);
    if (gains.size() > 0) all.leftCols(n) = gains * rings.excitation.asDiagonal();
    return all;
  };
  out.readout.displacement = scaled(in.displacement);
  out.readout.velocity = scaled(in.velocity);
  out.readout.acceleration = scaled(in.acceleration);
  out.readout.force_rate = scaled(in.force_rate);
  if (!modes.vectors) return out;

  // A unit impulse sets the coupled modes in motion with velocity e; oscillator j's fraction of
  // that start is displacement q0 and velocity v0 of the modes (sums over j: 0 and e).
  const CoupledModes::Vectors& vectors = *modes.vectors;
  const auto m = static_cast<Eigen::Index>(modes.coupled.size());
  Eigen::VectorXd start = Eigen::VectorXd::Zero(vectors.turn.cols() + m);
  Eigen::VectorXd struck(m);
  for (Eigen::Index i = 0; i < m; ++i) {
    struck[i] = rings.excitation[modes.coupled[static_cast<std::size_t>(i)]];
  }
  start.head(vectors.turn.cols()) = vectors.turn.transpose() * struck;
  const Eigen::VectorXd amplitudes = vectors.amplitudes.solve(start);
  const auto starts = [&](const Eigen::MatrixXd& columns, Eigen::Index j) -> Eigen::VectorXd {
    return columns.middleCols<2>(2 * j) * amplitudes.segment<2>(2 * j);
  };
  const auto read = [&](const Eigen::MatrixXd& gains, const Eigen::VectorXd& motion) {
    Eigen::VectorXd sum = Eigen::VectorXd::Zero(rows);
    if (gains.size() == 0) return sum;
    for (Eigen::Index i = 0; i < m; ++i) {
      sum += gains.col(modes.coupled[static_cast<std::size_t>(i)]) * motion[i];
    }
    return sum;
  };
  for (Eigen::Index j = 0; j < static_cast<Eigen::Index>(vectors.oscillator.size()); ++j) {
    const int place = vectors.oscillator[static_cast<std::size_t>(j)];
    const double lambda = modes.eigenvalues[static_cast<std::size_t>(place)];
    const double d = modes.decay_rates[static_cast<std::size_t>(place)];
    const Eigen::VectorXd q0 = starts(vectors.displacement, j);
    const Eigen::VectorXd v0 = starts(vectors.velocity, j);
    // With h the oscillator's answer to an impulse: q = q0 (h' + 2 d h) + v0 h,
    // q' = v0 h' - lambda q0 h, q'' = v0 h'' - lambda q0 h' (h'' with what follows the force).
    out.readout.displacement.col(place) =
        read(in.displacement, v0 + 2 * d * q0) - lambda * read(in.velocity, q0);
    out.readout.velocity.col(place) =
        read(in.displacement, q0) + read(in.velocity, v0) - lambda * read(in.acceleration, q0);
    out.readout.acceleration.col(place) = read(in.acceleration, v0);
    out.readout.force_rate.col(place) = read(in.force_rate, v0);
  }
  return out;
}

}  // namespace carillon::synth::support
