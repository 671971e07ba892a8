#include "solvers/eigen/detail/lobpcg.hpp"

#include <Eigen/QR>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/error.hpp"
#include "solvers/eigen/detail/reduced.hpp"

namespace carillon::solvers::eigen {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Most columns that are worked on at a time: the rest wait for a place.
constexpr Index widest = 32;
/// Columns on their way through the preconditioner.
constexpr Index at_a_time = 8;
/// Squared length that combinations of columns of length 1 have left when they are rounding.
constexpr double lost = 1e-13;
/// Likewise, of columns that were orthogonal to all others before they were taken out once more.
constexpr double clear = 0.1;
/// Iterations without progress after which a residual is what rounding leaves, and how small it is
/// then.
constexpr int max_idle_steps = 4;
constexpr double small = 1e-8, infinity = std::numeric_limits<double>::infinity();
/// Columns of length 1 that lie along others up to this are no directions of their own.
constexpr double dependent = 1e-6;
/// Rows treated at a time when columns are turned in place.
constexpr Index chunk_rows = 2048;

class Lobpcg {
 public:
  Lobpcg(const LobpcgProblem& problem, const LobpcgOptions& options,
         const Eigen::Ref<const MatrixXd>& start)
      : problem_(problem),
        options_(options),
        start_(start),
        width_(std::min(widest, start.cols())),
        aside_(problem.owned, start.cols()),
        mass_aside_(problem.owned, start.cols()) {
    for (auto* columns : basis_) columns->resize(problem.owned, 3 * width_);
  }

  LobpcgResult run() {
    rotate(add_directions());
    for (;; ++result_.iterations) {
      precondition_residuals();
      set_aside();
      if (converged() >= options_.pairs || ++since_aside_ > options_.max_iterations) break;
      const auto wanted = x_ + add_directions();
      if (wanted == 0 || p_ + w_ == 0) break;  // nothing is left to look in
      rotate(wanted);
    }
    finish();
    return std::move(result_);
  }

 private:
  Index aside() const { return values_aside_.size(); }

  /// The lowest pairs that are set aside: one may be passed by an iterate that shows later, and
  /// that one must converge too.
  Index converged() const {
    return x_ == 0 ? aside() : (values_aside_.array() <= values_[0]).count();
  }

  MatrixXd product(const Eigen::Ref<const MatrixXd>& a, const Eigen::Ref<const MatrixXd>& b) const {
    MatrixXd out(a.cols(), b.cols());
    out.noalias() = a.transpose() * b;
    sum_alike(out, problem_.comm);
    return out;
  }

  /// Replaces columns of the basis by fewer combinations of them.
  static void turn(MatrixXd& columns, Index first, const MatrixXd& map) {
    MatrixXd part;
    for (Index row = 0; row < columns.rows(); row += chunk_rows) {
      const auto rows = std::min(chunk_rows, columns.rows() - row);
      part.noalias() = columns.block(row, first, rows, map.rows()) * map;
      columns.block(row, first, rows, map.cols()) = part;
    }
  }

  /// The preconditioned residuals of the iterates, behind them and their directions, and the sizes
  /// that tell convergence. What known vectors lack is no residual of others.
  void precondition_residuals() {
    w_ = x_;
    MatrixXd squares(1, x_), residual;
    for (Index k = 0; k < x_; k += at_a_time) {
      const auto count = std::min(at_a_time, x_ - k);
      residual = as_.middleCols(k, count) -
                 ms_.middleCols(k, count) * values_.segment(k, count).asDiagonal();
      take_out(problem_.mass_known, problem_.known, residual);
      take_out(mass_aside_.leftCols(aside()), aside_.leftCols(aside()), residual);
      auto direction = s_.middleCols(x_ + p_ + k, count);
      problem_.preconditioner(residual, direction);
      squares.middleCols(k, count) = residual.cwiseProduct(direction).colwise().sum();
    }
    sum_alike(squares, problem_.comm);
    if (!(squares.array() >= 0).all()) {
      throw core::SolverError(
          "the multigrid preconditioner is not positive definite: the mesh may have elements that "
          "are nearly flat");
    }
    sizes_ = (squares.row(0).transpose().array() / values_.array()).sqrt();
  }

  /// Iterates that converged leave the basis, with their residuals; their directions may stay.
  void set_aside() {
    // Rounding weighs most in the lowest: what is the best that they reach will do for all.
    if (held_up()) options_.tolerance = std::max(options_.tolerance, sizes_[0]);
    Index leading = 0;
    while (leading < x_ && sizes_[leading] <= options_.tolerance) ++leading;
    if (leading == 0) return;
    min_ = infinity;
    since_aside_ = 0;
    aside_.middleCols(aside(), leading) = s_.leftCols(leading);
    mass_aside_.middleCols(aside(), leading) = ms_.leftCols(leading);
    values_aside_.conservativeResize(aside() + leading);
    values_aside_.tail(leading) = values_.head(leading);
    for (auto* columns : basis_) {
      for (Index k = leading; k < x_ + p_; ++k) columns->col(k - leading) = columns->col(k);
      for (Index k = x_ + p_ + leading; k < x_ + p_ + w_; ++k) {
        columns->col(k - 2 * leading) = columns->col(k);
      }
    }
    x_ -= leading;
    w_ -= leading;
    values_ = values_.tail(x_).eval();
  }

  /// Whether rounding holds up the lowest iterate: its residual is small and has not halved for a
  /// while.
  bool held_up() {
    if (x_ == 0) return false;
    if (sizes_[0] <= 0.5 * min_ || sizes_[0] > small) {
      min_ = sizes_[0];
      since_min_ = 0;
      return false;
    }
    return ++since_min_ >= max_idle_steps;
  }

  /// Start vectors join where iterates left room. Residuals and start vectors become M-orthonormal
  /// to one another and to all that is known.
  /// @return how many start vectors joined
  Index add_directions() {
    const auto first = x_ + p_;
    const auto joining = std::min(width_ - x_, start_.cols() - started_);
    s_.middleCols(first + w_, joining) = start_.middleCols(started_, joining);
    started_ += joining;
    w_ += joining;
    w_ = std::min<Index>(w_, problem_.total - problem_.known.cols() - aside() - first);
    normalise(first);
    project(first);
    project(first);
    normalise(first);
    combine(first, lost);
    combine(first, lost);
    // What was rounding lies along the others once more, and is next to nothing without that.
    project(first);
    combine(first, clear);
    problem_.products->shifted(problem_.shift, s_.middleCols(first, w_), as_.middleCols(first, w_));
    return joining;
  }

  void normalise(Index first) {
    auto x = s_.middleCols(first, w_), mass_x = ms_.middleCols(first, w_);
    problem_.products->mass(x, mass_x);
    MatrixXd squares = x.cwiseProduct(mass_x).colwise().sum();
    sum_alike(squares, problem_.comm);
    for (Index k = 0; k < w_; ++k) {
      if (squares(0, k) > 0) x.col(k) /= std::sqrt(squares(0, k));
    }
  }

  void project(Index first) {
    auto x = s_.middleCols(first, w_);
    take_out(problem_.known, problem_.mass_known, x);
    take_out(aside_.leftCols(aside()), mass_aside_.leftCols(aside()), x);
    take_out(s_.leftCols(first), ms_.leftCols(first), x);
  }

  /// x -= basis (dual^T x).
  void take_out(const Eigen::Ref<const MatrixXd>& basis, const Eigen::Ref<const MatrixXd>& dual,
                Eigen::Ref<MatrixXd> x) const {
    if (basis.cols() > 0 && x.cols() > 0) x.noalias() -= basis * product(dual, x);
  }

  /// M-orthonormal combinations of the last columns, of length 1; those whose squared length is
  /// less than `minimum` are dropped.
  void combine(Index first, double minimum) {
    if (w_ == 0) return;
    const auto x = s_.middleCols(first, w_);
    problem_.products->mass(x, ms_.middleCols(first, w_));
    MatrixXd gram = product(x, ms_.middleCols(first, w_));
    const VectorXd values = eigenpairs_alike(gram, problem_.comm);
    const auto kept = (values.array() > minimum).count();
    const MatrixXd map =
        gram.rightCols(kept) * values.tail(kept).cwiseSqrt().cwiseInverse().asDiagonal();
    turn(s_, first, map);
    turn(ms_, first, map);
    w_ = kept;
  }

  /// Rayleigh and Ritz: so many of the lowest Ritz vectors become the iterates, and what they have
  /// beside the iterates before becomes their directions.
  void rotate(Index iterates) {
    const auto all = x_ + p_ + w_;
    iterates = std::min(iterates, all);
    MatrixXd ritz = product(s_.leftCols(all), as_.leftCols(all));
    values_ = eigenpairs_alike(ritz, problem_.comm).head(iterates);
    MatrixXd map(all, 2 * iterates);
    map.leftCols(iterates) = ritz.leftCols(iterates);
    Index directions = 0;
    if (x_ > 0) {
      directions = directions_of(map.leftCols(iterates), map.rightCols(iterates));
      directions = std::min(directions, x_);
    }
    for (auto* columns : basis_) turn(*columns, 0, map.leftCols(iterates + directions));
    x_ = iterates;
    p_ = directions;
    w_ = 0;
  }

  /// Orthonormal columns that span what Ritz vectors have beside the iterates before, orthogonal to
  /// them.
  /// @return how many
  Index directions_of(const Eigen::Ref<const MatrixXd>& ritz, Eigen::Ref<MatrixXd> out) const {
    MatrixXd change = ritz;
    change.topRows(x_).setZero();
    // What is left of a vector that hardly moved is small, and lies along the others by rounding.
    for (int pass = 0; pass < 3; ++pass) {
      change -= (ritz * (ritz.transpose() * change)).eval();
      change.colwise().normalize();
    }
    Eigen::ColPivHouseholderQR<MatrixXd> qr(change);
    qr.setThreshold(dependent);
    // Processors of different kinds may round differently.
    MatrixXd count(1, 1);
    count(0, 0) = static_cast<double>(qr.rank());
    share_first(count, problem_.comm);
    MatrixXd columns = qr.householderQ() * MatrixXd::Identity(change.rows(), change.cols());
    share_first(columns, problem_.comm);
    out = columns;
    return static_cast<Index>(count(0, 0));
  }

  /// Rayleigh and Ritz among all that was found: what one pair lacks may lie along another.
  void finish() {
    result_.converged = static_cast<int>(converged());
    for (auto* columns : basis_) *columns = columns->leftCols(x_).eval();
    auto& found = result_.vectors;
    found.resize(problem_.owned, aside() + x_);
    found << aside_.leftCols(aside()), s_;
    MatrixXd stiffness(found.rows(), found.cols());
    problem_.products->shifted(problem_.shift, found, stiffness);
    MatrixXd ritz = product(found, stiffness);
    result_.values = eigenpairs_alike(ritz, problem_.comm).array() + problem_.shift;
    turn(found, 0, ritz);
  }

  const LobpcgProblem& problem_;
  LobpcgOptions options_;
  const Eigen::Ref<const MatrixXd>& start_;
  Index started_ = 0;  ///< start vectors that joined
  Index width_;        ///< most iterates at a time
  /// Iterates, their directions, and preconditioned residuals; A and M times them.
  MatrixXd s_, as_, ms_;
  std::array<MatrixXd*, 3> basis_ = {&s_, &as_, &ms_};
  Index x_ = 0, p_ = 0, w_ = 0;
  VectorXd values_, sizes_;  ///< of the iterates: mu, and residuals in the preconditioner's norm
  double min_ = infinity;    ///< size of the lowest iterate when it last halved
  int since_min_ = 0;        ///< iterations since then
  int since_aside_ = 0;      ///< iterations since a pair was set aside
  MatrixXd aside_, mass_aside_;  ///< pairs that converged
  VectorXd values_aside_;
  LobpcgResult result_;
};

}  // namespace

std::int64_t lobpcg_vectors(std::int64_t start) {
  // Start vectors, pairs set aside and M times them; the basis with A and M times it, and later the
  // result in its place.
  return 3 * start + std::max<std::int64_t>(9 * std::min<std::int64_t>(start, widest), 2 * start);
}

LobpcgResult lobpcg(const LobpcgProblem& problem, const LobpcgOptions& options,
                    const Eigen::Ref<const MatrixXd>& start) {
  return Lobpcg(problem, options, start).run();
}

}  // namespace carillon::solvers::eigen
