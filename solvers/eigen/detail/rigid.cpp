#include "solvers/eigen/detail/rigid.hpp"

#include <fmt/core.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <numeric>

#include "core/error.hpp"
#include "solvers/eigen/detail/reduced.hpp"

namespace carillon::solvers::eigen {
namespace {

/// R^T M X, from the owned rows.
Eigen::MatrixXd projections(const assembly::System& system, const RigidMotions& motions,
                            const EigenPairs& pairs) {
  Eigen::MatrixXd out = Eigen::MatrixXd::Zero(motions.count(), pairs.size());
  for (std::int32_t row = 0; row < system.graph.rows(); ++row) {
    const auto number = static_cast<std::size_t>(system.graph.begin + row);
    const auto node = static_cast<std::size_t>(system.partition.node[number]);
    out.middleRows(motions.first_of(node), motions.each()).noalias() +=
        motions.at(node).transpose() * pairs.mass_vectors.middleRows<3>(3 * row);
  }
  return out;
}

}  // namespace

RigidMotions::RigidMotions(const mesh::TetMesh& mesh, const assembly::System& system,
                           const std::vector<std::int32_t>& component)
    : mesh_(mesh),
      scales_(system.scales),
      component_(component),
      kinds_(system.mirror.rigid_motions()) {
  const auto count =
      static_cast<std::size_t>(*std::max_element(component.begin(), component.end()) + 1);
  std::vector<std::vector<Vec3>> points(count);
  for (std::size_t n = 0; n < component.size(); ++n) {
    if (component[n] < 0) continue;
    points[static_cast<std::size_t>(component[n])].push_back(position(n));
  }
  for (const auto& cloud : points) boxes_.push_back(mesh::bounding_box(cloud));
  if (system.mirror.planes.empty()) return;
  // A class holds rotations about the planes alone, so about the whole body's middle.
  const auto& whole = system.mirror.box;
  for (auto& box : boxes_) {
    box = {(whole.low - scales_.origin) / scales_.length,
           (whole.high - scales_.origin) / scales_.length};
  }
}

Eigen::Matrix<double, 3, 6> rigid_motions_at(const Vec3& arm) {
  Eigen::Matrix<double, 3, 6> motions;
  motions.leftCols<3>().setIdentity();
  motions.rightCols<3>() << 0, arm[2], -arm[1],  //
      -arm[2], 0, arm[0],                        //
      arm[1], -arm[0], 0;
  return motions;
}

RigidMotions::AtNode RigidMotions::at(std::size_t node) const {
  const auto& box = boxes_[static_cast<std::size_t>(component_[node])];
  return rigid_motions_at((position(node) - (box.low + box.high) / 2) / box.longest_side())(
      Eigen::all, kinds_);
}

Eigen::MatrixXd gram_matrix(const assembly::System& system, const RigidMotions& motions,
                            MPI_Comm comm) {
  Eigen::MatrixXd gram = Eigen::MatrixXd::Zero(motions.count(), motions.count());
  const auto& graph = system.graph;
  const auto node_of = [&system](std::int32_t number) {
    return static_cast<std::size_t>(system.partition.node[static_cast<std::size_t>(number)]);
  };
  for (std::int32_t row = 0; row < graph.rows(); ++row) {
    const auto node = node_of(graph.begin + row);
    RigidMotions::AtNode weighted = RigidMotions::AtNode::Zero(3, motions.each());
    const auto r = static_cast<std::size_t>(row);
    for (auto i = graph.first[r]; i < graph.first[r + 1]; ++i) {
      const auto at = static_cast<std::size_t>(i);
      weighted += system.mass[at] * motions.at(node_of(graph.column[at]));
    }
    const auto first = motions.first_of(node);
    gram.block(first, first, motions.each(), motions.each()) +=
        motions.at(node).transpose() * weighted;
  }
  sum_alike(gram, comm);
  return gram;
}

Eigen::MatrixXd rigid_basis(const assembly::System& system, const RigidMotions& motions,
                            MPI_Comm comm) {
  const auto gram = gram_matrix(system, motions, comm);
  const auto each = motions.each();
  std::vector<Eigen::MatrixXd> to_orthonormal;  // of each component
  for (Eigen::Index first = 0; first < gram.rows(); first += each) {
    const Eigen::LLT<Eigen::MatrixXd> factor(gram.block(first, first, each, each));
    to_orthonormal.emplace_back(factor.matrixU().solve(Eigen::MatrixXd::Identity(each, each)));
  }
  Eigen::MatrixXd out = Eigen::MatrixXd::Zero(system.owned_unknowns(), motions.count());
  for (std::int32_t row = 0; row < system.graph.rows(); ++row) {
    const auto number = static_cast<std::size_t>(system.graph.begin + row);
    const auto node = static_cast<std::size_t>(system.partition.node[number]);
    const auto first = motions.first_of(node);
    out.block(3 * row, first, 3, each) =
        motions.at(node) * to_orthonormal[static_cast<std::size_t>(first / each)];
  }
  return out;
}

RigidSplit split_rigid(const mesh::TetMesh& mesh, const assembly::System& system,
                       const std::vector<std::int32_t>& component, const EigenPairs& pairs,
                       MPI_Comm comm) {
  const RigidMotions motions(mesh, system, component);
  if (motions.count() == 0) {
    RigidSplit split;
    split.flexible.resize(static_cast<std::size_t>(pairs.size()));
    std::iota(split.flexible.begin(), split.flexible.end(), 0);
    return split;
  }
  const auto gram = gram_matrix(system, motions, comm);
  auto projected = projections(system, motions, pairs);
  sum_alike(projected, comm);
  // Part of each pair's kinetic energy that is rigid: 1 or 0, but for rounding.
  const Eigen::MatrixXd normal = gram.llt().matrixL().solve(projected);
  const Eigen::VectorXd fraction = normal.colwise().squaredNorm();

  const auto wanted = static_cast<std::size_t>(motions.count());
  const auto all = static_cast<std::size_t>(pairs.size());
  std::vector<std::size_t> order(all);
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&fraction](std::size_t a, std::size_t b) {
    return fraction[static_cast<Eigen::Index>(a)] > fraction[static_cast<Eigen::Index>(b)];
  });
  RigidSplit split;
  double contained = 0;
  std::size_t recognised = 0;
  for (std::size_t k = 0; k < all; ++k) {
    const double part = fraction[static_cast<Eigen::Index>(order[k])];
    recognised += part > 0.5;
    if (k < wanted) {
      contained += part;
      split.rigid.push_back(order[k]);
    } else {
      split.flexible.push_back(order[k]);
    }
  }
  const double lacking = static_cast<double>(wanted) - contained;
  if (recognised == wanted && lacking > 1e-6 * static_cast<double>(wanted)) {
    throw core::SolverError(
        fmt::format(
            "the rigid motions of the object come out mixed with vibrations: {:.1e} of their "
            "energy is missing",
            lacking / static_cast<double>(wanted)),
        "the mesh may have elements that are nearly flat, or parts of almost no mass or stiffness");
  }
  if (recognised != wanted) {
    throw core::SolverError(
        fmt::format("{} rigid modes found where the body has {}", recognised, wanted),
        "the mesh may have parts of almost no mass or stiffness");
  }
  std::sort(split.rigid.begin(), split.rigid.end());
  std::sort(split.flexible.begin(), split.flexible.end());
  return split;
}

}  // namespace carillon::solvers::eigen
