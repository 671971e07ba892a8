#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "solvers/axisymmetric/detail/harmonic_forms.hpp"
#include "solvers/modes/modes.hpp"

namespace carillon::solvers::axisymmetric {

/// What a TurnedSurface should come to.
struct TurnedSize {
  double rings = 0, nodes = 0, faces = 0;
};
TurnedSize expected_surface(const mesh::MeridianMesh& mesh, double highest_harmonic);

/// The surface that a section's outline makes when turned, in curved triangles of order 3, and the
/// amplitudes of harmonics on its rings. A full turn has at least nine nodes to the wave of the
/// highest harmonic, and triangles about as long as wide.
class TurnedSurface {
 public:
  TurnedSurface(const mesh::MeridianMesh& mesh, int highest_harmonic);

  const modes::ModeSurface& surface() const { return surface_; }

  /// Of its nodes: modes::ModeShapes has shapes as amplitudes on these.
  std::vector<modes::NodeRing> rings() const;

  /// Amplitudes u v w of every ring, one after the other.
  /// @param unknowns  of a harmonic, A B W of each node of the section
  Eigen::VectorXd amplitudes(const Eigen::Ref<const Eigen::VectorXd>& unknowns) const;

 private:
  /// A ring of nodes at one place of the outline.
  struct Ring {
    std::int32_t edge;        ///< of the mesh's boundary
    Eigen::VectorXd weights;  ///< of the edge's nodes
    modes::NodeRing nodes;
  };

  std::size_t add_ring(std::int32_t edge, double t, int around);
  Vec2 at(const Ring& ring) const;
  void add_band(const std::array<std::size_t, 4>& rings, int sectors);
  void add_fan(const std::array<std::size_t, 4>& rings, int sectors, bool apex_first);

  const mesh::MeridianMesh& mesh_;
  std::vector<Ring> rings_;
  modes::ModeSurface surface_;
};

}  // namespace carillon::solvers::axisymmetric
