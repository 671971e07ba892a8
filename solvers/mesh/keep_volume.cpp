#include "solvers/mesh/keep_volume.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include "solvers/mesh/detail/folded_elements.hpp"
#include "solvers/mesh/face_sampler.hpp"
#include "solvers/mesh/raise_order.hpp"

namespace carillon::solvers::mesh {
namespace {

/// A face nowhere farther from the truth than this multiple of its size is as it should be.
constexpr double on_surface = 1e-6;
/// A gap larger than this multiple of a face's size belongs to another part of the surface.
constexpr double largest_gap = 0.3;

enum class Gap { with_sign, size };

/// What the faces around a corner of the boundary ask of it.
struct Corner {
  Vec3 moved = Vec3::Constant(0);  ///< by the faces that are off the surface, weighted
  double weight = 0;               ///< [m^2]
  std::vector<Vec3> planes;        ///< orthonormal: ways that leave a face which is right

  void keep_in_plane(Vec3 normal) {
    for (const Vec3& n : planes) normal -= n.dot(normal) * n;
    if (normal.norm() > 1e-3) planes.push_back(normal.normalized());
  }
  Vec3 move() const {
    if (!(weight > 0) || planes.size() == 3) return Vec3::Zero();
    Vec3 out = moved / weight;
    for (const Vec3& n : planes) out -= n.dot(out) * n;
    return out;
  }
};

/// Moves of the mesh's nodes, for those that are corners of the boundary: the gap between the
/// curved faces around and the true surface, averaged with the faces' barycentrics as weights.
/// Together they sweep the volume that lies between.
std::vector<Vec3> gaps_at_corners(const TetMesh& mesh, const SurfaceProjection& truth, Gap kind) {
  const FaceSampler sampler(mesh.order, mesh.order + 1);
  const auto per_face = static_cast<std::size_t>(elements::nodes_per_face(mesh.order));
  std::vector<Corner> corners(mesh.nodes.size());
  for (std::size_t f = 0; f < mesh.face_count(); ++f) {
    const auto samples = sampler.of(mesh, f);
    double size = 0;
    for (const FaceSample& sample : samples) size += sample.area.norm();
    const double edge = std::sqrt(2 * size);
    Vec3 normal = Vec3::Zero();
    std::array<Corner, 3> asked;
    double widest = 0;
    for (const FaceSample& sample : samples) {
      const Vec3 outward = sample.area.normalized();
      const double gap = (truth.to_surface(sample.point, outward) - sample.point).dot(outward);
      if (!(std::abs(gap) <= largest_gap * edge)) continue;
      widest = std::max(widest, std::abs(gap));
      normal += sample.area;
      for (std::size_t c = 0; c < 3; ++c) {
        const double share = sample.barycentric[static_cast<Eigen::Index>(c)];
        asked[c].moved += share * (kind == Gap::size ? std::abs(gap) : gap) * sample.area;
        asked[c].weight += share * sample.area.norm();
      }
    }
    for (std::size_t c = 0; c < 3; ++c) {
      Corner& corner = corners[static_cast<std::size_t>(mesh.faces[f * per_face + c])];
      if (widest <= on_surface * edge) {
        corner.keep_in_plane(normal.normalized());
      } else {
        corner.moved += asked[c].moved;
        corner.weight += asked[c].weight;
      }
    }
  }
  std::vector<Vec3> moves;
  moves.reserve(corners.size());
  for (const Corner& corner : corners) moves.push_back(corner.move());
  return moves;
}

/// Moves of all nodes: those of an element's corners, linear between them.
std::vector<Vec3> between_corners(const TetMesh& mesh, const std::vector<Vec3>& corners) {
  std::vector<Vec3> moves(mesh.nodes.size(), Vec3::Zero());
  const auto& lattice = elements::tetrahedron_lattice(mesh.order);
  for (std::size_t e = 0; e < mesh.element_count(); ++e) {
    const auto element = mesh.element(e);
    for (std::size_t n = 0; n < lattice.size(); ++n) {
      Vec3& move = moves[static_cast<std::size_t>(element[n])];
      move.setZero();
      for (std::size_t c = 0; c < 4; ++c)
        move += static_cast<double>(lattice[n][c]) / mesh.order *
                corners[static_cast<std::size_t>(element[c])];
    }
  }
  return moves;
}

/// Volume within the curved boundary [m^3], by Gauss' theorem: what the elements fill, at the cost
/// of the faces alone.
double enclosed_volume(const TetMesh& mesh) {
  const FaceSampler sampler(mesh.order, 3 * mesh.order / 2);  // degree 3 order - 2
  const Vec3 origin = mesh.nodes[static_cast<std::size_t>(mesh.faces.front())];
  double sum = 0;
  for (std::size_t f = 0; f < mesh.face_count(); ++f)
    for (const FaceSample& sample : sampler.of(mesh, f))
      sum += (sample.point - origin).dot(sample.area) / 3;
  return sum;
}

/// Moves the nodes of `moved`, a copy of the mesh, by the multiple of `moves` that gives it a
/// volume: Newton's method with secants, as the volume is a cubic of it. False when none below
/// `limit` does.
bool move_to_volume(const TetMesh& mesh, const std::vector<Vec3>& moves, double wanted,
                    TetMesh& moved) {
  constexpr double limit = 5, close = 1e-10;
  constexpr int steps = 12;
  double before = 0, excess_before = enclosed_volume(mesh) - wanted;
  double factor = 1;
  for (int step = 0; step < steps && std::abs(factor) <= limit; ++step) {
    for (std::size_t n = 0; n < moves.size(); ++n)
      moved.nodes[n] = mesh.nodes[n] + factor * moves[n];
    const double excess = enclosed_volume(moved) - wanted;
    if (std::abs(excess) <= close * wanted) return true;
    const double next = factor - excess * (factor - before) / (excess - excess_before);
    before = factor;
    excess_before = excess;
    factor = next;
  }
  return false;
}

/// Moves corners of the mesh, and the other nodes along, by a multiple of `corners`; those of what
/// would fold stay where they are.
/// @return whether it has the volume
bool give_volume(TetMesh& mesh, std::vector<Vec3> corners, double wanted) {
  TetMesh moved = mesh;
  for (;;) {
    if (!move_to_volume(mesh, between_corners(mesh, corners), wanted, moved)) return false;
    const auto folded = folded_elements(moved);
    if (folded.empty()) {
      mesh.nodes = std::move(moved.nodes);
      return true;
    }
    bool changed = false;
    for (const std::size_t e : folded)
      for (const std::int32_t corner : mesh.element(e).first(4)) {
        Vec3& move = corners[static_cast<std::size_t>(corner)];
        changed = changed || !move.isZero(0);
        move.setZero();
      }
    if (!changed) return false;
  }
}

void give_volume(TetMesh& mesh, double wanted, const SurfaceProjection& truth) {
  constexpr double close = 1e-9;
  if (std::abs(enclosed_volume(mesh) - wanted) <= close * wanted) return;
  // Gaps to both sides may cancel and leave nothing to go by but their sizes.
  if (!give_volume(mesh, gaps_at_corners(mesh, truth, Gap::with_sign), wanted))
    give_volume(mesh, gaps_at_corners(mesh, truth, Gap::size), wanted);
}

}  // namespace

double keep_volume(TetMesh& mesh, double wanted, const SurfaceProjection& truth) {
  const double before = enclosed_volume(mesh);
  if (!mesh.finer_nodes.empty()) {
    TetMesh finer = next_order(mesh);
    give_volume(finer, wanted, truth);
    // Where nodes lack something, all of them tell how far they are from the surface now.
    for (std::size_t n = 0; n < mesh.finer_gaps.size(); ++n)
      mesh.finer_gaps[n] -= finer.nodes[n] - mesh.finer_nodes[n];
    mesh.finer_nodes = std::move(finer.nodes);
  }
  give_volume(mesh, wanted, truth);
  return (enclosed_volume(mesh) - before) / wanted;
}

}  // namespace carillon::solvers::mesh
