#include "solvers/eigen/detail/local_solves.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <span>

#include "solvers/assembly/partition.hpp"
#include "solvers/elements/lagrange.hpp"

namespace carillon::solvers::eigen {
namespace {

using Block = Eigen::Map<Eigen::MatrixXf>;

/// Cholesky in place. Rounding to single precision can cost a very flat block its definiteness; a
/// slightly stiffer block serves as well.
void factor(Block block) {
  const Eigen::MatrixXf matrix = block;
  Eigen::LLT<Eigen::MatrixXf> cholesky;
  for (float stiffer = 0; stiffer<1; stiffer = stiffer> 0 ? 10 * stiffer : 1e-6f) {
    Eigen::MatrixXf raised = matrix;
    raised.diagonal() *= 1 + stiffer;
    cholesky.compute(raised);
    if (cholesky.info() == Eigen::Success) {
      block = cholesky.matrixLLT();
      return;
    }
  }
  // Jacobi's method remains.
  block.setZero();
  block.diagonal() = matrix.diagonal().cwiseAbs().cwiseSqrt();
}

}  // namespace

std::int64_t LocalSolves::bytes(std::size_t elements, int order) {
  const auto size = static_cast<std::int64_t>(3 * elements::nodes_per_tetrahedron(order));
  return static_cast<std::int64_t>(elements * sizeof(float)) * size * size;
}

LocalSolves::LocalSolves(const FinerSpace& space)
    : space_(space), size_(3 * elements::nodes_per_tetrahedron(space.mesh().order)) {
  const mesh::TetMesh& mesh = space.mesh();
  const auto own = space.own_elements();
  const auto entries = static_cast<std::size_t>(size_ * size_);
  blocks_.assign(own.size() * entries, 0.0f);

  const auto around = assembly::elements_around_nodes(mesh);
  std::vector<std::int32_t> block_of(mesh.element_count(), -1);
  for (std::size_t k = 0; k < own.size(); ++k) block_of[own[k]] = static_cast<std::int32_t>(k);
  std::vector<std::int32_t> place(mesh.nodes.size(), -1);  // of a node in the element at hand
  std::vector<std::int32_t> near, mine, theirs;
  space.for_each_matrix([&](std::size_t e, const Eigen::MatrixXd& a) {
    const auto element = mesh.element(e);
    near.clear();
    for (const auto corner : element.first(4)) {
      const auto c = static_cast<std::size_t>(corner);
      for (auto i = around.first[c]; i < around.first[c + 1]; ++i) {
        near.push_back(around.list[static_cast<std::size_t>(i)]);
      }
    }
    std::sort(near.begin(), near.end());
    near.erase(std::unique(near.begin(), near.end()), near.end());
    for (std::size_t i = 0; i < element.size(); ++i) {
      place[static_cast<std::size_t>(element[i])] = static_cast<std::int32_t>(i);
    }
    for (const auto other : near) {
      const auto k = block_of[static_cast<std::size_t>(other)];
      if (k < 0) continue;
      mine.clear();
      theirs.clear();
      const auto nodes = mesh.element(static_cast<std::size_t>(other));
      for (std::size_t i = 0; i < nodes.size(); ++i) {
        const auto at = place[static_cast<std::size_t>(nodes[i])];
        if (at < 0) continue;
        mine.push_back(at);
        theirs.push_back(static_cast<std::int32_t>(i));
      }
      Block block(blocks_.data() + static_cast<std::size_t>(k) * entries, size_, size_);
      for (std::size_t j = 0; j < mine.size(); ++j) {
        for (std::size_t i = 0; i < mine.size(); ++i) {
          block.block<3, 3>(3 * theirs[i], 3 * theirs[j]) +=
              a.block<3, 3>(3 * mine[i], 3 * mine[j]).cast<float>();
        }
      }
    }
    for (const auto n : element) place[static_cast<std::size_t>(n)] = -1;
  });
  for (std::size_t k = 0; k < own.size(); ++k) {
    factor(Block(blocks_.data() + k * entries, size_, size_));
  }
  for (std::size_t n = 0; n < mesh.nodes.size(); ++n) {
    share_.push_back(1 / std::sqrt(static_cast<float>(around.first[n + 1] - around.first[n])));
  }
}

void LocalSolves::add(const Fields& residual, Fields& out) const {
  const auto own = space_.own_elements();
  const auto entries = static_cast<std::size_t>(size_ * size_);
  const auto rows = residual.rows(), chunk = 3 * rows;
  Eigen::MatrixXf local(rows, size_);
  for (std::size_t k = 0; k < own.size(); ++k) {
    const auto element = space_.mesh().element(own[k]);
    for (std::size_t a = 0; a < element.size(); ++a) {
      const auto node = element[a];
      Eigen::Map<Eigen::VectorXf>(local.data() + static_cast<Eigen::Index>(a) * chunk, chunk) =
          share_[static_cast<std::size_t>(node)] *
          Eigen::Map<const Eigen::VectorXd>(residual.data() + node * chunk, chunk).cast<float>();
    }
    const Eigen::Map<const Eigen::MatrixXf> block(blocks_.data() + k * entries, size_, size_);
    const auto lower = block.triangularView<Eigen::Lower>();
    lower.transpose().solveInPlace<Eigen::OnTheRight>(local);
    lower.solveInPlace<Eigen::OnTheRight>(local);
    for (std::size_t a = 0; a < element.size(); ++a) {
      const auto node = element[a];
      Eigen::Map<Eigen::VectorXd>(out.data() + node * chunk, chunk) +=
          (share_[static_cast<std::size_t>(node)] *
           Eigen::Map<const Eigen::VectorXf>(local.data() + static_cast<Eigen::Index>(a) * chunk,
                                             chunk))
              .cast<double>();
    }
  }
}

}  // namespace carillon::solvers::eigen
