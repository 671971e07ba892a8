#include "render/voxels.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "core/error.hpp"
#include "core/units.hpp"
#include "render/detail/inside_cells.hpp"
#include "render/detail/triangle_box.hpp"
#include "render/detail/vertex_normals.hpp"

namespace carillon::render {

namespace {

constexpr int max_resolution = 512;

/// How far the surface is moved inward before its cells are looked for, in cells: a face that lies
/// exactly between two cells then belongs to the inner one, wherever rounding puts it. Vertices are
/// moved, so that the surface stays closed and nothing leaks.
constexpr double inward = 1e-6;
constexpr double touch = 1e-9;

/// Cells the surface passes through; vertices are given in cells.
std::vector<std::uint8_t> surface_cells(const std::vector<Vec3>& vertices,
                                        const std::vector<solvers::mesh::Triangle>& triangles,
                                        int n) {
  const auto size = static_cast<std::size_t>(n);
  std::vector<std::uint8_t> cells(size * size * size, 0);
  const std::vector<Vec3> normals = vertex_normals(vertices, triangles);
  const auto cell_of = [&](double position) {
    return std::clamp(static_cast<int>(std::floor(position)), 0, n - 1);
  };
  for (const solvers::mesh::Triangle& triangle : triangles) {
    std::array<Vec3, 3> corner;
    for (std::size_t k = 0; k < 3; ++k) {
      const auto vertex = static_cast<std::size_t>(triangle[k]);
      corner[k] = vertices[vertex] - inward * normals[vertex];
    }
    const Vec3 low = corner[0].cwiseMin(corner[1]).cwiseMin(corner[2]);
    const Vec3 high = corner[0].cwiseMax(corner[1]).cwiseMax(corner[2]);
    for (int x = cell_of(low.x() - touch); x <= cell_of(high.x() + touch); ++x) {
      for (int y = cell_of(low.y() - touch); y <= cell_of(high.y() + touch); ++y) {
        for (int z = cell_of(low.z() - touch); z <= cell_of(high.z() + touch); ++z) {
          auto& cell =
              cells[(static_cast<std::size_t>(x) * size + static_cast<std::size_t>(y)) * size +
                    static_cast<std::size_t>(z)];
          if (cell == 0 && triangle_meets_box(corner, Vec3(x + 0.5, y + 0.5, z + 0.5),
                                              Vec3::Constant(0.5), touch)) {
            cell = 1;
          }
        }
      }
    }
  }
  return cells;
}

/// Empty cells joined to the outside through faces of empty cells; the grid's border is outside.
std::vector<std::uint8_t> reachable_cells(const std::vector<std::uint8_t>& filled, int n) {
  const auto size = static_cast<std::size_t>(n);
  std::vector<std::uint8_t> reached(filled.size(), 0);
  std::vector<std::array<int, 3>> front;
  const auto visit = [&](int x, int y, int z) {
    if (x < 0 || y < 0 || z < 0 || x >= n || y >= n || z >= n) return;
    const std::size_t index =
        (static_cast<std::size_t>(x) * size + static_cast<std::size_t>(y)) * size +
        static_cast<std::size_t>(z);
    if (filled[index] != 0 || reached[index] != 0) return;
    reached[index] = 1;
    front.push_back({x, y, z});
  };
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < n; ++j) {
      for (const int end : {0, n - 1}) {
        visit(end, i, j);
        visit(i, end, j);
        visit(i, j, end);
      }
    }
  }
  while (!front.empty()) {
    const auto [x, y, z] = front.back();
    front.pop_back();
    visit(x - 1, y, z);
    visit(x + 1, y, z);
    visit(x, y - 1, z);
    visit(x, y + 1, z);
    visit(x, y, z - 1);
    visit(x, y, z + 1);
  }
  return reached;
}

void check(const solvers::mesh::SurfaceMesh& mesh, const VoxelOptions& options) {
  if (options.resolution < 1 || options.resolution > max_resolution) {
    throw core::InputError(fmt::format("voxels: resolution must be 1 to {}, not {}", max_resolution,
                                       options.resolution));
  }
  if (!(options.pitch >= 0) || !std::isfinite(options.pitch)) {
    throw core::InputError(fmt::format("voxels: pitch must be positive, not {} m", options.pitch));
  }
  if (mesh.triangles.empty()) throw core::InputError("voxels: the mesh has no faces");
  for (const Vec3& vertex : mesh.vertices) {
    if (!vertex.allFinite()) throw core::InputError("voxels: a vertex is not finite");
  }
  const auto vertices = static_cast<std::int32_t>(mesh.vertices.size());
  for (const solvers::mesh::Triangle& triangle : mesh.triangles) {
    for (const std::int32_t vertex : triangle) {
      if (vertex < 0 || vertex >= vertices) {
        throw core::InputError(
            fmt::format("voxels: a face names vertex {} of {}", vertex, mesh.vertices.size()));
      }
    }
  }
}

/// Four digits, none of them too small.
double rounded_up(double value) {
  const double unit = std::pow(10.0, std::floor(std::log10(value)) - 3);
  return std::ceil(value / unit) * unit;
}

/// Box of the vertices that faces use; stray vertices are no part of the body.
solvers::mesh::Box box_of_faces(const solvers::mesh::SurfaceMesh& mesh) {
  solvers::mesh::Box box;
  box.low = box.high = mesh.vertices[static_cast<std::size_t>(mesh.triangles[0][0])];
  for (const solvers::mesh::Triangle& triangle : mesh.triangles) {
    for (const std::int32_t vertex : triangle) {
      const Vec3& position = mesh.vertices[static_cast<std::size_t>(vertex)];
      box.low = box.low.cwiseMin(position);
      box.high = box.high.cwiseMax(position);
    }
  }
  return box;
}

}  // namespace

VoxelGrid voxelize(const solvers::mesh::SurfaceMesh& mesh, const VoxelOptions& options) {
  check(mesh, options);
  const int n = options.resolution;
  const solvers::mesh::Box box = box_of_faces(mesh);
  const double longest = box.longest_side();
  if (!(longest > 0)) throw core::InputError("voxels: the object has no extent");

  VoxelGrid grid;
  grid.resolution = n;
  grid.pitch = options.pitch > 0 ? options.pitch : longest / n;
  if (longest > grid.pitch * n * (1 + 1e-9)) {
    throw core::InputError(
        fmt::format("voxels: {} cells of {:.4g} m hold {:.4g} m, but the object is {:.4g} m long",
                    n, grid.pitch, grid.pitch * n, longest),
        fmt::format("a pitch of {:.4g} m fits", rounded_up(longest / n)));
  }
  const Vec3 centre = (box.low + box.high) / 2;
  grid.origin = centre - Vec3::Constant(grid.pitch * n / 2);

  // Relative to the centre, so that a body far from the origin keeps its digits.
  std::vector<Vec3> vertices;
  vertices.reserve(mesh.vertices.size());
  for (const Vec3& vertex : mesh.vertices) {
    vertices.push_back((vertex - centre) / grid.pitch + Vec3::Constant(n / 2.0));
  }
  grid.cells = surface_cells(vertices, mesh.triangles, n);
  if (options.fill == VoxelFill::outer) {
    const std::vector<std::uint8_t> reached = reachable_cells(grid.cells, n);
    for (std::size_t i = 0; i < grid.cells.size(); ++i) grid.cells[i] = reached[i] != 0 ? 0 : 1;
  } else if (options.fill == VoxelFill::solid) {
    const std::vector<std::uint8_t> inside = cells_inside(vertices, mesh.triangles, n);
    for (std::size_t i = 0; i < grid.cells.size(); ++i) grid.cells[i] |= inside[i];
  }
  return grid;
}

std::vector<VoxelGrid> voxelize_turned(const solvers::mesh::SurfaceMesh& mesh,
                                       const VoxelOptions& options) {
  if (options.turns < 1 || options.turns > max_turns) {
    throw core::InputError(
        fmt::format("voxels: turns must lie within 1 and {}, not {}", max_turns, options.turns));
  }
  std::vector<solvers::mesh::SurfaceMesh> copies(static_cast<std::size_t>(options.turns), mesh);
  VoxelOptions common = options;
  for (std::size_t k = 1; k < copies.size(); ++k) {
    const double angle = 2 * std::numbers::pi * static_cast<double>(k) / options.turns;
    const Eigen::AngleAxisd turn(angle, Vec3::UnitZ());
    for (Vec3& vertex : copies[k].vertices) vertex = turn * vertex;
  }
  if (options.pitch == 0 && copies.size() > 1) {
    for (const solvers::mesh::SurfaceMesh& copy : copies) {
      check(copy, options);
      common.pitch = std::max(common.pitch, box_of_faces(copy).longest_side() / options.resolution);
    }
  }
  std::vector<VoxelGrid> grids;
  for (const solvers::mesh::SurfaceMesh& copy : copies) grids.push_back(voxelize(copy, common));
  return grids;
}

VoxelFill parse_voxel_fill(const std::string& name) {
  if (name == "surface") return VoxelFill::surface;
  if (name == "outer") return VoxelFill::outer;
  if (name == "solid") return VoxelFill::solid;
  const std::string nearest = core::nearest_name(name, {"surface", "outer", "solid"});
  throw core::InputError(
      fmt::format("unknown voxel fill \"{}\"{}", name,
                  nearest.empty() ? "" : fmt::format("; did you mean \"{}\"?", nearest)),
      "known: surface, outer, solid");
}

}  // namespace carillon::render
