#include "solvers/assembly/products.hpp"

#include <algorithm>
#include <array>
#include <cstring>
#include <numeric>

namespace carillon::solvers::assembly {
namespace {

std::vector<int> starts_of(const std::vector<int>& counts) {
  std::vector<int> starts(counts.size(), 0);
  std::partial_sum(counts.begin(), counts.end() - 1, starts.begin() + 1);
  return starts;
}

/// Wider vectors where the machine has them. The sums are the same to the last bit: each number is
/// summed by itself, in the same order.
#define CARILLON_WIDE [[gnu::target_clones("avx512f", "avx2", "default")]]

/// Values of one component at one node, of eight columns.
using Eight [[gnu::vector_size(8 * sizeof(double))]] = double;

/// One node's x, y and z.
template <class Values>
struct Node {
  Values x, y, z;
  [[gnu::always_inline]] inline explicit Node(const double* from) {
    std::memcpy(this, from, sizeof *this);
  }
};

/// As many columns as cost more one by one than eight together.
constexpr Eigen::Index few = 3;

/// A rank's rows as the loops want them.
struct Rows {
  std::int32_t count;
  const std::int64_t* first;
  const std::int32_t* place;
  const double* stiffness;
  const double* mass;
};

/// Writes a row's sums into the columns.
[[gnu::always_inline]] inline void put(const Eight& values, std::ptrdiff_t row,
                                       double* const* out) {
  for (int k = 0; k < 8; ++k) out[k][row] = values[k];
}
[[gnu::always_inline]] inline void put(double value, std::ptrdiff_t row, double* const* out) {
  out[0][row] = value;
}

/// @tparam Values  Eight, or double for a single column
template <class Values>
[[gnu::always_inline]] inline void multiply_mass(const Rows& rows, const double* x,
                                                 double* const* out) {
  // A vector, no pointer: NOLINTNEXTLINE(bugprone-sizeof-expression)
  constexpr std::ptrdiff_t columns = sizeof(Values) / sizeof(double);
  for (std::int32_t row = 0; row < rows.count; ++row) {
    Values sum_x = {}, sum_y = {}, sum_z = {};
    for (auto k = rows.first[row]; k < rows.first[row + 1]; ++k) {
      const Node<Values> node(x + 3 * columns * rows.place[k]);
      const double mass = rows.mass[k];
      sum_x += mass * node.x;
      sum_y += mass * node.y;
      sum_z += mass * node.z;
    }
    put(sum_x, 3 * std::ptrdiff_t{row}, out);
    put(sum_y, 3 * std::ptrdiff_t{row} + 1, out);
    put(sum_z, 3 * std::ptrdiff_t{row} + 2, out);
  }
}

/// @tparam Values  Eight, or double for a single column
template <class Values>
[[gnu::always_inline]] inline void multiply_shifted(const Rows& rows, double shift, const double* x,
                                                    double* const* out) {
  // A vector, no pointer: NOLINTNEXTLINE(bugprone-sizeof-expression)
  constexpr std::ptrdiff_t columns = sizeof(Values) / sizeof(double);
  for (std::int32_t row = 0; row < rows.count; ++row) {
    Values sum_x = {}, sum_y = {}, sum_z = {};
    const auto begin = rows.first[row], width = rows.first[row + 1] - begin;
    const double* of_x = rows.stiffness + 9 * begin;
    const double *of_y = of_x + 3 * width, *of_z = of_y + 3 * width;
    for (std::int64_t k = 0; k < width; ++k, of_x += 3, of_y += 3, of_z += 3) {
      const Node<Values> node(x + 3 * columns * rows.place[begin + k]);
      const double mass = shift * rows.mass[begin + k];
      sum_x += (of_x[0] - mass) * node.x;
      sum_y += of_y[0] * node.x;
      sum_z += of_z[0] * node.x;
      sum_x += of_x[1] * node.y;
      sum_y += (of_y[1] - mass) * node.y;
      sum_z += of_z[1] * node.y;
      sum_x += of_x[2] * node.z;
      sum_y += of_y[2] * node.z;
      sum_z += (of_z[2] - mass) * node.z;
    }
    put(sum_x, 3 * std::ptrdiff_t{row}, out);
    put(sum_y, 3 * std::ptrdiff_t{row} + 1, out);
    put(sum_z, 3 * std::ptrdiff_t{row} + 2, out);
  }
}

CARILLON_WIDE void multiply_mass_8(const Rows& rows, const double* x, double* const* out) {
  multiply_mass<Eight>(rows, x, out);
}

CARILLON_WIDE void multiply_shifted_8(const Rows& rows, double shift, const double* x,
                                      double* const* out) {
  multiply_shifted<Eight>(rows, shift, x, out);
}

}  // namespace

Products::Products(const System& system, MPI_Comm comm) : system_(system), comm_(comm) {
  int ranks = 1;
  MPI_Comm_size(comm, &ranks);
  const auto& graph = system.graph;
  place_ = graph.column;
  if (ranks == 1) return;
  const auto end = graph.begin + graph.rows();
  std::vector<std::int32_t> others;
  for (const auto number : graph.column) {
    if (number < graph.begin || number >= end) others.push_back(number);
  }
  std::sort(others.begin(), others.end());
  others.erase(std::unique(others.begin(), others.end()), others.end());
  from_others_ = static_cast<std::int32_t>(others.size());
  for (auto& place : place_) {
    if (place >= graph.begin && place < end) {
      place -= graph.begin;
    } else {
      const auto at = std::lower_bound(others.begin(), others.end(), place) - others.begin();
      place = graph.rows() + static_cast<std::int32_t>(at);
    }
  }
  // Numbers are contiguous by rank, so the sorted list falls into one piece for each.
  const auto& first = system.partition.first;
  receive_counts_.assign(static_cast<std::size_t>(ranks), 0);
  for (const auto number : others) {
    const auto owner = std::upper_bound(first.begin(), first.end(), number) - first.begin() - 1;
    ++receive_counts_[static_cast<std::size_t>(owner)];
  }
  send_counts_.resize(static_cast<std::size_t>(ranks));
  MPI_Alltoall(receive_counts_.data(), 1, MPI_INT, send_counts_.data(), 1, MPI_INT, comm);
  const auto send_starts = starts_of(send_counts_), receive_starts = starts_of(receive_counts_);
  to_send_.resize(static_cast<std::size_t>(send_starts.back() + send_counts_.back()));
  MPI_Alltoallv(others.data(), receive_counts_.data(), receive_starts.data(), MPI_INT32_T,
                to_send_.data(), send_counts_.data(), send_starts.data(), MPI_INT32_T, comm);
  for (auto& number : to_send_) number -= graph.begin;
}

/// Appends the rows that other ranks own.
template <int Width>
void Products::exchange(std::vector<double>& values) const {
  if (receive_counts_.empty()) return;
  constexpr std::size_t width = 3 * Width;
  std::vector<double> out;
  out.reserve(width * to_send_.size());
  for (const auto row : to_send_) {
    const auto* begin = values.data() + width * static_cast<std::size_t>(row);
    out.insert(out.end(), begin, begin + width);
  }
  MPI_Datatype row_type;
  MPI_Type_contiguous(static_cast<int>(width), MPI_DOUBLE, &row_type);
  MPI_Type_commit(&row_type);
  const auto send_starts = starts_of(send_counts_), receive_starts = starts_of(receive_counts_);
  auto* const ghosts = values.data() + width * static_cast<std::size_t>(system_.graph.rows());
  MPI_Alltoallv(out.data(), send_counts_.data(), send_starts.data(), row_type, ghosts,
                receive_counts_.data(), receive_starts.data(), row_type, comm_);
  MPI_Type_free(&row_type);
}

/// Columns `first` to `first + Width`, or those that are left, which `multiply` gets packed: a
/// node's values lie together, x of every column, then y, then z.
template <int Width, class Multiply>
void Products::block(const Eigen::Ref<const Eigen::MatrixXd>& x, Eigen::Index first,
                     Eigen::Ref<Eigen::MatrixXd> out, Multiply multiply) const {
  const auto rows = 3 * static_cast<std::size_t>(system_.graph.rows());
  std::vector<double> values(Width * (rows + 3 * static_cast<std::size_t>(from_others_))), unused;
  std::array<double*, Width> to;
  for (std::size_t k = 0; k < Width; ++k) {
    const auto column = first + static_cast<Eigen::Index>(k);
    if (column >= x.cols()) {
      unused.resize(rows);
      to[k] = unused.data();
      continue;
    }
    const double* from = x.col(column).data();
    for (std::size_t r = 0; r < rows; ++r) values[r * Width + k] = from[r];
    to[k] = out.col(column).data();
  }
  exchange<Width>(values);
  multiply(values.data(), to.data());
}

void Products::mass(const Eigen::Ref<const Eigen::MatrixXd>& x,
                    // Written through: NOLINTNEXTLINE(performance-unnecessary-value-param)
                    Eigen::Ref<Eigen::MatrixXd> out) const {
  const auto& graph = system_.graph;
  const Rows rows{graph.rows(), graph.first.data(), place_.data(), nullptr, system_.mass.data()};
  Eigen::Index k = 0;
  for (; k + few <= x.cols(); k += 8) {
    block<8>(x, k, out,
             [&](const double* from, double* const* to) { multiply_mass_8(rows, from, to); });
  }
  for (; k < x.cols(); ++k) {
    block<1>(x, k, out,
             [&](const double* from, double* const* to) { multiply_mass<double>(rows, from, to); });
  }
  hold(system_, out);
}

void Products::shifted(double shift, const Eigen::Ref<const Eigen::MatrixXd>& x,
                       // Written through: NOLINTNEXTLINE(performance-unnecessary-value-param)
                       Eigen::Ref<Eigen::MatrixXd> out) const {
  const auto& graph = system_.graph;
  const Rows rows{graph.rows(), graph.first.data(), place_.data(), system_.stiffness.data(),
                  system_.mass.data()};
  Eigen::Index k = 0;
  for (; k + few <= x.cols(); k += 8) {
    block<8>(x, k, out, [&](const double* from, double* const* to) {
      multiply_shifted_8(rows, shift, from, to);
    });
  }
  for (; k < x.cols(); ++k) {
    block<1>(x, k, out, [&](const double* from, double* const* to) {
      multiply_shifted<double>(rows, shift, from, to);
    });
  }
  hold(system_, out);
}

}  // namespace carillon::solvers::assembly
