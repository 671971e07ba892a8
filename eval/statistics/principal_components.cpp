#include "eval/statistics/principal_components.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "core/error.hpp"

namespace carillon::eval::statistics {

PrincipalComponents principal_components(std::span<const double> values, std::size_t columns,
                                         std::size_t count) {
  if (columns == 0 || values.size() % columns != 0 || values.size() < 2 * columns) {
    throw core::InputError("principal components need two rows at least");
  }
  const auto rows = static_cast<Eigen::Index>(values.size() / columns);
  using Rows = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  Rows centred = Eigen::Map<const Rows>(values.data(), rows, static_cast<Eigen::Index>(columns));
  const Eigen::RowVectorXd mean = centred.colwise().mean();
  centred.rowwise() -= mean;
  const double all = centred.squaredNorm();
  // Of the smaller of the two products; its eigenvectors give those of the other.
  const bool few_rows = rows < centred.cols();
  const Eigen::MatrixXd product = few_rows ? Eigen::MatrixXd(centred * centred.transpose())
                                           : Eigen::MatrixXd(centred.transpose() * centred);
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(product);
  PrincipalComponents found;
  found.mean.assign(mean.data(), mean.data() + mean.size());
  std::vector<Eigen::VectorXd> directions;
  for (Eigen::Index i = product.cols() - 1; i >= 0 && directions.size() < count; --i) {
    const double variance = solver.eigenvalues()[i];
    if (!(variance > 1e-12 * all)) break;
    Eigen::VectorXd direction = solver.eigenvectors().col(i);
    if (few_rows) direction = (centred.transpose() * direction).normalized();
    Eigen::Index largest = 0;
    direction.cwiseAbs().maxCoeff(&largest);
    if (direction[largest] < 0) direction = -direction;
    found.fractions.push_back(variance / all);
    found.components.insert(found.components.end(), direction.begin(), direction.end());
    directions.push_back(std::move(direction));
  }
  for (Eigen::Index row = 0; row < rows; ++row) {
    for (const Eigen::VectorXd& direction : directions) {
      found.coordinates.push_back(centred.row(row).dot(direction));
    }
  }
  return found;
}

double explained_by_groups(std::span<const double> values, std::span<const std::size_t> groups) {
  if (values.size() != groups.size()) throw core::InputError("one group for each value is wanted");
  struct Sum {
    double sum = 0, count = 0;
  };
  std::map<std::size_t, Sum> sums;
  double mean = 0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    sums[groups[i]].sum += values[i];
    sums[groups[i]].count += 1;
    mean += values[i] / static_cast<double>(values.size());
  }
  double all = 0, between = 0;
  for (const double value : values) all += (value - mean) * (value - mean);
  for (const auto& [group, own] : sums) {
    between += own.count * std::pow(own.sum / own.count - mean, 2);
  }
  return all > 0 ? between / all : std::numeric_limits<double>::quiet_NaN();
}

}  // namespace carillon::eval::statistics
