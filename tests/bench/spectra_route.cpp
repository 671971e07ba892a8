// Eigen and Spectra take a while to compile: a file of their own.
#include <fmt/core.h>

#include <Eigen/SparseCholesky>
#include <algorithm>

#include <Spectra/MatOp/SparseSymMatProd.h>
#include <Spectra/SymGEigsShiftSolver.h>

#include "core/error.hpp"
#include "routes.hpp"

namespace carillon::bench {
namespace {

using solvers::assembly::System;
using Sparse = Eigen::SparseMatrix<double>;

/// The lower triangle of K - shift M or, with `mass_alone`, of M.
Sparse lower_triangle(const System& system, double shift, bool mass_alone) {
  const auto& graph = system.graph;
  Sparse out(system.unknowns(), system.unknowns());
  std::vector<Eigen::Triplet<double>> entries;
  for (std::int32_t row = 0; row < graph.rows(); ++row) {
    const auto begin = graph.first[static_cast<std::size_t>(row)];
    const auto width = graph.first[static_cast<std::size_t>(row) + 1] - begin;
    for (std::int64_t k = 0; k < width; ++k) {
      const auto pair = static_cast<std::size_t>(begin + k);
      const int column = graph.column[pair];
      if (column > row) continue;
      for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) {
          if (3 * column + j > 3 * row + i || (mass_alone && i != j)) continue;
          const double mass = i == j ? system.mass[pair] : 0;
          const auto at = static_cast<std::size_t>(9 * begin + (i * width + k) * 3 + j);
          entries.emplace_back(3 * row + i, 3 * column + j,
                               mass_alone ? mass : system.stiffness[at] - shift * mass);
        }
      }
    }
  }
  out.setFromTriplets(entries.begin(), entries.end());
  return out;
}

/// The factor, opened to see what it will take.
class Ldlt : public Eigen::SimplicialLDLT<Sparse, Eigen::Lower> {
 public:
  /// Of the factorisation, by the sizes of its columns.
  double flops() const {
    double sum = 0;
    for (Eigen::Index k = 0; k < m_nonZerosPerCol.size(); ++k) {
      sum += static_cast<double>(m_nonZerosPerCol[k]) * m_nonZerosPerCol[k];
    }
    return sum;
  }
};

/// What Spectra asks of an operator, by a factor that is there already.
class Inverse {
 public:
  using Scalar = double;
  explicit Inverse(const Ldlt& factor) : factor_(factor) {}
  Eigen::Index rows() const { return factor_.rows(); }
  Eigen::Index cols() const { return factor_.cols(); }
  void set_shift(const Scalar&) {}
  void perform_op(const Scalar* from, Scalar* to) const {
    Eigen::Map<Eigen::VectorXd>(to, rows()) =
        factor_.solve(Eigen::Map<const Eigen::VectorXd>(from, rows()));
  }

 private:
  const Ldlt& factor_;
};

}  // namespace

Answer spectra_route(const System& system, double shift, int pairs, double max_flops) {
  Answer answer;
  const Sparse matrix = lower_triangle(system, shift, false);
  const Sparse mass = lower_triangle(system, 0, true);
  Ldlt factor;
  measure_stage(answer.stages, "factor", [&] {
    factor.analyzePattern(matrix);
    if (factor.flops() > max_flops) {
      answer.refused = fmt::format("{:.1f} TFlop to factor", 1e-12 * factor.flops());
      return;
    }
    factor.factorize(matrix);
  });
  if (!answer.refused.empty()) return answer;
  if (factor.info() != Eigen::Success) throw core::SolverError("SimplicialLDLT failed");
  Inverse inverse(factor);
  Spectra::SparseSymMatProd<double> mass_product(mass);
  Spectra::SymGEigsShiftSolver<Inverse, Spectra::SparseSymMatProd<double>,
                               Spectra::GEigsMode::ShiftInvert>
      solver(inverse, mass_product, pairs, 2 * pairs, shift);
  measure_stage(answer.stages, "iterate", [&] {
    solver.init();
    solver.compute(Spectra::SortRule::LargestMagn, 1000, 1e-10);
  });
  if (solver.info() != Spectra::CompInfo::Successful) {
    throw core::SolverError("Spectra did not converge");
  }
  const Eigen::VectorXd values = solver.eigenvalues();
  answer.values.assign(values.begin(), values.end());
  std::sort(answer.values.begin(), answer.values.end());
  return answer;
}

}  // namespace carillon::bench
