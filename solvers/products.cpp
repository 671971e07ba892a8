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

/// out += a x for Width neighbouring numbers.
template <int Width>
inline void add(double a, const double* x, double* out) {
  for (int k = 0; k < Width; ++k) out[k] += a * x[k];
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

/// Columns `first` to `first + Width`. Inside, a node's values lie together: x of every column,
/// then y, then z.
template <int Width, class Row>
void Products::multiply_block(const Eigen::Ref<const Eigen::MatrixXd>& x, Eigen::Index first,
                              Eigen::Ref<Eigen::MatrixXd> out, Row& row) const {
  const auto rows = static_cast<Eigen::Index>(system_.graph.rows());
  std::vector<double> values(3 * Width *
                             static_cast<std::size_t>(system_.graph.rows() + from_others_));
  for (Eigen::Index k = 0; k < Width; ++k) {
    const double* from = x.col(first + k).data();
    for (Eigen::Index r = 0; r < 3 * rows; ++r) {
      values[static_cast<std::size_t>(r * Width + k)] = from[r];
    }
  }
  exchange<Width>(values);
  std::array<double*, Width> to;
  for (std::size_t k = 0; k < Width; ++k) {
    to[k] = out.col(first + static_cast<Eigen::Index>(k)).data();
  }
  std::array<double, 3 * Width> sum;
  for (std::int32_t r = 0; r < system_.graph.rows(); ++r) {
    sum.fill(0);
    row.template operator()<Width>(r, values.data(), sum.data());
    for (std::size_t k = 0; k < Width; ++k) {
      for (std::size_t i = 0; i < 3; ++i) {
        to[k][3 * static_cast<std::size_t>(r) + i] = sum[i * Width + k];
      }
    }
  }
}

template <class Row>
void Products::multiply(const Eigen::Ref<const Eigen::MatrixXd>& x, Eigen::Ref<Eigen::MatrixXd> out,
                        Row row) const {
  Eigen::Index k = 0;
  for (; k + 8 <= x.cols(); k += 8) multiply_block<8>(x, k, out, row);
  for (; k < x.cols(); ++k) multiply_block<1>(x, k, out, row);
}

void Products::mass(const Eigen::Ref<const Eigen::MatrixXd>& x,
                    Eigen::Ref<Eigen::MatrixXd> out) const {
  const auto& first = system_.graph.first;
  multiply(x, out, [&]<int Width>(std::int32_t r, const double* values, double* sum) {
    const auto row = static_cast<std::size_t>(r);
    for (auto k = first[row]; k < first[row + 1]; ++k) {
      const auto at = static_cast<std::size_t>(k);
      add<3 * Width>(system_.mass[at], values + 3 * Width * static_cast<std::size_t>(place_[at]),
                     sum);
    }
  });
}

void Products::shifted(double shift, const Eigen::Ref<const Eigen::MatrixXd>& x,
                       Eigen::Ref<Eigen::MatrixXd> out) const {
  const auto& first = system_.graph.first;
  multiply(x, out, [&]<int Width>(std::int32_t r, const double* values, double* sum) {
    const auto row = static_cast<std::size_t>(r);
    const auto begin = first[row], width = first[row + 1] - begin;
    const double* stiffness = system_.stiffness.data() + 9 * begin;
    for (std::int64_t k = 0; k < width; ++k) {
      const auto at = static_cast<std::size_t>(begin + k);
      const double* x_node = values + 3 * Width * static_cast<std::size_t>(place_[at]);
      const double mass = shift * system_.mass[at];
      for (std::int64_t i = 0; i < 3; ++i) {
        for (std::int64_t j = 0; j < 3; ++j) {
          const double entry = stiffness[3 * (i * width + k) + j] - (i == j ? mass : 0);
          add<Width>(entry, x_node + j * Width, sum + i * Width);
        }
      }
    }
  });
}

}  // namespace carillon::solvers
