#include "synth/motion/convex_hull.hpp"

#include <LinearMath/btConvexHullComputer.h>

#include <Eigen/Geometry>
#include <utility>

#include "solvers/assembly/partition.hpp"

namespace carillon::synth::motion {

ConvexHull convex_hull(const std::vector<Vec3>& points) {
  ConvexHull hull;
  if (points.size() < 4) return hull;
  // The computer works with integers over the box: about its middle, it loses nothing.
  Vec3 low = points.front(), high = low;
  for (const Vec3& p : points) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  const Vec3 middle = 0.5 * (low + high);
  const double scale = (high - low).maxCoeff();
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
    hull.points.push_back(middle + scale * Vec3(v.x(), v.y(), v.z()));
  }
  for (int f = 0; f < computer.faces.size(); ++f) {
    const btConvexHullComputer::Edge* first = &computer.edges[computer.faces[f]];
    const std::int32_t a = first->getSourceVertex();
    const btConvexHullComputer::Edge* edge = first->getNextEdgeOfFace();
    for (; edge->getTargetVertex() != a; edge = edge->getNextEdgeOfFace()) {
      const std::int32_t b = edge->getSourceVertex(), c = edge->getTargetVertex();
      hull.triangles.insert(hull.triangles.end(), {a, b, c});
      const auto at = [&](std::int32_t n) {
        return hull.points[static_cast<std::size_t>(n)] - middle;
      };
      hull.volume += at(a).cross(at(b)).dot(at(c)) / 6;
    }
  }
  if (hull.volume < 0) {  // outward
    for (std::size_t t = 0; t < hull.triangles.size(); t += 3) {
      std::swap(hull.triangles[t + 1], hull.triangles[t + 2]);
    }
    hull.volume = -hull.volume;
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
                                             int most) {
  const double volume = solvers::mesh::measure_quality(mesh).volume;
  for (int parts = 1;; parts *= 2) {
    std::vector<std::vector<Vec3>> pieces;
    double sum = 0;
    for (const auto& nodes :
         nodes_of_parts(mesh, solvers::assembly::element_parts(mesh, parts), parts)) {
      ConvexHull hull = convex_hull(nodes);
      sum += hull.volume;
      if (hull.volume > 0) pieces.push_back(std::move(hull.points));
    }
    if (sum <= (1 + excess) * volume || 2 * parts > most) return pieces;
  }
}

}  // namespace carillon::synth::motion
