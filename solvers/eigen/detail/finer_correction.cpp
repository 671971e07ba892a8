#include "solvers/eigen/detail/finer_correction.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

namespace carillon::solvers::eigen {
namespace {

/// Foresees from the energies that its steps have gained when a field may stop. Steps fall about
/// geometrically, if not evenly, so that what is left follows from the last three.
class Progress {
 public:
  /// @return the energy still to be gained, as far as can be told
  double left_after(double step) {
    gained_ += step;
    double fall = 0.5;
    if (steps_ == 1) fall = step / last_;
    if (steps_ > 1) fall = std::sqrt(step / before_last_);
    constexpr double slowest = 0.97;
    fall = std::min(fall, slowest);
    before_last_ = last_;
    last_ = step;
    ++steps_;
    return step * fall / (1 - fall);
  }
  double gained() const { return gained_; }

 private:
  int steps_ = 0;
  double gained_ = 0, last_ = 0, before_last_ = 0;
};

void keep_rows(const std::vector<Eigen::Index>& rows, Fields& fields) {
  fields = fields(rows, Eigen::all).eval();
}

}  // namespace

Eigen::ArrayXd dots(const Fields& a, const Fields& b, MPI_Comm comm) {
  Eigen::ArrayXd sum = Eigen::ArrayXd::Zero(a.rows());
  for (Eigen::Index j = 0; j < a.cols(); ++j) sum += a.col(j).array() * b.col(j).array();
  MPI_Bcast(sum.data(), static_cast<int>(sum.size()), MPI_DOUBLE, 0, comm);
  return sum;
}

FinerCorrection::FinerCorrection(const mesh::TetMesh& mesh,
                                 std::span<const elements::Elastic> regions,
                                 const assembly::System& system, const ShiftedSystem& shifted,
                                 const FinerSpace& space, std::int64_t memory, MPI_Comm comm)
    : coarse_(shifted.preconditioner),
      space_(space),
      comm_(comm),
      transfer_(mesh, system, space, comm) {
  if (is_flat(mesh))
    factor_ = FinerFactor::make(space, regions, system.mirror, shifted.shift, memory, comm);
  if (!factor_) local_.emplace(space);
}

void FinerCorrection::precondition(const Fields& residual, Fields& out) const {
  out.setZero(residual.rows(), residual.cols());
  if (factor_) {
    factor_->add(residual, out);
    sum_over_ranks(out, comm_);
    return;
  }
  local_->add(residual, out);
  const Eigen::MatrixXd right = transfer_.restriction(residual);
  Eigen::MatrixXd solution(right.rows(), right.cols());
  coarse_(right, solution);
  transfer_.add_prolonged(solution, out);
  sum_over_ranks(out, comm_);
  space_.hold(out);
}

Fields FinerCorrection::prolong(const Eigen::Ref<const Eigen::MatrixXd>& owned) const {
  Fields out = transfer_.prolong(owned);
  space_.hold(out);
  return out;
}

Fields FinerCorrection::solve(Fields& right, const CorrectionGoal& goal) const {
  Fields d = Fields::Zero(right.rows(), right.cols());
  Fields left = right, z, p, ap;
  std::vector<Progress> progress(static_cast<std::size_t>(right.rows()));
  std::vector<Eigen::Index> active(progress.size());  // the field of each row of left and p
  std::iota(active.begin(), active.end(), 0);
  Eigen::ArrayXd energy;  // left^T z
  for (int step = 0; step < goal.max_steps && !active.empty(); ++step) {
    precondition(left, z);
    const Eigen::ArrayXd next = dots(left, z, comm_);
    if (step == 0) {
      p = z;
    } else {
      const Eigen::ArrayXd beta = next / energy;
      for (Eigen::Index j = 0; j < p.cols(); ++j) {
        p.col(j).array() = z.col(j).array() + beta * p.col(j).array();
      }
    }
    energy = next;
    space_.apply(p, ap);
    const Eigen::ArrayXd curvature = dots(p, ap, comm_);
    // Nothing left, or nothing but rounding: no step.
    const Eigen::ArrayXd length =
        (curvature > 0 && energy > 0).select(energy / curvature, Eigen::ArrayXd::Zero(p.rows()));
    for (Eigen::Index j = 0; j < p.cols(); ++j) {
      left.col(j).array() -= length * ap.col(j).array();
      for (Eigen::Index row = 0; row < p.rows(); ++row) {
        d(active[static_cast<std::size_t>(row)], j) += length[row] * p(row, j);
      }
    }
    std::vector<Eigen::Index> stay, fields;
    for (Eigen::Index row = 0; row < p.rows(); ++row) {
      const auto field = active[static_cast<std::size_t>(row)];
      auto& at = progress[static_cast<std::size_t>(field)];
      const double missing = at.left_after(length[row] * energy[row]);
      if (missing > goal.fraction * at.gained() && missing > goal.negligible[field]) {
        stay.push_back(row);
        fields.push_back(field);
      } else {
        right.row(field) = left.row(row);
      }
    }
    if (stay.size() == active.size()) continue;
    keep_rows(stay, left);
    keep_rows(stay, p);
    energy = energy(stay).eval();
    active = std::move(fields);
  }
  for (std::size_t row = 0; row < active.size(); ++row) {
    right.row(active[row]) = left.row(static_cast<Eigen::Index>(row));
  }
  return d;
}

}  // namespace carillon::solvers::eigen
