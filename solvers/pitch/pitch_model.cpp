#include "solvers/pitch/pitch_model.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace carillon::solvers::pitch {
namespace {

/// Cents of a relative error of 1 in an eigenvalue, to first order: 600 / ln 2.
constexpr double cents_per_eigenvalue = 600 / std::numbers::ln2;

double longest_corner_edge(const mesh::TetMesh& mesh) {
  double longest = 0;
  for (std::size_t e = 0; e < mesh.element_count(); ++e) {
    const auto element = mesh.element(e);
    for (std::size_t i = 0; i < 4; ++i)
      for (std::size_t j = 0; j < i; ++j)
        longest = std::max(longest, (mesh.nodes[static_cast<std::size_t>(element[i])] -
                                     mesh.nodes[static_cast<std::size_t>(element[j])])
                                        .norm());
  }
  return longest;
}

}  // namespace

double MeshSize::unknowns() const {
  const double p = order;
  return 3 * (vertices + edges * (p - 1) + faces * (p - 1) * (p - 2) / 2 +
              elements * (p - 1) * (p - 2) * (p - 3) / 6);
}

double MeshSize::layers() const {
  // A cell's longest edge is its diagonal, about twice its height.
  return std::max(1.0, 2 * thickness / element_size);
}

MeshSize size_of(const mesh::TetMesh& mesh) {
  MeshSize size;
  size.order = mesh.order;
  size.element_size = longest_corner_edge(mesh);
  size.thickness = mesh::mean_thickness(mesh);
  std::vector<bool> corner(mesh.nodes.size(), false);
  for (std::size_t e = 0; e < mesh.element_count(); ++e)
    for (const auto n : mesh.element(e).first(4)) corner[static_cast<std::size_t>(n)] = true;
  size.elements = static_cast<double>(mesh.element_count());
  size.vertices = static_cast<double>(std::count(corner.begin(), corner.end(), true));
  // Each element has four faces, which but for the boundary's it shares.
  size.faces = (4 * size.elements + static_cast<double>(mesh.face_count())) / 2;
  // Euler's formula; what holes and cavities add does not matter here.
  size.edges = size.vertices + size.faces - size.elements - 1;
  return size;
}

MeshSize resized(const MeshSize& mesh, int order, double size_factor) {
  MeshSize out = mesh;
  out.order = order;
  out.element_size *= size_factor;
  const double growth = out.layers() / mesh.layers() / (size_factor * size_factor);
  for (double* count : {&out.elements, &out.vertices, &out.edges, &out.faces}) *count *= growth;
  return out;
}

double relative_cost(const MeshSize& mesh) {
  return std::pow(mesh.unknowns(), 1.35) * std::sqrt(mesh.layers()) * (1 + 0.28 * mesh.order);
}

double factor_memory(const MeshSize& mesh) {
  constexpr double plate_bytes = 4400, plate_unknowns = 342e3, plate_layers = 4;
  const double n = mesh.unknowns();
  return plate_bytes * n * std::pow(n / plate_unknowns, 0.1) *
         std::pow(mesh.layers() * mesh.order / plate_layers, 0.35);
}

double predicted_error(double measured, int from_order, int order, double size_factor) {
  const double p = from_order, q = order;
  const double x = p * std::pow(measured / cents_per_eigenvalue, 0.5 / p);
  return cents_per_eigenvalue * std::pow(x * size_factor / q, 2 * q);
}

double aimed_error(double target, double reached) {
  constexpr double aim = 0.6, exponent = 0.3;
  return aim * target * std::pow(std::min(1.0, target / reached), exponent);
}

int edge_layers_for(double cents) {
  constexpr double without = 12, ratio = 1.0 / 6;
  constexpr int maximum = 4;
  int layers = 0;
  for (double left = without; left > cents / 2 && layers < maximum; left *= ratio) ++layers;
  return layers;
}

}  // namespace carillon::solvers::pitch
