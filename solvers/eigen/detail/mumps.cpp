#include "solvers/eigen/detail/mumps.hpp"

#include <dmumps_c.h>
#include <fmt/core.h>

#include <algorithm>
#include <limits>
#include <numeric>
#include <vector>

#include "core/error.hpp"
#include "mpi/comm.hpp"

namespace carillon::solvers::eigen {
namespace {

enum Job { start = -1, end = -2, analyse = 1, factorise = 2, back_substitute = 3 };

/// What INFOG(1) says when a workspace estimate was too small.
constexpr MUMPS_INT workspace_too_small = -8, main_workspace_too_small = -9;

/// MUMPS writes counts beyond 2^31 as negative millions.
std::int64_t counted(MUMPS_INT value) {
  return value >= 0 ? value : -1000000 * static_cast<std::int64_t>(value);
}

}  // namespace

struct Mumps::Inside {
  Inside(const assembly::System& body, Purpose use, MPI_Comm group) : system(body), purpose(use) {
    MPI_Comm_dup(group, &comm);
    MPI_Comm_rank(comm, &rank);
    MPI_Comm_size(comm, &ranks);
    id.comm_fortran = static_cast<MUMPS_INT>(MPI_Comm_c2f(comm));
    id.par = 1;
    id.sym = purpose == Purpose::solve ? 1 : 2;
    run(start);
  }
  ~Inside() {
    id.job = end;
    dmumps_c(&id);
    MPI_Comm_free(&comm);
  }
  Inside(const Inside&) = delete;
  Inside& operator=(const Inside&) = delete;

  void run(Job job) {
    id.job = job;
    dmumps_c(&id);
  }
  /// By its number in the manual.
  MUMPS_INT& control(int number) { return id.icntl[number - 1]; }
  MUMPS_INT result(int number) const { return id.infog[number - 1]; }
  void refuse_failure() const {
    if (result(1) >= 0) return;
    const bool memory = result(1) == -13 || result(1) == -8 || result(1) == -9;
    const std::string message =
        fmt::format("the matrix could not be factored (MUMPS INFOG(1) = {}, INFOG(2) = {})",
                    result(1), result(2));
    if (memory) {
      throw core::MemoryError(
          "out of memory: " + message,
          "the object needs more memory: use a coarser mesh, more ranks or the iterative solver");
    }
    throw core::SolverError(message, "the mesh may have elements that are nearly flat");
  }

  /// Calls add(row, column, index in stiffness, index in mass or -1) for this rank's entries of
  /// the lower triangle.
  template <class Add>
  void each_entry(Add add) const {
    const auto& graph = system.graph;
    for (std::int32_t row = 0; row < graph.rows(); ++row) {
      const auto begin = graph.first[static_cast<std::size_t>(row)];
      const auto width = graph.first[static_cast<std::size_t>(row) + 1] - begin;
      for (int i = 0; i < 3; ++i) {
        const auto unknown = 3 * (graph.begin + row) + i;
        for (std::int64_t k = 0; k < width; ++k) {
          for (int j = 0; j < 3; ++j) {
            const auto other = 3 * graph.column[static_cast<std::size_t>(begin + k)] + j;
            if (other > unknown) continue;
            const bool has_mass =
                i == j && system.couples(graph.begin + row,
                                         graph.column[static_cast<std::size_t>(begin + k)], i);
            add(unknown, other, 9 * begin + (i * width + k) * 3 + j, has_mass ? begin + k : -1);
          }
        }
      }
    }
  }

  void fill_pattern();
  void fill_values(double shift);
  void set_controls();

  const assembly::System& system;
  Purpose purpose;
  MPI_Comm comm = MPI_COMM_NULL;
  int rank = 0, ranks = 1;
  DMUMPS_STRUC_C id{};
  std::vector<MUMPS_INT> row_of, column_of;  ///< of each entry, from 1
  std::vector<MUMPS_INT> place_of;           ///< of each unknown in the elimination, from 1
  std::vector<double> values;
};

void Mumps::Inside::fill_pattern() {
  std::int64_t count = 0;
  each_entry([&count](auto...) { ++count; });
  row_of.reserve(static_cast<std::size_t>(count));
  column_of.reserve(static_cast<std::size_t>(count));
  each_entry([this](MUMPS_INT i, MUMPS_INT j, auto...) {
    row_of.push_back(i + 1);
    column_of.push_back(j + 1);
  });
  id.n = static_cast<MUMPS_INT>(system.unknowns());
  if (ranks == 1) {
    id.nnz = count;
    id.irn = row_of.data();
    id.jcn = column_of.data();
  } else {
    id.nnz_loc = count;
    id.irn_loc = row_of.data();
    id.jcn_loc = column_of.data();
  }
}

void Mumps::Inside::fill_values(double shift) {
  values.reserve(row_of.size());
  each_entry([this, shift](MUMPS_INT, MUMPS_INT, std::int64_t k, std::int64_t m) {
    const double mass = m < 0 ? 0 : system.mass[static_cast<std::size_t>(m)];
    values.push_back(system.stiffness[static_cast<std::size_t>(k)] - shift * mass);
  });
  (ranks == 1 ? id.a : id.a_loc) = values.data();
}

void Mumps::Inside::set_controls() {
  for (const int output : {1, 2, 3}) control(output) = -1;
  control(4) = 0;
  control(7) = 1;                    // the order is given
  control(14) = 30;                  // percent of workspace on top of the estimate
  control(18) = ranks == 1 ? 0 : 3;  // each rank holds entries of its own
  control(28) = 1;                   // analysis on rank 0: Debian's has no other
  if (purpose == Purpose::inertia) {
    // The root front must not go to ScaLAPACK, which does not count its pivots' signs.
    control(13) = 1;
    control(24) = 1;  // counts null pivots
    control(31) = 1;  // the factor's entries are not kept
    id.cntl[2] = 1e-15;
  }
}

Mumps::Mumps(const assembly::System& system, Purpose purpose,
             std::span<const std::int32_t> node_order, MPI_Comm comm)
    : inside_(std::make_unique<Inside>(system, purpose, comm)) {
  auto& inside = *inside_;
  inside.refuse_failure();
  inside.set_controls();
  mpi::agreed_in_group(comm, [&] {
    inside.fill_pattern();
    if (inside.rank != 0) return;
    inside.place_of.resize(static_cast<std::size_t>(system.unknowns()));
    MUMPS_INT place = 0;
    for (const auto node : node_order) {
      for (int i = 0; i < 3; ++i) {
        inside.place_of[static_cast<std::size_t>(3 * std::int64_t{node} + i)] = ++place;
      }
    }
    inside.id.perm_in = inside.place_of.data();
  });
  inside.run(analyse);
  inside.refuse_failure();
}

Mumps::~Mumps() = default;

FactorSize Mumps::size() const {
  // Row and column numbers and values of the triangle come on top of MUMPS' own megabytes.
  std::int64_t triangle = static_cast<std::int64_t>(inside_->row_of.size());
  MPI_Allreduce(MPI_IN_PLACE, &triangle, 1, MPI_INT64_T, MPI_SUM, inside_->comm);
  constexpr std::int64_t bytes_per_entry = 2 * sizeof(MUMPS_INT) + sizeof(double);
  return {counted(inside_->result(20)),
          1000000 * counted(inside_->result(17)) + bytes_per_entry * triangle};
}

void Mumps::factor(double shift) {
  auto& inside = *inside_;
  mpi::agreed_in_group(inside.comm, [&] { inside.fill_values(shift); });
  for (int tries = 0; tries < 4; ++tries) {
    inside.run(factorise);
    const auto status = inside.result(1);
    if (status != workspace_too_small && status != main_workspace_too_small) break;
    inside.control(14) *= 2;
  }
  inside.refuse_failure();
  if (inside.purpose == Purpose::solve && inside.result(12) > 0) {
    throw core::SolverError(
        fmt::format("the matrix could not be factored (MUMPS: {} of its pivots are negative)",
                    inside.result(12)),
        "the mesh may have elements that are nearly flat");
  }
  for (auto* list : {&inside.row_of, &inside.column_of, &inside.place_of})
    std::vector<MUMPS_INT>().swap(*list);
  std::vector<double>().swap(inside.values);
}

void Mumps::solve(const Eigen::Ref<const Eigen::MatrixXd>& right,
                  Eigen::Ref<Eigen::MatrixXd> solution) const {
  auto& inside = *inside_;
  const auto columns = right.cols();
  const auto& first = inside.system.partition.first;
  // MUMPS takes whole columns on rank 0 and returns them there.
  Eigen::MatrixXd whole;
  std::vector<int> counts, starts;
  mpi::agreed_in_group(inside.comm, [&] {
    whole.resize(inside.rank == 0 ? inside.system.unknowns() : 0, columns);
    for (int r = 0; r < inside.ranks; ++r) {
      counts.push_back(3 * inside.system.partition.owned(r));
      starts.push_back(3 * first[static_cast<std::size_t>(r)]);
    }
  });
  const auto own = static_cast<int>(right.rows());
  for (Eigen::Index k = 0; k < columns; ++k) {
    MPI_Gatherv(right.col(k).data(), own, MPI_DOUBLE,
                inside.rank == 0 ? whole.col(k).data() : nullptr, counts.data(), starts.data(),
                MPI_DOUBLE, 0, inside.comm);
  }
  inside.id.rhs = whole.data();
  inside.id.nrhs = static_cast<MUMPS_INT>(columns);
  inside.id.lrhs = inside.id.n;
  inside.control(27) = static_cast<MUMPS_INT>(std::max<Eigen::Index>(columns, 1));
  inside.run(back_substitute);
  inside.refuse_failure();
  for (Eigen::Index k = 0; k < columns; ++k) {
    MPI_Scatterv(inside.rank == 0 ? whole.col(k).data() : nullptr, counts.data(), starts.data(),
                 MPI_DOUBLE, solution.col(k).data(), own, MPI_DOUBLE, 0, inside.comm);
  }
}

Inertia Mumps::inertia() const {
  Inertia out;
  out.negative = inside_->result(12);
  out.zero = inside_->result(28);
  return out;
}

}  // namespace carillon::solvers::eigen
