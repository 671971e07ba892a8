#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <map>
#include <vector>

#include "solvers/axisymmetric/detail/harmonic_forms.hpp"
#include "solvers/modes/modes.hpp"

namespace carillon::solvers::axisymmetric {

/// The surface that a section's outline makes when turned, in curved triangles of order 3, and how
/// fields of harmonics are evaluated on it. A full turn has at least nine nodes to the wave of the
/// highest harmonic, and triangles about as long as wide.
class TurnedSurface {
 public:
  TurnedSurface(const mesh::MeridianMesh& mesh, int highest_harmonic);

  const modes::ModeSurface& surface() const { return surface_; }

  /// Displacements x y z of every node, one after the other.
  /// @param unknowns  of a harmonic, A B W of each node of the section
  /// @param turned    the second mode of the pair: the first turned by a quarter of a wave
  Eigen::VectorXd evaluate(int n, const Eigen::Ref<const Eigen::VectorXd>& unknowns,
                           bool turned) const;

 private:
  /// A ring of nodes at one place of the outline.
  struct Ring {
    std::int32_t edge;        ///< of the mesh's boundary
    Eigen::VectorXd weights;  ///< of the edge's nodes
    int around;               ///< nodes in a full turn; 1 on the axis
    std::int32_t first;       ///< number of the first one
  };

  std::size_t add_ring(std::int32_t edge, double t, int around);
  Vec2 at(const Ring& ring) const;
  void add_band(const std::array<std::size_t, 4>& rings, int sectors);
  void add_fan(const std::array<std::size_t, 4>& rings, int sectors, bool apex_first);

  const mesh::MeridianMesh& mesh_;
  std::vector<Ring> rings_;
  std::map<int, std::vector<Vec2>> circles_;  ///< directions of the nodes of rings, by their number
  modes::ModeSurface surface_;
};

}  // namespace carillon::solvers::axisymmetric
