#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

#include "solvers/mesh/tet_mesh.hpp"

namespace carillon::solvers::modes {

/// Nodes of a turned surface with one number after the other, at equal angles from the x axis on.
struct NodeRing {
  std::int32_t first = 0;   ///< number of the first node
  std::int32_t around = 1;  ///< nodes in a full turn; 1 on the axis
  bool operator==(const NodeRing&) const = default;
};

/// The Fourier term in the angle about the axis that a mode of a body of revolution is.
struct CircumferentialWave {
  std::int32_t harmonic = 0;  ///< waves around the axis
  std::int32_t turned = 0;    ///< 1: the second mode of a pair, turned by a quarter of a wave
  bool operator==(const CircumferentialWave&) const = default;
};

/// Mass-normalised mode shapes [kg^-1/2] on the nodes of a surface. Those of a body of revolution
/// are kept as what they are on the section, at a small part of the room: on a ring at the angle t
/// displacements are u cos(n t) along the radius, v sin(n t) around and w cos(n t) along z; of a
/// turned mode u sin(n t), -v cos(n t) and w sin(n t); and of n = 0 u, v and w.
class ModeShapes {
 public:
  using Rows = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

  ModeShapes() = default;
  /// @param at_nodes  a row for each mode: x y z of every node
  explicit ModeShapes(Rows at_nodes);
  /// @param amplitudes  a row for each mode: u v w of every ring
  /// @param rings  by their first node, leaving out none; empty: `amplitudes` are at nodes
  ModeShapes(Rows amplitudes, std::vector<NodeRing> rings, std::vector<CircumferentialWave> waves);

  Eigen::Index modes() const { return values_.rows(); }
  Eigen::Index nodes() const;

  /// x y z of every node, one after the other.
  Eigen::VectorXd of(Eigen::Index mode) const;
  /// x y z of each mode at a node: modes() x 3.
  Eigen::MatrixX3d at(Eigen::Index node) const;
  /// x y z of every node in a row for each mode: modes() x 3 nodes().
  Rows at_nodes() const;

  ModeShapes select(std::span<const Eigen::Index> chosen) const;
  ModeShapes& operator*=(float factor);

  /// Waves around the axis of a body of revolution, one number for each mode; empty for shapes that
  /// know of no axis.
  std::vector<int> harmonics() const;

  /// As the constructors take them.
  const Rows& values() const { return values_; }
  const std::vector<NodeRing>& rings() const { return rings_; }
  const std::vector<CircumferentialWave>& waves() const { return waves_; }

 private:
  Rows values_;
  std::vector<NodeRing> rings_;
  std::vector<CircumferentialWave> waves_;
};

}  // namespace carillon::solvers::modes
