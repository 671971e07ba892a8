#include "solvers/elements/element.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

#include "solvers/elements/lagrange.hpp"
#include "solvers/elements/quadrature.hpp"

namespace carillon::solvers::elements {
namespace {

/// A node may lie this far from its place on the straight element, relative to the element, before
/// the element counts as curved: rounding of coordinates, nothing more.
constexpr double straight_tolerance = 1e-11;

Eigen::MatrixXd slopes_at(int order, const Eigen::Vector4d& point) {
  Eigen::Matrix<double, Eigen::Dynamic, 4> gradient;
  tetrahedron_shape_functions(order, point, &gradient);
  return gradient.rightCols<3>().colwise() - gradient.col(0);
}

/// a a^T, symmetric to the last bit.
void square(const Eigen::MatrixXd& a, Eigen::MatrixXd& out) {
  out.setZero(a.rows(), a.rows());
  out.selfadjointView<Eigen::Lower>().rankUpdate(a);
  out.triangularView<Eigen::StrictlyUpper>() = out.transpose();
}

/// Where a pair of axes stands in Voigt's order.
constexpr int voigt[3][3] = {{0, 5, 4}, {5, 1, 3}, {4, 3, 2}};

using Tensor = Eigen::Matrix<double, 9, 9>;

/// Maps integrals of N_a,k N_b,l (at k + 3 l) to the block K_ij (at i + 3 j): C_ikjl.
Tensor coupling(const Voigt& stiffness) {
  Tensor tensor;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      for (int k = 0; k < 3; ++k)
        for (int l = 0; l < 3; ++l)
          tensor(i + 3 * j, k + 3 * l) = stiffness(voigt[i][k], voigt[j][l]);
  return tensor;
}

}  // namespace

ElasticConstants isotropic_constants(double youngs_modulus, double poisson_ratio, double density) {
  const double mu = youngs_modulus / (2 * (1 + poisson_ratio));
  return {2 * mu * poisson_ratio / (1 - 2 * poisson_ratio), mu, density, {}};
}

ElementKernel::ElementKernel(int order)
    : order_(order),
      nodes_(nodes_per_tetrahedron(order)),
      straight_(tabulate(order)),
      curved_(tabulate(order + 1)),
      curved_mass_(tabulate(order + 2)) {
  to_straight_.resize(4, nodes_);
  for (int n = 0; n < nodes_; ++n) {
    const auto& tuple = tetrahedron_lattice(order)[static_cast<std::size_t>(n)];
    for (int v = 0; v < 4; ++v) {
      to_straight_(v, n) = static_cast<double>(tuple[static_cast<std::size_t>(v)]) / order;
    }
  }
  for (int v = 0; v < 4; ++v) corner_slopes_.push_back(slopes_at(order, Eigen::Vector4d::Unit(v)));
  const auto exact = tabulate(order + 1);
  square(exact.values * exact.weights.cwiseSqrt().asDiagonal(), reference_mass_);
  reference_root_ = reference_mass_.llt().matrixU();
}

ElementKernel::Table ElementKernel::tabulate(int points) const {
  const auto& rule = tetrahedron_rule(points);
  Table table;
  table.weights = Eigen::Map<const Eigen::VectorXd>(rule.weights.data(),
                                                    static_cast<Eigen::Index>(rule.size()));
  table.values.resize(nodes_, table.weights.size());
  for (std::size_t q = 0; q < rule.size(); ++q) {
    table.values.col(static_cast<Eigen::Index>(q)) =
        tetrahedron_shape_functions(order_, rule.barycentric[q], nullptr);
    table.slopes.push_back(slopes_at(order_, rule.barycentric[q]));
  }
  return table;
}

double ElementKernel::map(const Coordinates& nodes, const Table& table, Eigen::MatrixXd& gradients,
                          Eigen::VectorXd& volumes) const {
  const auto points = table.weights.size();
  gradients.resize(nodes_, 3 * points);
  volumes.resize(points);
  double smallest = std::numeric_limits<double>::infinity();
  for (Eigen::Index q = 0; q < points; ++q) {
    const auto& slopes = table.slopes[static_cast<std::size_t>(q)];
    const Eigen::Matrix3d jacobian = nodes * slopes;  // dx / dL
    const double determinant = jacobian.determinant();
    smallest = std::min(smallest, determinant);
    volumes[q] = table.weights[q] * determinant;
    gradients.middleCols<3>(3 * q).noalias() = slopes * jacobian.inverse();
  }
  return smallest;
}

double ElementKernel::place(const Coordinates& nodes) {
  const double size = (nodes.leftCols<4>().colwise() - nodes.col(0)).cwiseAbs().maxCoeff();
  const double bend = (nodes - nodes.leftCols<4>() * to_straight_).cwiseAbs().maxCoeff();
  is_straight_ = bend <= straight_tolerance * size;
  if (is_straight_) {
    Eigen::Matrix3d jacobian = nodes.middleCols<3>(1).colwise() - nodes.col(0);
    determinant_ = jacobian.determinant();
    if (!(determinant_ > 0)) return determinant_;
    const Eigen::Matrix3d inverse = jacobian.inverse();
    const auto points = straight_.weights.size();
    gradients_.resize(nodes_, 3 * points);
    for (Eigen::Index q = 0; q < points; ++q) {
      gradients_.middleCols<3>(3 * q).noalias() =
          straight_.slopes[static_cast<std::size_t>(q)] * inverse;
    }
    volumes_ = determinant_ * straight_.weights;
    return determinant_;
  }
  double smallest = std::numeric_limits<double>::infinity();
  for (const auto& slopes : corner_slopes_) {
    const Eigen::Matrix3d jacobian = nodes * slopes;
    smallest = std::min(smallest, jacobian.determinant());
  }
  smallest = std::min(smallest, map(nodes, curved_, gradients_, volumes_));
  mass_volumes_.resize(curved_mass_.weights.size());
  for (Eigen::Index q = 0; q < mass_volumes_.size(); ++q) {
    const Eigen::Matrix3d jacobian = nodes * curved_mass_.slopes[static_cast<std::size_t>(q)];
    const double determinant = jacobian.determinant();
    smallest = std::min(smallest, determinant);
    mass_volumes_[q] = curved_mass_.weights[q] * determinant;
  }
  return smallest;
}

void ElementKernel::stiffness(const ElasticConstants& material, Eigen::MatrixXd& k) {
  const auto points = volumes_.size();
  // One product gives every integral of N_a,i N_b,j: rows and columns i nodes + a.
  weighted_.resize(3 * nodes_, points);
  for (Eigen::Index q = 0; q < points; ++q) {
    const double root = std::sqrt(volumes_[q]);
    for (int i = 0; i < 3; ++i) {
      weighted_.col(q).segment(i * nodes_, nodes_) = root * gradients_.col(3 * q + i);
    }
  }
  square(weighted_, products_);
  const Tensor general = material.stiffness ? coupling(*material.stiffness) : Tensor();
  k.resize(3 * nodes_, 3 * nodes_);
  for (int b = 0; b < nodes_; ++b) {
    for (int a = b; a < nodes_; ++a) {
      Eigen::Matrix3d s;
      for (int j = 0; j < 3; ++j) {
        for (int i = 0; i < 3; ++i) s(i, j) = products_(i * nodes_ + a, j * nodes_ + b);
      }
      Eigen::Matrix3d block;
      if (material.stiffness) {
        const auto gradients = Eigen::Map<const Eigen::Vector<double, 9>>(s.data());
        Eigen::Map<Eigen::Vector<double, 9>>(block.data()).noalias() = general * gradients;
      } else {
        block = material.lambda * s + material.mu * s.transpose();
        block.diagonal().array() += material.mu * s.trace();
      }
      k.block<3, 3>(3 * a, 3 * b) = block;
      k.block<3, 3>(3 * b, 3 * a) = block.transpose();
    }
  }
}

void ElementKernel::mass(double density, Eigen::MatrixXd& m) {
  if (is_straight_) {
    m = (density * determinant_) * reference_mass_;
    return;
  }
  const Eigen::VectorXd roots = (density * mass_volumes_).cwiseSqrt();
  weighted_.noalias() = curved_mass_.values * roots.asDiagonal();
  square(weighted_, m);
}

void ElementKernel::add_energies(const ElasticConstants& material,
                                 const Eigen::Ref<const Eigen::MatrixXd>& u,
                                 Eigen::Ref<Eigen::ArrayXd> strain,
                                 Eigen::Ref<Eigen::ArrayXd> kinetic) {
  const auto fields = u.cols() / 3;
  products_.noalias() = gradients_.transpose() * u;  // rows 3 q + i: derivative by x_i
  const auto points = volumes_.size();
  for (Eigen::Index f = 0; f < fields; ++f) {
    double sum = 0;
    for (Eigen::Index q = 0; q < points; ++q) {
      const auto h = products_.block<3, 3>(3 * q, 3 * f);
      const double trace = h(0, 0) + h(1, 1) + h(2, 2);
      const double xy = h(0, 1) + h(1, 0), xz = h(0, 2) + h(2, 0), yz = h(1, 2) + h(2, 1);
      if (material.stiffness) {
        const Eigen::Vector<double, 6> e(h(0, 0), h(1, 1), h(2, 2), yz, xz, xy);
        sum += volumes_[q] * e.dot(*material.stiffness * e);
        continue;
      }
      const double normal = h(0, 0) * h(0, 0) + h(1, 1) * h(1, 1) + h(2, 2) * h(2, 2);
      sum += volumes_[q] * (material.lambda * trace * trace +
                            material.mu * (2 * normal + xy * xy + xz * xz + yz * yz));
    }
    strain[f] += sum;
  }
  if (is_straight_) {
    weighted_.noalias() = reference_root_ * u;
    for (Eigen::Index f = 0; f < fields; ++f) {
      kinetic[f] += material.density * determinant_ * weighted_.middleCols<3>(3 * f).squaredNorm();
    }
    return;
  }
  weighted_.noalias() = curved_mass_.values.transpose() * u;
  for (Eigen::Index f = 0; f < fields; ++f) {
    const auto at_points = weighted_.middleCols<3>(3 * f).rowwise().squaredNorm();
    kinetic[f] += material.density * at_points.dot(mass_volumes_);
  }
}

}  // namespace carillon::solvers::elements
