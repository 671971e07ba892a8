#include "solvers/eigen/cholesky.hpp"

#include <cholmod.h>
#include <fmt/core.h>

#include <vector>

#include "core/error.hpp"

namespace carillon::solvers::eigen {
namespace {

using Index = SuiteSparse_long;

/// Parameters and workspace of CHOLMOD.
class Common {
 public:
  Common() {
    cholmod_l_start(&common_);
    // One method: the order that is given, and the factor as large dense blocks.
    common_.nmethods = 1;
    common_.method[0].ordering = CHOLMOD_GIVEN;
    common_.postorder = 1;
    common_.supernodal = CHOLMOD_SUPERNODAL;
    common_.final_ll = 1;
    common_.print = 0;
    common_.error_handler = nullptr;
  }
  ~Common() { cholmod_l_finish(&common_); }
  Common(const Common&) = delete;
  Common& operator=(const Common&) = delete;
  cholmod_common* get() { return &common_; }

  void check() const {
    if (common_.status >= CHOLMOD_OK && common_.status != CHOLMOD_NOT_POSDEF) return;
    if (common_.status == CHOLMOD_NOT_POSDEF) {
      throw core::SolverError(
          "the matrix could not be factored (CHOLMOD: it is not positive definite)",
          "the mesh may have elements that are nearly flat");
    }
    const std::string message =
        fmt::format("the matrix could not be factored (CHOLMOD status {})", common_.status);
    if (common_.status == CHOLMOD_OUT_OF_MEMORY || common_.status == CHOLMOD_TOO_LARGE) {
      throw core::MemoryError(
          "out of memory: " + message,
          "the object needs more memory: use a coarser mesh, more ranks or the iterative solver");
    }
    throw core::SolverError(message);
  }

 private:
  cholmod_common common_{};
};

/// A CHOLMOD object, freed with the parameters it was made with.
template <class T, auto Free>
class Owned {
 public:
  Owned(T* raw, Common& common) : raw_(raw), common_(common) { common.check(); }
  ~Owned() { Free(&raw_, common_.get()); }
  Owned(const Owned&) = delete;
  Owned& operator=(const Owned&) = delete;
  T* get() const { return raw_; }
  T* operator->() const { return raw_; }

 private:
  T* raw_;
  Common& common_;
};
using Sparse = Owned<cholmod_sparse, cholmod_l_free_sparse>;
using Factor = Owned<cholmod_factor, cholmod_l_free_factor>;

/// Calls add(column, row) for the entries of each column of unknowns, in the system's numbers;
/// rows and columns are alike.
template <class Add>
void each_entry(const assembly::NodeGraph& graph, Index column, Add add) {
  const auto node = static_cast<std::size_t>(column / 3);
  for (auto k = graph.first[node]; k < graph.first[node + 1]; ++k) {
    for (Index i = 0; i < 3; ++i) add(3 * Index{graph.column[static_cast<std::size_t>(k)]} + i);
  }
}

/// Entries in one triangle of the matrix of unknowns, diagonal included.
std::size_t triangle_entries(const assembly::NodeGraph& graph) {
  const auto rows = static_cast<std::size_t>(graph.rows());
  return (9 * graph.column.size() + 3 * rows) / 2;
}

/// The upper triangle's pattern.
cholmod_sparse* pattern(const assembly::NodeGraph& graph, Common& common) {
  const Index n = 3 * Index{graph.rows()};
  auto* const out =
      cholmod_l_allocate_sparse(static_cast<std::size_t>(n), static_cast<std::size_t>(n),
                                triangle_entries(graph), 1, 1, 1, CHOLMOD_PATTERN, common.get());
  if (out == nullptr) return out;
  auto* const first = static_cast<Index*>(out->p);
  auto* const rows = static_cast<Index*>(out->i);
  Index count = 0;
  for (Index column = 0; column < n; ++column) {
    first[column] = count;
    each_entry(graph, column, [&](Index row) {
      if (row <= column) rows[count++] = row;
    });
  }
  first[n] = count;
  return out;
}

/// The lower triangle of K - shift M with rows and columns in the order of elimination, as
/// CHOLMOD wants it: it then makes no copy of its own.
cholmod_sparse* permuted_lower(const assembly::System& system, double shift, const Index* order,
                               Common& common) {
  const auto& graph = system.graph;
  const Index n = 3 * Index{graph.rows()};
  auto* const out =
      cholmod_l_allocate_sparse(static_cast<std::size_t>(n), static_cast<std::size_t>(n),
                                triangle_entries(graph), 0, 1, -1, CHOLMOD_REAL, common.get());
  if (out == nullptr) return out;
  std::vector<Index> place(static_cast<std::size_t>(n));
  for (Index k = 0; k < n; ++k) place[static_cast<std::size_t>(order[k])] = k;
  auto* const first = static_cast<Index*>(out->p);
  auto* const rows = static_cast<Index*>(out->i);
  auto* const values = static_cast<double*>(out->x);
  Index count = 0;
  for (Index column = 0; column < n; ++column) {
    first[column] = count;
    const auto node = static_cast<std::size_t>(order[column] / 3);
    const Index component = order[column] % 3;
    const auto begin = graph.first[node];
    const auto width = graph.first[node + 1] - begin;
    const double* stiffness = system.stiffness.data() + 9 * begin + component * 3 * width;
    for (std::int64_t k = 0; k < width; ++k) {
      const auto pair = static_cast<std::size_t>(begin + k);
      for (Index i = 0; i < 3; ++i) {
        const auto row = place[static_cast<std::size_t>(3 * Index{graph.column[pair]} + i)];
        if (row < column) continue;
        rows[count] = row;
        const bool has_mass =
            i == component && system.couples(static_cast<std::int32_t>(node), graph.column[pair],
                                             static_cast<int>(component));
        values[count] = stiffness[3 * k + i] - (has_mass ? shift * system.mass[pair] : 0.0);
        ++count;
      }
    }
  }
  first[n] = count;
  return out;
}

cholmod_factor* analyse(const assembly::NodeGraph& graph, std::span<const std::int32_t> node_order,
                        Common& common) {
  std::vector<Index> order;
  order.reserve(3 * node_order.size());
  for (const auto node : node_order) {
    for (Index i = 0; i < 3; ++i) order.push_back(3 * Index{node} + i);
  }
  const Sparse matrix(pattern(graph, common), common);
  return cholmod_l_analyze_p(matrix.get(), order.data(), nullptr, 0, common.get());
}

}  // namespace

struct CholeskyStructure::Inside {
  Inside(const assembly::NodeGraph& graph, std::span<const std::int32_t> node_order)
      : factor(analyse(graph, node_order, common), common), triangle(triangle_entries(graph)) {}
  mutable Common common;
  Factor factor;
  std::size_t triangle;
};

CholeskyStructure::CholeskyStructure(const assembly::NodeGraph& graph,
                                     std::span<const std::int32_t> node_order)
    : inside_(std::make_unique<Inside>(graph, node_order)) {}

CholeskyStructure::~CholeskyStructure() = default;

FactorSize CholeskyStructure::size() const {
  const auto& factor = *inside_->factor.get();
  const auto n = static_cast<std::int64_t>(factor.n);
  FactorSize size;
  size.entries = static_cast<std::int64_t>(factor.xsize);
  // The factor and its row numbers, the triangle it is made from, some lists by unknown, and the
  // update of the largest supernode.
  constexpr std::int64_t word = 8, lists = 10;
  size.bytes = word * (size.entries + static_cast<std::int64_t>(factor.ssize) +
                       2 * static_cast<std::int64_t>(inside_->triangle) + lists * n +
                       static_cast<std::int64_t>(factor.maxcsize));
  return size;
}

struct Cholesky::Inside {
  explicit Inside(const cholmod_factor* structure)
      : factor(cholmod_l_copy_factor(const_cast<cholmod_factor*>(structure), common.get()),
               common) {}
  ~Inside() {
    cholmod_l_free_dense(&solution, common.get());
    cholmod_l_free_dense(&permuted, common.get());
    cholmod_l_free_dense(&update, common.get());
  }
  Inside(const Inside&) = delete;
  Inside& operator=(const Inside&) = delete;

  Common common;
  Factor factor;
  // Workspace of solves.
  cholmod_dense* solution = nullptr;
  cholmod_dense* permuted = nullptr;
  cholmod_dense* update = nullptr;
};

Cholesky::Cholesky(const assembly::System& system, double shift, const CholeskyStructure& structure)
    : inside_(std::make_unique<Inside>(structure.inside_->factor.get())) {
  auto& common = inside_->common;
  auto& factor = *inside_->factor.get();
  const Sparse matrix(permuted_lower(system, shift, static_cast<const Index*>(factor.Perm), common),
                      common);
  // The matrix is in order already; solves permute.
  const auto ordering = factor.ordering;
  factor.ordering = CHOLMOD_NATURAL;
  cholmod_l_factorize(matrix.get(), &factor, common.get());
  factor.ordering = ordering;
  common.check();
}

Cholesky::~Cholesky() = default;

void Cholesky::solve(const Eigen::Ref<const Eigen::MatrixXd>& right,
                     Eigen::Ref<Eigen::MatrixXd> solution) const {
  if (right.cols() == 0) return;
  cholmod_dense from{};
  from.nrow = static_cast<std::size_t>(right.rows());
  from.ncol = static_cast<std::size_t>(right.cols());
  from.d = static_cast<std::size_t>(right.outerStride());
  from.nzmax = from.d * from.ncol;
  from.x = const_cast<double*>(right.data());
  from.xtype = CHOLMOD_REAL;
  from.dtype = CHOLMOD_DOUBLE;
  auto& inside = *inside_;
  cholmod_l_solve2(CHOLMOD_A, inside.factor.get(), &from, nullptr, &inside.solution, nullptr,
                   &inside.permuted, &inside.update, inside.common.get());
  inside.common.check();
  solution = Eigen::Map<const Eigen::MatrixXd>(static_cast<const double*>(inside.solution->x),
                                               right.rows(), right.cols());
}

}  // namespace carillon::solvers::eigen
