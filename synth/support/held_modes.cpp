#include "synth/support/held_modes.hpp"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/error.hpp"
#include "solvers/dense/eigenpairs.hpp"

namespace carillon::synth::support {

namespace {

using solvers::modes::Modes;
using solvers::modes::ModeShapes;

/// diag(lambda, 0) + S S^T of the lowest `count` free modes and the body as a whole.
Eigen::MatrixXd held_stiffness(const Modes& free, const Eigen::MatrixXd& springs,
                               Eigen::Index count) {
  Eigen::MatrixXd rows(count + 6, springs.cols());
  rows << springs.topRows(count), springs.bottomRows<6>();
  Eigen::MatrixXd stiffness = rows * rows.transpose();
  for (Eigen::Index i = 0; i < count; ++i) {
    stiffness(i, i) += free.eigenvalues[static_cast<std::size_t>(i)];
  }
  return stiffness;
}

/// Compliance that a range of the free modes lends to the springs' ends: the sum of s_i^T s_i over
/// lambda_i, s_i their rows of S.
Eigen::MatrixXd compliance(const Modes& free, const Eigen::MatrixXd& springs, Eigen::Index first,
                           Eigen::Index end) {
  Eigen::MatrixXd rows = springs.middleRows(first, end - first);
  for (Eigen::Index i = first; i < end; ++i) {
    rows.row(i - first) /= std::sqrt(free.eigenvalues[static_cast<std::size_t>(i)]);
  }
  return rows.transpose() * rows;
}

/// By how much each eigenvalue may be too high for want of the modes above the free ones, relative
/// to itself: the larger of two estimates, each with caution enough for the plates and bars of
/// tests/hard/held_modes_hard_test.cpp.
///
/// The modes above would give way with a compliance T and leave S (I + T)^-1 S^T of the springs; T
/// is taken as that of the upper half of the free modes over r - 1, where it falls by r from the
/// quarter below to that half. That sees springs that are soft beside the body. And leaving out the
/// upper half makes a step, which sees those that are stiff.
/// @param first    of the eigenpairs among all
/// @param vectors  of the eigenpairs
std::vector<double> cut_errors(const Modes& free, const Eigen::MatrixXd& springs,
                               Eigen::Index first, const Eigen::VectorXd& eigenvalues,
                               const Eigen::MatrixXd& vectors) {
  constexpr double slowest = 1.5, fastest = 16;  ///< r of points on solids and of lines on plates
  constexpr double of_compliance = 4, of_step = 2.5;
  const auto n = static_cast<Eigen::Index>(free.size());
  Eigen::MatrixXd beyond = compliance(free, springs, n / 2, n);
  const double half = beyond.trace();
  const double ratio = half > 0 ? std::clamp(compliance(free, springs, n / 4, n / 2).trace() / half,
                                             slowest, fastest)
                                : fastest;
  beyond *= of_compliance / (ratio - 1);
  beyond.diagonal().array() += 1;
  const Eigen::MatrixXd strains = springs.transpose() * vectors;
  const Eigen::MatrixXd kept = beyond.ldlt().solve(strains);
  const Eigen::VectorXd fewer =
      solvers::dense::symmetric_eigenvalues(held_stiffness(free, springs, n / 2));
  std::vector<double> errors;
  for (Eigen::Index j = 0; j < eigenvalues.size(); ++j) {
    const double soft = strains.col(j).dot(strains.col(j) - kept.col(j));
    // Beyond the smaller space the last known step counts.
    const Eigen::Index same = std::min(first + j, fewer.size() - 1);
    const double stiff = of_step * std::max(0.0, fewer[same] - eigenvalues[j]);
    errors.push_back(std::max(soft, stiff) / eigenvalues[j]);
  }
  return errors;
}

/// Shapes of the free modes and of the body as a whole, mixed.
ModeShapes mix_shapes(const Modes& free, const surface::RigidBody& rigid,
                      const Eigen::MatrixXd& parts) {
  const auto n = static_cast<Eigen::Index>(free.size());
  const auto nodes = static_cast<Eigen::Index>(free.surface.nodes.size());
  ModeShapes::Rows as_a_whole(6, 3 * nodes);
  for (Eigen::Index node = 0; node < nodes; ++node) {
    as_a_whole.middleCols<3>(3 * node) =
        surface::rigid_shapes_at(rigid, free.surface.nodes[static_cast<std::size_t>(node)])
            .cast<float>();
  }
  const Eigen::MatrixXf weights = parts.cast<float>();
  ModeShapes::Rows rows = weights.bottomRows<6>().transpose() * as_a_whole;
  rows.noalias() += weights.topRows(n).transpose() * free.shapes.at_nodes();
  for (Eigen::Index j = 0; j < rows.rows(); ++j) {
    Eigen::Index at = 0;
    rows.row(j).cwiseAbs().maxCoeff(&at);
    if (rows(j, at) < 0) rows.row(j) = -rows.row(j);
  }
  return ModeShapes(std::move(rows));
}

/// Each row's sum made one.
Eigen::MatrixXd shares_of(const Eigen::MatrixXd& weights, const Eigen::MatrixXd& of_free) {
  Eigen::MatrixXd shares = weights.transpose() * of_free;
  for (Eigen::Index j = 0; j < shares.rows(); ++j) {
    const double sum = shares.row(j).sum();
    if (sum > 0) {
      shares.row(j) /= sum;
    } else {
      shares.row(j).setConstant(1.0 / static_cast<double>(shares.cols()));
    }
  }
  return shares;
}

void check_held(const Modes& free, std::span<const double> decay_rates,
                const Eigen::MatrixXd& springs) {
  if (decay_rates.size() != free.size() ||
      springs.rows() != static_cast<Eigen::Index>(free.size()) + 6) {
    throw core::InputError(
        fmt::format("springs: {} decay rates and {} rows of springs for {} modes",
                    decay_rates.size(), springs.rows(), free.size()));
  }
  if (!springs.allFinite() || !std::isfinite(springs.squaredNorm())) {
    throw core::InputError("springs: a stiffness that is not finite");
  }
}

}  // namespace

HeldModes hold_modes(const Modes& free, std::span<const double> decay_rates,
                     const surface::RigidBody& rigid, const Eigen::MatrixXd& springs) {
  check_held(free, decay_rates, springs);
  const auto n = static_cast<Eigen::Index>(free.size());
  Eigen::MatrixXd vectors = held_stiffness(free, springs, n);
  const Eigen::VectorXd eigenvalues = solvers::dense::symmetric_eigenpairs(vectors);

  const double omega = 2 * std::numbers::pi * free.certificate.min_frequency;
  // Of a set that ends before its band does, what lies beyond its end is not known.
  const double top = 2 * std::numbers::pi * free.certificate.max_frequency;
  const double highest = free.certificate.complete ? top * top
                         : n > 0                   ? free.eigenvalues.back() * (1 + 1e-9)
                                                   : 0;
  Eigen::Index first = 0, end = 0;
  for (Eigen::Index j = 0; j < eigenvalues.size(); ++j) {
    if (eigenvalues[j] < omega * omega) first = j + 1;
    if (eigenvalues[j] <= highest) end = j + 1;
  }
  const Eigen::Index count = std::max<Eigen::Index>(0, end - first);
  const Eigen::MatrixXd parts = vectors.middleCols(std::min(first, end), count);
  const Eigen::MatrixXd weights = parts.topRows(n).cwiseAbs2();

  HeldModes held;
  Modes& modes = held.modes;
  modes.surface = free.surface;
  modes.mass = free.mass;
  modes.certificate = free.certificate;
  modes.certificate.modes_in_band = modes.certificate.modes_found = count;
  modes.certificate.count_verified = false;
  modes.certificate.rigid_modes = static_cast<int>(std::min<Eigen::Index>(first, 6));
  modes.eigenvalues.assign(eigenvalues.data() + first, eigenvalues.data() + first + count);
  const Eigen::VectorXd residuals =
      weights.transpose() * Eigen::Map<const Eigen::VectorXd>(free.residuals.data(), n);
  modes.residuals.assign(residuals.begin(), residuals.end());
  modes.kinetic_fraction = shares_of(weights, free.kinetic_fraction);
  const Eigen::Map<const Eigen::VectorXd> lambda(free.eigenvalues.data(), n);
  modes.strain_fraction = shares_of(lambda.asDiagonal() * weights, free.strain_fraction);
  modes.shapes = mix_shapes(free, rigid, parts);

  const Eigen::Map<const Eigen::VectorXd> decay(decay_rates.data(), n);
  const Eigen::VectorXd damped = weights.transpose() * decay;
  held.decay_rates.assign(damped.begin(), damped.end());
  if (free.pitch_errors.empty()) return held;
  const std::vector<double> cut =
      cut_errors(free, springs, first, eigenvalues.segment(first, count), parts);
  for (Eigen::Index j = 0; j < count; ++j) {
    // By first order: a change of a free mode's eigenvalue reaches this one's by its share.
    double cents = 600 * std::log2(1 + cut[static_cast<std::size_t>(j)]);
    for (Eigen::Index i = 0; i < n; ++i) {
      cents += weights(i, j) * lambda[i] / eigenvalues[first + j] *
               free.pitch_errors[static_cast<std::size_t>(i)];
    }
    modes.pitch_errors.push_back(cents);
  }
  return held;
}

}  // namespace carillon::synth::support
