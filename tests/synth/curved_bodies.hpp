#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <utility>

#include "solvers/elements/lagrange.hpp"
#include "solvers/modes/modes.hpp"

namespace carillon::synth {

/// Sphere of curved faces of an order: an octahedron whose faces are cut into n^2, all nodes moved
/// onto the sphere. Inward faces when `inward`.
inline solvers::modes::ModeSurface curved_sphere(double radius, const Vec3& centre, int n,
                                                 int order, bool inward = false) {
  solvers::modes::ModeSurface surface;
  surface.order = order;
  const int fine = n * order;
  // Nodes by their place on the octahedron |x| + |y| + |z| = fine.
  std::map<std::array<int, 3>, std::int32_t> index;
  const auto node = [&](const std::array<int, 3>& place) {
    const auto [found, added] =
        index.emplace(place, static_cast<std::int32_t>(surface.nodes.size()));
    if (added) {
      // Angles rather than projection: faces of nearly equal area.
      const auto bend = [&](int i) { return std::sin(std::numbers::pi / 2 * i / fine); };
      const Vec3 direction = Vec3(bend(place[0]), bend(place[1]), bend(place[2])).normalized();
      surface.nodes.push_back(centre + radius * direction);
    }
    return found->second;
  };
  for (int octant = 0; octant < 8; ++octant) {
    const int sx = octant & 1 ? -1 : 1, sy = octant & 2 ? -1 : 1, sz = octant & 4 ? -1 : 1;
    const bool mirrored = (sx * sy * sz < 0) != inward;
    const auto add = [&](std::array<int, 2> a, std::array<int, 2> b, std::array<int, 2> c) {
      if (mirrored) std::swap(b, c);
      for (const auto& lattice : solvers::elements::triangle_lattice(order)) {
        const int x = a[0] * lattice[0] + b[0] * lattice[1] + c[0] * lattice[2];
        const int y = a[1] * lattice[0] + b[1] * lattice[1] + c[1] * lattice[2];
        surface.faces.push_back(node({sx * x, sy * y, sz * (fine - x - y)}));
      }
    };
    for (int i = 0; i < n; ++i) {
      for (int j = 0; i + j < n; ++j) {
        add({i, j}, {i + 1, j}, {i, j + 1});
        if (i + j + 2 <= n) add({i + 1, j}, {i + 1, j + 1}, {i, j + 1});
      }
    }
  }
  return surface;
}

/// Appends another surface's faces, as for a body with a cavity.
inline void append(solvers::modes::ModeSurface& surface, const solvers::modes::ModeSurface& more) {
  const auto shift = static_cast<std::int32_t>(surface.nodes.size());
  surface.nodes.insert(surface.nodes.end(), more.nodes.begin(), more.nodes.end());
  for (const std::int32_t node : more.faces) surface.faces.push_back(node + shift);
}

/// The same shapes where the body is turned: displacements at each node, not its place.
inline solvers::modes::ModeShapes turned_shapes(const solvers::modes::ModeShapes& shapes,
                                                const Eigen::Matrix3d& turn) {
  solvers::modes::ModeShapes::Rows rows = shapes.at_nodes();
  for (Eigen::Index i = 0; i < rows.rows(); ++i) {
    for (Eigen::Index a = 0; a < rows.cols(); a += 3) {
      const Vec3 value = turn * rows.block<1, 3>(i, a).transpose().cast<double>();
      rows.block<1, 3>(i, a) = value.transpose().cast<float>();
    }
  }
  return solvers::modes::ModeShapes(std::move(rows));
}

/// Modes of a one-region body with shapes given by `shape(mode, position)` [kg^-1/2].
template <class Shape>
solvers::modes::Modes modes_with(const solvers::modes::ModeSurface& surface,
                                 std::vector<double> eigenvalues, const Shape& shape) {
  solvers::modes::Modes modes;
  const auto count = static_cast<Eigen::Index>(eigenvalues.size());
  modes.eigenvalues = std::move(eigenvalues);
  modes.surface = surface;
  modes.kinetic_fraction = Eigen::MatrixXd::Ones(count, 1);
  modes.strain_fraction = Eigen::MatrixXd::Ones(count, 1);
  solvers::modes::ModeShapes::Rows rows(count, 3 * static_cast<Eigen::Index>(surface.nodes.size()));
  for (Eigen::Index i = 0; i < count; ++i) {
    for (std::size_t a = 0; a < surface.nodes.size(); ++a) {
      const Vec3 value = shape(static_cast<int>(i), surface.nodes[a]);
      rows.block<1, 3>(i, 3 * static_cast<Eigen::Index>(a)) = value.transpose().cast<float>();
    }
  }
  modes.shapes = solvers::modes::ModeShapes(std::move(rows));
  return modes;
}

}  // namespace carillon::synth
