#include "synth/surface/outer_triangles.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>

#include "core/error.hpp"
#include "solvers/elements/lagrange.hpp"
#include "synth/surface/outer_surface.hpp"

namespace carillon::synth::surface {

namespace {

constexpr int max_cuts = 12;

/// Vertices of a face cut into cuts^2, by their places (i, j): i / cuts and j / cuts are the second
/// and third barycentric coordinate.
struct CutFace {
  int cuts;
  std::vector<std::array<int, 2>> places;
  std::vector<Eigen::VectorXd> values;  ///< shape functions at each place
  std::vector<std::array<int, 3>> triangles;
};

CutFace cut_face(int order, int cuts) {
  CutFace face{cuts, {}, {}, {}};
  std::map<std::array<int, 2>, int> index;
  for (int i = 0; i <= cuts; ++i) {
    for (int j = 0; i + j <= cuts; ++j) {
      index[{i, j}] = static_cast<int>(face.places.size());
      face.places.push_back({i, j});
      face.values.push_back(solvers::elements::triangle_shape_functions(
          order, Eigen::Vector3d(cuts - i - j, i, j) / cuts, nullptr));
    }
  }
  for (int i = 0; i < cuts; ++i) {
    for (int j = 0; i + j < cuts; ++j) {
      face.triangles.push_back({index[{i, j}], index[{i + 1, j}], index[{i, j + 1}]});
      if (i + j + 2 <= cuts) {
        face.triangles.push_back({index[{i + 1, j}], index[{i + 1, j + 1}], index[{i, j + 1}]});
      }
    }
  }
  return face;
}

/// A vertex's name, the same from every face that holds it: a corner, a place on an edge, or a
/// place inside one face.
using VertexKey = std::array<std::int64_t, 4>;

VertexKey vertex_key(std::span<const std::int32_t> nodes, std::int64_t face,
                     const std::array<int, 2>& place, int cuts) {
  const std::array<int, 3> fraction = {cuts - place[0] - place[1], place[0], place[1]};
  for (std::size_t c = 0; c < 3; ++c) {
    if (fraction[c] == cuts) return {0, nodes[c], 0, 0};
  }
  for (std::size_t c = 0; c < 3; ++c) {
    if (fraction[c] != 0) continue;
    const std::size_t a = (c + 1) % 3, b = (c + 2) % 3;
    return nodes[a] < nodes[b] ? VertexKey{1, nodes[a], nodes[b], fraction[a]}
                               : VertexKey{1, nodes[b], nodes[a], fraction[b]};
  }
  return {2, face, place[0], place[1]};
}

void find_neighbours(OuterTriangles& cut) {
  std::map<std::array<int, 2>, std::array<int, 2>> open;  // edge -> triangle, its side
  cut.neighbours.assign(cut.size(), {-1, -1, -1});
  for (std::size_t t = 0; t < cut.size(); ++t) {
    for (std::size_t side = 0; side < 3; ++side) {
      const int a = cut.mesh.triangles[t][side], b = cut.mesh.triangles[t][(side + 1) % 3];
      const auto other = open.find({b, a});
      if (other == open.end()) {
        open[{a, b}] = {static_cast<int>(t), static_cast<int>(side)};
        continue;
      }
      const auto [neighbour, its_side] = other->second;
      cut.neighbours[t][side] = neighbour;
      cut.neighbours[static_cast<std::size_t>(neighbour)][static_cast<std::size_t>(its_side)] =
          static_cast<int>(t);
      open.erase(other);
    }
  }
}

}  // namespace

OuterTriangles outer_triangles(const solvers::modes::ModeSurface& surface, std::size_t count) {
  const std::vector<bool> outer = outer_faces(surface);
  const auto faces = static_cast<std::size_t>(std::count(outer.begin(), outer.end(), true));
  if (faces == 0) {
    throw core::InputError("the object has no outer surface: no faces, or all of them look inward");
  }
  int cuts = 1;
  while (cuts < max_cuts && faces * static_cast<std::size_t>(cuts * cuts) < count) ++cuts;
  const CutFace pattern = cut_face(surface.order, cuts);

  OuterTriangles cut;
  std::map<VertexKey, int> index;
  std::vector<Eigen::Triplet<double>> weights;
  std::vector<int> local(pattern.places.size());
  for (std::size_t face = 0; face < outer.size(); ++face) {
    if (!outer[face]) continue;
    const auto nodes = face_nodes(surface, static_cast<std::int32_t>(face));
    for (std::size_t v = 0; v < pattern.places.size(); ++v) {
      const auto [found, added] =
          index.emplace(vertex_key(nodes, static_cast<std::int64_t>(face), pattern.places[v], cuts),
                        static_cast<int>(cut.mesh.vertices.size()));
      local[v] = found->second;
      if (!added) continue;
      Vec3 position = Vec3::Zero();
      for (std::size_t a = 0; a < nodes.size(); ++a) {
        position += pattern.values[v][static_cast<Eigen::Index>(a)] *
                    surface.nodes[static_cast<std::size_t>(nodes[a])];
      }
      if (!position.allFinite())
        throw core::InputError("the surface has a node that is not finite");
      cut.mesh.vertices.push_back(position);
    }
    for (const std::array<int, 3>& triangle : pattern.triangles) {
      const auto at = [&](std::size_t c) { return local[static_cast<std::size_t>(triangle[c])]; };
      const auto p = [&](std::size_t c) {
        return cut.mesh.vertices[static_cast<std::size_t>(at(c))];
      };
      const Vec3 area = (p(1) - p(0)).cross(p(2) - p(0)) / 2;
      const auto column = static_cast<int>(cut.size());
      cut.mesh.triangles.push_back({at(0), at(1), at(2)});
      cut.centres.push_back((p(0) + p(1) + p(2)) / 3);
      cut.area_vectors.push_back(area);
      cut.areas.push_back(area.norm());
      cut.area += area.norm();
      for (std::size_t a = 0; a < nodes.size(); ++a) {
        double mean = 0;
        for (const int v : triangle) {
          mean += pattern.values[static_cast<std::size_t>(v)][static_cast<Eigen::Index>(a)] / 3;
        }
        if (mean == 0) continue;
        for (int axis = 0; axis < 3; ++axis) {
          weights.emplace_back(3 * nodes[a] + axis, column, mean * area[axis]);
        }
      }
    }
  }
  if (!(cut.area > 0)) throw core::InputError("the object's outer surface has no area");
  cut.flux_weights.resize(3 * static_cast<Eigen::Index>(surface.nodes.size()),
                          static_cast<Eigen::Index>(cut.size()));
  cut.flux_weights.setFromTriplets(weights.begin(), weights.end());
  find_neighbours(cut);
  return cut;
}

}  // namespace carillon::synth::surface
