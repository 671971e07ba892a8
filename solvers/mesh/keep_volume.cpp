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

/// The mesh with its corners moved by a multiple of `moves`, and the other nodes of their elements
/// linearly along.
TetMesh moved_by(const TetMesh& mesh, const std::vector<Vec3>& moves, double factor) {
  TetMesh moved = mesh;
  const auto& lattice = elements::tetrahedron_lattice(mesh.order);
  for (std::size_t e = 0; e < mesh.element_count(); ++e) {
    const auto element = mesh.element(e);
    for (std::size_t n = 0; n < lattice.size(); ++n) {
      Vec3 move = Vec3::Zero();
      for (std::size_t c = 0; c < 4; ++c)
        move += static_cast<double>(lattice[n][c]) / mesh.order *
                moves[static_cast<std::size_t>(element[c])];
      const auto node = static_cast<std::size_t>(element[n]);
      moved.nodes[node] = mesh.nodes[node] + factor * move;
    }
  }
  return moved;
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

/// The multiple of `moves` that gives a mesh its volume: Newton's method with secants, as the
/// volume is a cubic of it. Not a number when none below `limit` does.
double factor_for(const TetMesh& mesh, const std::vector<Vec3>& moves, double wanted) {
  constexpr double limit = 5, close = 1e-12;
  constexpr int steps = 12;
  double before = 0, excess_before = enclosed_volume(mesh) - wanted;
  double factor = 1;
  for (int step = 0; step < steps; ++step) {
    const double excess = enclosed_volume(moved_by(mesh, moves, factor)) - wanted;
    if (std::abs(excess) <= close * wanted) return factor;
    const double next = factor - excess * (factor - before) / (excess - excess_before);
    before = factor;
    excess_before = excess;
    factor = next;
    if (!(std::abs(factor) <= limit)) break;
  }
  return std::nan("");
}

/// Moves the mesh's nodes by a multiple of `moves`; whether one was found.
bool move_to_volume(TetMesh& mesh, std::vector<Vec3> moves, double wanted) {
  for (;;) {
    const double factor = factor_for(mesh, moves, wanted);
    if (std::isnan(factor)) return false;
    TetMesh moved = moved_by(mesh, moves, factor);
    const auto folded = folded_elements(moved);
    if (folded.empty()) {
      mesh.nodes = std::move(moved.nodes);
      return true;
    }
    // The corners of what would fold stay where they are.
    bool changed = false;
    for (const std::size_t e : folded)
      for (const std::int32_t corner : mesh.element(e).first(4)) {
        Vec3& move = moves[static_cast<std::size_t>(corner)];
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
  if (!move_to_volume(mesh, gaps_at_corners(mesh, truth, Gap::with_sign), wanted))
    move_to_volume(mesh, gaps_at_corners(mesh, truth, Gap::size), wanted);
}

}  // namespace

void keep_volume(TetMesh& mesh, double wanted, const SurfaceProjection& truth) {
  if (!mesh.finer_nodes.empty()) {
    TetMesh finer = next_order(mesh);
    give_volume(finer, wanted, truth);
    // Where nodes lack something, all of them tell how far they are from the surface now.
    for (std::size_t n = 0; n < mesh.finer_gaps.size(); ++n)
      mesh.finer_gaps[n] -= finer.nodes[n] - mesh.finer_nodes[n];
    mesh.finer_nodes = std::move(finer.nodes);
  }
  give_volume(mesh, wanted, truth);
}

}  // namespace carillon::solvers::mesh
