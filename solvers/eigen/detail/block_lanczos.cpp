#include "solvers/eigen/detail/block_lanczos.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "core/error.hpp"
#include "mpi/comm.hpp"
#include "solvers/eigen/detail/reduced.hpp"

namespace carillon::solvers::eigen {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using Block = Eigen::Ref<MatrixXd>;

/// What is left of a vector that lay in the span of others: rounding.
constexpr double lost = 100 * std::numeric_limits<double>::epsilon();
/// A residual of this fraction of the largest value is rounding: no step makes it smaller.
constexpr double rounding = 0.5 * std::numeric_limits<double>::epsilon();
/// Smallest pivot ratio at which a Cholesky factor of a Gram matrix is trusted.
constexpr double well_conditioned = 1e-10;
/// Rows treated at a time when the basis is turned in place.
constexpr Index chunk_rows = 2048;

class Lanczos {
 public:
  Lanczos(const LanczosProblem& problem, const LanczosOptions& options)
      : problem_(problem),
        options_(options),
        block_(std::min<Index>(options.block, problem.total)),
        wanted_(std::min<Index>(options.pairs, problem.total)),
        basis_(lanczos_basis(problem.total, wanted_, block_, options.basis)),
        look_at_(wanted_ + block_),
        v_(problem.owned, basis_),
        t_(MatrixXd::Zero(basis_, basis_)) {}

  LanczosResult run() {
    start();
    for (;;) {
      // One block is kept in hand: its coupling to the basis tells the residuals.
      expand();
      const bool full = used_ + next_.cols() > basis_ || used_ == problem_.total;
      if (!full && !worth_a_look()) continue;
      project();
      if (converged_ >= wanted_ || used_ == problem_.total ||
          (full && result_.restarts == options_.max_restarts)) {
        break;
      }
      if (full) restart();
    }
    finish();
    return std::move(result_);
  }

 private:
  MatrixXd product(const Eigen::Ref<const MatrixXd>& a, const Eigen::Ref<const MatrixXd>& b) const {
    MatrixXd out(a.cols(), b.cols());
    out.noalias() = a.transpose() * b;
    sum_alike(out, problem_.comm);
    return out;
  }

  void start() {
    next_.resize(problem_.owned, block_);
    mass_next_.resize(problem_.owned, block_);
    for (Index k = 0; k < block_; ++k) problem_.start(started_++, next_.col(k));
    problem_.mass(next_, mass_next_);
    MatrixXd coefficients, coupling;
    orthonormalise(coefficients, coupling);
  }

  /// Takes the block in hand into the basis and makes the next one from it.
  void expand() {
    const auto columns = next_.cols();
    v_.middleCols(used_, columns) = next_;
    problem_.apply(mass_next_, next_);
    result_.applications += static_cast<int>(columns);
    used_ += columns;
    problem_.mass(next_, mass_next_);
    MatrixXd coefficients;
    if (used_ + columns <= problem_.total) {
      orthonormalise(coefficients, coupling_);
    } else {
      complete(coefficients);
    }
    // Locked vectors are eigenvectors: what is computed as their coupling is below the tolerance.
    coefficients.topRows(locked_).setZero();
    auto column = t_.middleCols(used_ - columns, columns);
    column.topRows(used_) = coefficients;
    auto corner = t_.block(used_ - columns, used_ - columns, columns, columns);
    corner = (0.5 * (corner + corner.transpose())).eval();
    t_.block(used_ - columns, 0, columns, used_ - columns) =
        coefficients.topRows(used_ - columns).transpose();
  }

  /// A small problem's last block: what is left of the space has fewer dimensions than the block
  /// has columns, so any vectors that span it will do.
  void complete(MatrixXd& coefficients) {
    const MatrixXd block = next_;
    coefficients = product(v_.leftCols(used_), mass_next_);
    const auto left = problem_.total - used_;
    next_.resize(problem_.owned, left);
    mass_next_.resize(problem_.owned, left);
    coupling_ = MatrixXd::Zero(left, block.cols());
    if (left == 0) return;
    for (Index k = 0; k < left; ++k) refresh(k);
    MatrixXd unused, triangle;
    orthonormalise(unused, triangle);
    coupling_ = product(mass_next_, block);
  }

  /// Makes the block in hand M-orthonormal, and orthogonal to the basis in two passes.
  /// @param coefficients  basis x block: what lay in the basis
  /// @param coupling      block x block: block before = basis coefficients + block after coupling
  void orthonormalise(MatrixXd& coefficients, MatrixXd& coupling) {
    const auto basis = v_.leftCols(used_);
    const VectorXd sizes = norms();
    coefficients = product(basis, mass_next_);
    next_.noalias() -= basis * coefficients;
    problem_.mass(next_, mass_next_);
    coupling = factor_block(sizes);
    for (int pass = 0; pass < 2; ++pass) {
      // Fresh vectors that stand for lost ones are in the basis' way still.
      const MatrixXd again = product(basis, mass_next_);
      next_.noalias() -= basis * again;
      problem_.mass(next_, mass_next_);
      coefficients += again * coupling;
      coupling = factor_block(VectorXd::Zero(next_.cols())) * coupling;
      if (fresh_ == 0) return;
      fresh_ = 0;
    }
  }

  VectorXd norms() const {
    MatrixXd squares = next_.cwiseProduct(mass_next_).colwise().sum().transpose();
    sum_alike(squares, problem_.comm);
    return squares.cwiseMax(0).cwiseSqrt();
  }

  /// Turns the block into an M-orthonormal one.
  /// @param sizes  norms the columns had before the basis was taken out: what is left of a column
  ///               may be rounding alone, and is then replaced by a fresh vector
  /// @return upper triangle R: block before = block after times R
  MatrixXd factor_block(const VectorXd& sizes) {
    const MatrixXd gram = product(next_, mass_next_);
    const VectorXd scale = gram.diagonal().cwiseMax(0).cwiseSqrt();
    if ((scale.array() > lost * sizes.array()).all()) {
      const VectorXd inverse = scale.cwiseInverse();
      const Eigen::LLT<MatrixXd> cholesky(inverse.asDiagonal() * gram * inverse.asDiagonal());
      if (cholesky.info() == Eigen::Success &&
          MatrixXd(cholesky.matrixL()).diagonal().minCoeff() > std::sqrt(well_conditioned)) {
        const MatrixXd upper = MatrixXd(cholesky.matrixU()) * scale.asDiagonal();
        const auto triangle = upper.triangularView<Eigen::Upper>();
        triangle.solveInPlace<Eigen::OnTheRight>(next_);
        triangle.solveInPlace<Eigen::OnTheRight>(mass_next_);
        return upper;
      }
    }
    return factor_columns(sizes);
  }

  /// The same column by column (Gram-Schmidt, twice), for blocks that are nearly dependent.
  MatrixXd factor_columns(const VectorXd& sizes) {
    MatrixXd upper = MatrixXd::Zero(next_.cols(), next_.cols());
    for (Index k = 0; k < next_.cols(); ++k) {
      double before = std::max(sizes[k], column_norm(k));
      take_out(k, upper);
      double after = column_norm(k);
      for (int fresh = 0; !(after > lost * before); ++fresh) {
        if (fresh == 4) throw core::SolverError("Lanczos: no vector is independent of the basis");
        // Nothing new is left in this direction; its coupling is zero.
        upper.col(k).tail(next_.cols() - k).setZero();
        refresh(k);
        before = column_norm(k);
        MatrixXd unused = upper;
        take_out(k, unused);
        after = column_norm(k);
        if (after > lost * before) {
          scale_column(k, after);
          after = 0;
          break;
        }
      }
      if (after > 0) {
        upper(k, k) = after;
        scale_column(k, after);
      }
    }
    return upper;
  }

  double column_norm(Index k) const {
    MatrixXd square(1, 1);
    square(0, 0) = next_.col(k).dot(mass_next_.col(k));
    sum_alike(square, problem_.comm);
    return std::sqrt(std::max(0.0, square(0, 0)));
  }

  void scale_column(Index k, double norm) {
    next_.col(k) /= norm;
    mass_next_.col(k) /= norm;
  }

  /// Takes the first k columns out of column k; adds what they held to `upper`.
  void take_out(Index k, MatrixXd& upper) {
    for (int pass = 0; pass < 2 && k > 0; ++pass) {
      const VectorXd parts = product(mass_next_.leftCols(k), next_.col(k));
      next_.col(k) -= next_.leftCols(k) * parts;
      problem_.mass(next_.col(k), mass_next_.col(k));
      upper.col(k).head(k) += parts;
    }
  }

  /// A vector from the row of start vectors, orthogonal to the basis.
  void refresh(Index k) {
    ++fresh_;
    problem_.start(started_++, next_.col(k));
    problem_.mass(next_.col(k), mass_next_.col(k));
    for (int pass = 0; pass < 2; ++pass) {
      const MatrixXd parts = product(v_.leftCols(used_), mass_next_.col(k));
      next_.col(k) -= v_.leftCols(used_) * parts;
      problem_.mass(next_.col(k), mass_next_.col(k));
    }
  }

  /// The projected problem costs the cube of its size. A block brings hardly more pairs to
  /// convergence than it has vectors, so a look before that many blocks is wasted.
  bool worth_a_look() const { return used_ >= look_at_; }

  /// Ritz values and vectors of the part that is not locked, and how many lead converged.
  void project() {
    const auto active = used_ - locked_;
    ritz_ = t_.block(locked_, locked_, active, active);
    theta_ = eigenpairs_alike(ritz_, problem_.comm).reverse().eval();
    ritz_.rowwise().reverseInPlace();
    const MatrixXd last = coupling_ * ritz_.bottomRows(coupling_.cols());
    const double largest = locked_ > 0 ? std::max(t_(0, 0), theta_[0]) : theta_[0];
    Index leading = 0;
    while (leading < active &&
           last.col(leading).norm() <=
               std::max(options_.tolerance * std::abs(theta_[leading]), rounding * largest)) {
      ++leading;
    }
    // A locked pair may be passed by a larger one that shows later: that one must converge too.
    converged_ = locked_ + leading;
    look_at_ = used_ + std::max(block_, wanted_ - converged_);
    if (problem_.monitor) tell(last);
  }

  /// @param last  the coupling of each Ritz vector
  void tell(const MatrixXd& last) const {
    VectorXd values(used_), residuals = VectorXd::Zero(used_);
    values << t_.diagonal().head(locked_), theta_;
    residuals.tail(theta_.size()) =
        last.colwise().norm().transpose().cwiseQuotient(theta_.cwiseAbs());
    problem_.monitor(result_.restarts, converged_, values, residuals);
  }

  /// Keeps the leading Ritz vectors, locks those that converged.
  void restart() {
    ++result_.restarts;
    const auto leading = converged_ - locked_;
    const auto active = used_ - locked_;
    const auto room = basis_ - 2 * block_ - locked_;
    const auto keep = std::max<Index>(
        1, std::min(leading + std::max<Index>(block_, (active - leading) / 2), room));
    turn(keep);
    t_.bottomRightCorner(basis_ - locked_, basis_ - locked_).setZero();
    t_.diagonal().segment(locked_, keep) = theta_.head(keep);
    look_at_ -= active - keep;
    used_ = locked_ + keep;
    locked_ += std::min(leading, keep);
  }

  /// Replaces the first vectors that are not locked by Ritz vectors, in place.
  void turn(Index keep) {
    const auto active = ritz_.rows();
    MatrixXd part;
    for (Index row = 0; row < v_.rows(); row += chunk_rows) {
      const auto rows = std::min(chunk_rows, v_.rows() - row);
      part.noalias() = v_.block(row, locked_, rows, active) * ritz_.leftCols(keep);
      v_.block(row, locked_, rows, keep) = part;
    }
  }

  void finish() {
    const auto leading = converged_ - locked_;
    turn(leading);
    VectorXd values(converged_);
    values.head(locked_) = t_.diagonal().head(locked_);
    values.tail(leading) = theta_.head(leading);
    std::vector<Index> order(static_cast<std::size_t>(converged_));
    for (Index k = 0; k < converged_; ++k) order[static_cast<std::size_t>(k)] = k;
    std::stable_sort(order.begin(), order.end(),
                     [&values](Index a, Index b) { return values[a] > values[b]; });
    result_.values.resize(converged_);
    result_.vectors.resize(v_.rows(), converged_);
    for (Index k = 0; k < converged_; ++k) {
      result_.values[k] = values[order[static_cast<std::size_t>(k)]];
      result_.vectors.col(k) = v_.col(order[static_cast<std::size_t>(k)]);
    }
  }

  const LanczosProblem& problem_;
  LanczosOptions options_;
  Index block_, wanted_, basis_;
  Index look_at_;              ///< size of the basis at which convergence is looked for again
  MatrixXd v_;                 ///< basis: locked vectors first
  MatrixXd t_;                 ///< projection of the operator on it
  MatrixXd next_, mass_next_;  ///< block in hand and M times it
  MatrixXd coupling_;          ///< of the last block of the basis with the block in hand
  Index used_ = 0, locked_ = 0, converged_ = 0;
  int started_ = 0, fresh_ = 0;
  VectorXd theta_;
  MatrixXd ritz_;
  LanczosResult result_;
};

}  // namespace

Eigen::Index lanczos_basis(Eigen::Index total, Eigen::Index pairs, Eigen::Index block,
                           Eigen::Index asked) {
  // Up to some 150 modes half of the basis is spare; beyond, memory counts for more.
  const auto spare = std::max(6 * block, std::min(2 * pairs, 150 + pairs / 8));
  const auto kept = asked > 0 ? std::max(asked, pairs + 2 * block) : pairs + spare;
  return std::min(total, kept);
}

LanczosResult block_lanczos(const LanczosProblem& problem, const LanczosOptions& options) {
  // The basis is what does not fit when memory is short, on some ranks maybe.
  std::optional<Lanczos> lanczos;
  mpi::agreed_in_group(problem.comm, [&] { lanczos.emplace(problem, options); });
  return lanczos->run();
}

}  // namespace carillon::solvers::eigen
