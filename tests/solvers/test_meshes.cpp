#include "test_meshes.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <map>
#include <stdexcept>
#include <utility>
#include <vector>

#include "solvers/mesh/raise_order.hpp"

namespace carillon::test {

using solvers::elements::tetrahedron_lattice;

TetMesh with_order(const TetMesh& linear, int order) {
  TetMesh mesh;
  mesh.order = order;
  mesh.nodes = linear.nodes;
  mesh.regions = linear.regions;
  mesh.region_names = linear.region_names;
  const auto& lattice = tetrahedron_lattice(order);
  using Key = std::vector<std::pair<std::int32_t, int>>;  // corner and its fraction of the order
  std::map<Key, std::int32_t> known;
  for (std::size_t e = 0; e < linear.element_count(); ++e) {
    const auto corners = linear.element(e);
    for (const auto& tuple : lattice) {
      Key key;
      Vec3 position = Vec3::Zero();
      for (std::size_t v = 0; v < 4; ++v) {
        if (tuple[v] == 0) continue;
        key.emplace_back(corners[v], tuple[v]);
        position += tuple[v] * linear.nodes[static_cast<std::size_t>(corners[v])] / order;
      }
      if (key.size() == 1) {
        mesh.elements.push_back(key[0].first);
        continue;
      }
      std::sort(key.begin(), key.end());
      const auto [entry, is_new] =
          known.try_emplace(key, static_cast<std::int32_t>(mesh.nodes.size()));
      if (is_new) mesh.nodes.push_back(position);
      mesh.elements.push_back(entry->second);
    }
  }
  mesh.faces = solvers::mesh::boundary_faces(mesh);
  return mesh;
}

TetMesh box_mesh(const Vec3& sides, const std::array<int, 3>& cells, int order,
                 const std::function<int(const Vec3&)>& region) {
  TetMesh mesh;
  const auto [nx, ny, nz] = cells;
  const auto node = [ny_ = ny, nz_ = nz](int i, int j, int k) {
    return static_cast<std::int32_t>((i * (ny_ + 1) + j) * (nz_ + 1) + k);
  };
  const Vec3 step(sides[0] / nx, sides[1] / ny, sides[2] / nz);
  for (int i = 0; i <= nx; ++i)
    for (int j = 0; j <= ny; ++j)
      for (int k = 0; k <= nz; ++k) mesh.nodes.push_back(step.cwiseProduct(Vec3(i, j, k)));
  int regions = 1;
  for (int i = 0; i < nx; ++i)
    for (int j = 0; j < ny; ++j)
      for (int k = 0; k < nz; ++k) {
        const int r = region ? region(step.cwiseProduct(Vec3(i + 0.5, j + 0.5, k + 0.5))) : 0;
        regions = std::max(regions, r + 1);
        // Kuhn's six tetrahedra: one for each order of walking the three axes.
        std::array<int, 3> axes = {0, 1, 2};
        do {
          std::array<int, 3> at = {i, j, k};
          std::array<std::int32_t, 4> tet;
          tet[0] = node(at[0], at[1], at[2]);
          for (std::size_t s = 0; s < 3; ++s) {
            ++at[static_cast<std::size_t>(axes[s])];
            tet[s + 1] = node(at[0], at[1], at[2]);
          }
          const bool odd = (axes[0] > axes[1]) ^ (axes[0] > axes[2]) ^ (axes[1] > axes[2]);
          if (odd) std::swap(tet[2], tet[3]);
          mesh.elements.insert(mesh.elements.end(), tet.begin(), tet.end());
          mesh.regions.push_back(r);
        } while (std::next_permutation(axes.begin(), axes.end()));
      }
  for (int r = 0; r < regions; ++r)
    mesh.region_names.push_back(regions == 1 ? "body" : "part" + std::to_string(r));
  return with_order(mesh, order);
}

namespace {

/// Corners of the icosahedron on the unit sphere and its faces, counter-clockwise from outside.
struct Icosahedron {
  std::vector<Vec3> corners;
  std::vector<std::array<std::size_t, 3>> faces;
};

Icosahedron icosahedron() {
  Icosahedron body;
  const double golden = (1 + std::sqrt(5.0)) / 2;
  for (std::size_t axis = 0; axis < 3; ++axis)
    for (const double a : {-1.0, 1.0})
      for (const double b : {-golden, golden}) {
        Vec3 corner = Vec3::Zero();
        corner[static_cast<int>(axis)] = a;
        corner[static_cast<int>((axis + 1) % 3)] = b;
        body.corners.push_back(corner.normalized());
      }
  const double edge = 2 / std::sqrt(1 + golden * golden);
  const auto joined = [&](std::size_t i, std::size_t j) {
    return (body.corners[i] - body.corners[j]).norm() < 1.01 * edge;
  };
  for (std::size_t i = 0; i < 12; ++i)
    for (std::size_t j = i + 1; j < 12; ++j)
      for (std::size_t k = j + 1; k < 12; ++k) {
        if (!joined(i, j) || !joined(i, k) || !joined(j, k)) continue;
        const auto& c = body.corners;
        const bool outward = c[i].dot(c[j].cross(c[k])) > 0;
        body.faces.push_back(outward ? std::array{i, j, k} : std::array{i, k, j});
      }
  return body;
}

/// 1 on the icosahedron, 0 in the middle, linear on every ray.
double gauge(const Icosahedron& body, const Vec3& p) {
  double value = 0;
  for (const auto& face : body.faces) {
    const Vec3 outward =
        (body.corners[face[0]] + body.corners[face[1]] + body.corners[face[2]]) / 3;
    value = std::max(value, outward.dot(p) / outward.squaredNorm());
  }
  return value;
}

}  // namespace

TetMesh ball_mesh(double radius, int cells, int order) {
  const auto body = icosahedron();
  const auto cube = box_mesh(Vec3::Constant(cells), {cells, cells, cells}, 1);
  TetMesh mesh;
  mesh.region_names = {"body"};
  // Cone from the centre over each face, cut like the simplex cells >= x >= y >= z >= 0 of the
  // cube; its barycentric coordinates times cells are (cells - x, x - y, y - z, z).
  std::map<std::vector<std::pair<std::size_t, int>>, std::int32_t> known;
  for (const auto& face : body.faces) {
    for (std::size_t e = 0; e < cube.element_count(); ++e) {
      Vec3 middle = Vec3::Zero();
      for (const auto n : cube.element(e)) middle += cube.nodes[static_cast<std::size_t>(n)] / 4;
      if (!(middle[0] > middle[1] && middle[1] > middle[2])) continue;
      for (const auto n : cube.element(e)) {
        const Eigen::Vector3i at =
            cube.nodes[static_cast<std::size_t>(n)].array().round().cast<int>();
        const std::array<int, 3> fraction = {at[0] - at[1], at[1] - at[2], at[2]};
        std::vector<std::pair<std::size_t, int>> key;
        Vec3 position = Vec3::Zero();
        for (std::size_t k = 0; k < 3; ++k) {
          if (fraction[k] == 0) continue;
          key.emplace_back(face[k], fraction[k]);
          position += fraction[k] * body.corners[face[k]] / cells;
        }
        std::sort(key.begin(), key.end());
        const auto [entry, is_new] =
            known.try_emplace(key, static_cast<std::int32_t>(mesh.nodes.size()));
        if (is_new) mesh.nodes.push_back(position);
        mesh.elements.push_back(entry->second);
      }
      mesh.regions.push_back(0);
    }
  }
  const auto straight = with_order(mesh, order);
  return moved(straight, [&](const Vec3& p) -> Vec3 {
    const double g = gauge(body, p);
    if (g < 1e-12) return Vec3::Zero();
    return radius * ((1 - g) * p + g * g * p.normalized());
  });
}

TetMesh shell_mesh(double outer, double inner, int faces, int layers, int order) {
  const auto body = icosahedron();
  // The surface in triangles, corners shared by their place in faces and on edges.
  std::map<std::vector<std::pair<std::size_t, int>>, std::int32_t> known;
  std::vector<Vec3> points;
  std::vector<std::array<std::int32_t, 3>> triangles;
  for (const auto& face : body.faces) {
    const auto vertex = [&](int i, int j) {
      const std::array<int, 3> fraction = {faces - i - j, i, j};
      std::vector<std::pair<std::size_t, int>> key;
      Vec3 position = Vec3::Zero();
      for (std::size_t k = 0; k < 3; ++k) {
        if (fraction[k] == 0) continue;
        key.emplace_back(face[k], fraction[k]);
        position += fraction[k] * body.corners[face[k]] / faces;
      }
      std::sort(key.begin(), key.end());
      const auto [entry, is_new] = known.try_emplace(key, static_cast<std::int32_t>(points.size()));
      if (is_new) points.push_back(position);
      return entry->second;
    };
    for (int i = 0; i < faces; ++i) {
      for (int j = 0; i + j < faces; ++j) {
        triangles.push_back({vertex(i, j), vertex(i + 1, j), vertex(i, j + 1)});
        if (i + j + 2 > faces) continue;
        triangles.push_back({vertex(i + 1, j), vertex(i + 1, j + 1), vertex(i, j + 1)});
      }
    }
  }
  TetMesh mesh;
  mesh.region_names = {"body"};
  const double hollow = inner / outer;
  const auto level = static_cast<std::int32_t>(points.size());
  for (int k = 0; k <= layers; ++k) {
    const double g = hollow + (1 - hollow) * k / layers;
    for (const auto& p : points) mesh.nodes.push_back(g * p);
  }
  for (int k = 0; k < layers; ++k) {
    for (auto corners : triangles) {
      // Diagonals rise from the lower number, so that neighbours agree on them.
      std::sort(corners.begin(), corners.end());
      const auto at = [&](std::size_t v, int up) { return corners[v] + (k + up) * level; };
      const std::array<std::int32_t, 4> cut[] = {{at(0, 0), at(1, 0), at(2, 0), at(2, 1)},
                                                 {at(0, 0), at(1, 0), at(1, 1), at(2, 1)},
                                                 {at(0, 0), at(0, 1), at(1, 1), at(2, 1)}};
      for (auto tet : cut) {
        const auto x = [&](std::size_t v) { return mesh.nodes[static_cast<std::size_t>(tet[v])]; };
        if ((x(1) - x(0)).cross(x(2) - x(0)).dot(x(3) - x(0)) < 0) std::swap(tet[2], tet[3]);
        mesh.elements.insert(mesh.elements.end(), tet.begin(), tet.end());
        mesh.regions.push_back(0);
      }
    }
  }
  return moved(with_order(mesh, order),
               [&](const Vec3& p) -> Vec3 { return outer * gauge(body, p) * p.normalized(); });
}

TetMesh with_finer_nodes(TetMesh mesh, const TetMesh& finer) {
  const auto numbering = solvers::mesh::numbering_at(mesh, finer.order);
  mesh.finer_nodes.resize(numbering.first_use.size());
  for (std::size_t k = 0; k < finer.elements.size(); ++k) {
    mesh.finer_nodes[static_cast<std::size_t>(numbering.elements[k])] =
        finer.nodes[static_cast<std::size_t>(finer.elements[k])];
  }
  return mesh;
}

TetMesh joined(const TetMesh& first, const TetMesh& second) {
  if (first.order != second.order) throw std::invalid_argument("orders differ");
  TetMesh mesh = first;
  const auto nodes = static_cast<std::int32_t>(first.nodes.size());
  const auto regions = static_cast<std::int32_t>(first.region_names.size());
  mesh.nodes.insert(mesh.nodes.end(), second.nodes.begin(), second.nodes.end());
  for (const auto n : second.elements) mesh.elements.push_back(n + nodes);
  for (const auto r : second.regions) mesh.regions.push_back(r + regions);
  for (const auto n : second.faces) mesh.faces.push_back(n + nodes);
  for (const auto& name : second.region_names) mesh.region_names.push_back("second " + name);
  return mesh;
}

TetMesh moved(const TetMesh& mesh, const std::function<Vec3(const Vec3&)>& map) {
  TetMesh out = mesh;
  for (auto& x : out.nodes) x = map(x);
  const auto corner = [&out](std::size_t v) {
    return out.nodes[static_cast<std::size_t>(out.elements[v])];
  };
  const double volume =
      (corner(1) - corner(0)).cross(corner(2) - corner(0)).dot(corner(3) - corner(0));
  if (volume < 0) {
    // Swapping the last two corners turns every element over.
    const auto& lattice = tetrahedron_lattice(mesh.order);
    std::vector<std::size_t> turned;
    for (auto tuple : lattice) {
      std::swap(tuple[2], tuple[3]);
      turned.push_back(static_cast<std::size_t>(std::find(lattice.begin(), lattice.end(), tuple) -
                                                lattice.begin()));
    }
    for (std::size_t e = 0; e < mesh.element_count(); ++e) {
      const auto element = mesh.element(e);
      for (std::size_t n = 0; n < turned.size(); ++n)
        out.elements[e * turned.size() + n] = element[turned[n]];
    }
  }
  out.faces = solvers::mesh::boundary_faces(out);
  return out;
}

TetMesh read_tetrahedra(const std::string& path) {
  std::ifstream file(path);
  std::size_t nodes = 0, elements = 0;
  file >> nodes >> elements;
  TetMesh mesh;
  mesh.nodes.resize(nodes);
  for (auto& x : mesh.nodes) file >> x[0] >> x[1] >> x[2];
  mesh.elements.resize(4 * elements);
  for (auto& n : mesh.elements) file >> n;
  if (!file) throw std::runtime_error("cannot read " + path);
  mesh.regions.assign(elements, 0);
  mesh.region_names = {"body"};
  for (std::size_t e = 0; e < elements; ++e) {
    auto* v = &mesh.elements[4 * e];
    const auto x = [&mesh](std::int32_t n) { return mesh.nodes[static_cast<std::size_t>(n)]; };
    if ((x(v[1]) - x(v[0])).cross(x(v[2]) - x(v[0])).dot(x(v[3]) - x(v[0])) < 0) {
      std::swap(v[2], v[3]);
    }
  }
  mesh.faces = solvers::mesh::boundary_faces(mesh);
  return mesh;
}

std::string data_folder() {
  const char* folder = std::getenv("CARILLON_TEST_DATA");
  return folder ? folder : "";
}

}  // namespace carillon::test
