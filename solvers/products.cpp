#include "solvers/products.hpp"

#include <algorithm>
#include <array>
#include <numeric>

namespace carillon::solvers {
namespace {

std::vector<int> starts_of(const std::vector<int>& counts) {
  std::vector<int> starts(counts.size(), 0);
  std::partial_sum(counts.begin(), counts.end() - 1, starts.begin() + 1);
  return starts;
}

/// Wider vectors where the machine has them. The sums are the same to the last bit: each number is
/// summed by itself, in the same order.
#define CARILLON_WIDE [[gnu::target_clones("avx2", "default")]]

/// out += a x for Width neighbouring numbers.
template <int Width>
[[gnu::always_inline]] inline void add(double a, const double* x, double* out) {
  for (int k = 0; k < Width; ++k) out[k] += a * x[k];
}

/// A rank's rows as the loops want them.
struct Rows {
  std::int32_t count;
  const std::int64_t* first;
  const std::int32_t* place;
  const double* stiffness;
  const double* mass;
};

/// Writes a node's sums into the columns.
template <int Width>
[[gnu::always_inline]] inline void put(const double* sum, std::int32_t row, double* const* out) {
  for (int k = 0; k < Width; ++k) {
    for (int i = 0; i < 3; ++i)
      out[k][3 * static_cast<std::ptrdiff_t>(row) + i] = sum[i * Width + k];
  }
}

template <int Width>
[[gnu::always_inline]] inline void multiply_mass(const Rows& rows, const double* x,
                                                 double* const* out) {
  double sum[3 * Width];
  for (std::int32_t row = 0; row < rows.count; ++row) {
    std::fill_n(sum, 3 * Width, 0.0);
    for (auto k = rows.first[row]; k < rows.first[row + 1]; ++k) {
      add<3 * Width>(rows.mass[k], x + 3 * Width * std::ptrdiff_t{rows.place[k]}, sum);
    }
    put<Width>(sum, row, out);
  }
}

template <int Width>
[[gnu::always_inline]] inline void multiply_shifted(const Rows& rows, double shift, const double* x,
                                                    double* const* out) {
  double sum[3 * Width];
  for (std::int32_t row = 0; row < rows.count; ++row) {
    std::fill_n(sum, 3 * Width, 0.0);
    const auto begin = rows.first[row], width = rows.first[row + 1] - begin;
    const double* stiffness = rows.stiffness + 9 * begin;
    for (std::int64_t k = 0; k < width; ++k) {
      const double* node = x + 3 * Width * std::ptrdiff_t{rows.place[begin + k]};
      const double mass = shift * rows.mass[begin + k];
      for (std::int64_t i = 0; i < 3; ++i) {
        for (std::int64_t j = 0; j < 3; ++j) {
          const double entry = stiffness[3 * (i * width + k) + j] - (i == j ? mass : 0);
          add<Width>(entry, node + j * Width, sum + i * Width);
        }
      }
    }
    put<Width>(sum, row, out);
  }
}

CARILLON_WIDE void multiply_mass_8(const Rows& rows, const double* x, double* const* out) {
  multiply_mass<8>(rows, x, out);
}

CARILLON_WIDE void multiply_shifted_8(const Rows& rows, double shift, const double* x,
                                      double* const* out) {
  multiply_shifted<8>(rows, shift, x, out);
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

/// Columns `first` to `first + Width`, which `multiply` gets packed: a node's values lie together,
/// x of every column, then y, then z.
template <int Width, class Multiply>
void Products::block(const Eigen::Ref<const Eigen::MatrixXd>& x, Eigen::Index first,
                     Eigen::Ref<Eigen::MatrixXd> out, Multiply multiply) const {
  const auto rows = 3 * static_cast<std::size_t>(system_.graph.rows());
  std::vector<double> values(Width * (rows + 3 * static_cast<std::size_t>(from_others_)));
  std::array<double*, Width> to;
  for (std::size_t k = 0; k < Width; ++k) {
    const auto column = first + static_cast<Eigen::Index>(k);
    const double* from = x.col(column).data();
    for (std::size_t r = 0; r < rows; ++r) values[r * Width + k] = from[r];
    to[k] = out.col(column).data();
  }
  exchange<Width>(values);
  multiply(values.data(), to.data());
}

void Products::mass(const Eigen::Ref<const Eigen::MatrixXd>& x,
                    Eigen::Ref<Eigen::MatrixXd> out) const {
  const auto& graph = system_.graph;
  const Rows rows{graph.rows(), graph.first.data(), place_.data(), nullptr, system_.mass.data()};
  Eigen::Index k = 0;
  for (; k + 8 <= x.cols(); k += 8) {
    block<8>(x, k, out,
             [&](const double* from, double* const* to) { multiply_mass_8(rows, from, to); });
  }
  for (; k < x.cols(); ++k) {
    block<1>(x, k, out,
             [&](const double* from, double* const* to) { multiply_mass<1>(rows, from, to); });
  }
}

void Products::shifted(double shift, const Eigen::Ref<const Eigen::MatrixXd>& x,
                       Eigen::Ref<Eigen::MatrixXd> out) const {
  const auto& graph = system_.graph;
  const Rows rows{graph.rows(), graph.first.data(), place_.data(), system_.stiffness.data(),
                  system_.mass.data()};
  Eigen::Index k = 0;
  for (; k + 8 <= x.cols(); k += 8) {
    block<8>(x, k, out, [&](const double* from, double* const* to) {
      multiply_shifted_8(rows, shift, from, to);
    });
  }
  for (; k < x.cols(); ++k) {
    block<1>(x, k, out, [&](const double* from, double* const* to) {
      multiply_shifted<1>(rows, shift, from, to);
    });
  }
}

}  // namespace carillon::solvers
