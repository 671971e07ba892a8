#include "synth/motion/convex_hull.hpp"

#include <LinearMath/btConvexHullComputer.h>

#include <utility>

#include "solvers/assembly/partition.hpp"

namespace carillon::synth::motion {

using solvers::mesh::SurfaceMesh;

SurfaceMesh convex_hull(const std::vector<Vec3>& points) {
  SurfaceMesh hull;
  if (points.size() < 4) return hull;
  // The computer works with integers over the box: about its middle, it loses nothing.
  const solvers::mesh::Box box = solvers::mesh::bounding_box(points);
  const Vec3 middle = 0.5 * (box.low + box.high);
  const double scale = box.longest_side();
  if (!(scale > 0)) return hull;
  std::vector<double> flat;
  for (const Vec3& p : points) {
    for (Eigen::Index k = 0; k < 3; ++k) flat.push_back((p[k] - middle[k]) / scale);
  }
  btConvexHullComputer computer;
  computer.compute(flat.data(), 3 * static_cast<int>(sizeof(double)),
                   static_cast<int>(points.size()), 0, 0);
  for (int k = 0; k < computer.vertices.size(); ++k) {
    const btVector3& v = computer.vertices[k];
    hull.vertices.push_back(middle + scale * Vec3(v.x(), v.y(), v.z()));
  }
  for (int f = 0; f < computer.faces.size(); ++f) {
    const btConvexHullComputer::Edge* first = &computer.edges[computer.faces[f]];
    const std::int32_t a = first->getSourceVertex();
    const btConvexHullComputer::Edge* edge = first->getNextEdgeOfFace();
    for (; edge->getTargetVertex() != a; edge = edge->getNextEdgeOfFace()) {
      hull.triangles.push_back({a, edge->getSourceVertex(), edge->getTargetVertex()});
    }
  }
  if (solvers::mesh::signed_volume(hull) < 0) {  // outward
    for (solvers::mesh::Triangle& t : hull.triangles) std::swap(t[1], t[2]);
  }
  return hull;
}

namespace {

/// Nodes of each part's elements, each once.
std::vector<std::vector<Vec3>> nodes_of_parts(const solvers::mesh::TetMesh& mesh,
                                              const std::vector<std::int32_t>& part, int parts) {
  std::vector<std::vector<Vec3>> nodes(static_cast<std::size_t>(parts));
  std::vector<std::vector<bool>> taken(static_cast<std::size_t>(parts),
                                       std::vector<bool>(mesh.nodes.size(), false));
  for (std::size_t e = 0; e < mesh.element_count(); ++e) {
    const auto p = static_cast<std::size_t>(part[e]);
    for (const std::int32_t n : mesh.element(e)) {
      const auto node = static_cast<std::size_t>(n);
      if (taken[p][node]) continue;
      taken[p][node] = true;
      nodes[p].push_back(mesh.nodes[node]);
    }
  }
  return nodes;
}

}  // namespace

std::vector<std::vector<Vec3>> convex_pieces(const solvers::mesh::TetMesh& mesh, double excess,
                                             int maximum) {
  const double volume = solvers::mesh::measure_quality(mesh).volume;
  for (int parts = 1;; parts *= 2) {
    std::vector<std::vector<Vec3>> pieces;
    double sum = 0;
    for (const auto& nodes :
         nodes_of_parts(mesh, solvers::assembly::element_parts(mesh, parts), parts)) {
      SurfaceMesh hull = convex_hull(nodes);
      const double own = solvers::mesh::signed_volume(hull);
      sum += own;
      if (own > 0) pieces.push_back(std::move(hull.vertices));
    }
    if (sum <= (1 + excess) * volume || 2 * parts > maximum) return pieces;
  }
}

}  // namespace carillon::synth::motion
