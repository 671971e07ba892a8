#include "dataset/exporters/gltf_surface.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <map>
#include <utility>

#include "render/shading_mesh.hpp"

namespace carillon::dataset::exporters {

std::array<float, 3> to_gltf_axes(const Vec3& vector) {
  return {static_cast<float>(vector.x()), static_cast<float>(vector.z()),
          static_cast<float>(-vector.y())};
}

GltfSurface gltf_surface(const solvers::modes::ModeSurface& surface,
                         std::span<const std::int32_t> face_regions, std::size_t regions) {
  GltfSurface result;
  result.mesh = solvers::modes::flatten(surface);
  // A ball of radius 1 about the origin leaves the positions as they are.
  const render::ShadingMesh shading =
      render::shading_mesh(result.mesh, {Vec3::Zero(), 1}, render::default_crease_angle);
  result.smooth = shading.indices;
  result.regions.resize(regions);
  const auto pieces = static_cast<std::size_t>(surface.order) * std::size_t(surface.order);
  // Nodes at one place may share a normal, but they move apart.
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> vertices;
  for (std::size_t corner = 0; corner < result.smooth.size(); ++corner) {
    const auto node = static_cast<std::uint32_t>(result.mesh.triangles[corner / 3][corner % 3]);
    const std::uint32_t normal = result.smooth[corner];
    const auto [found, fresh] =
        vertices.try_emplace({normal, node}, static_cast<std::uint32_t>(result.nodes.size()));
    if (fresh) {
      result.nodes.push_back(node);
      result.positions.push_back(to_gltf_axes(result.mesh.vertices[node]));
      const float* n = &shading.normals[std::size_t{3} * normal];
      result.normals.push_back({n[0], n[2], -n[1]});
    }
    result.corners.push_back(found->second);
    const std::size_t face = corner / 3 / pieces;
    const std::size_t region =
        face_regions.empty() ? 0 : static_cast<std::size_t>(face_regions[face]);
    result.regions[region].push_back(found->second);
  }
  return result;
}

namespace {

/// The surface's normals where its nodes are displaced, numbered as GltfSurface::smooth; zero where
/// there is none.
std::vector<Vec3> displaced_normals(const GltfSurface& surface, const Eigen::VectorXd& by,
                                    double weight) {
  std::vector<Vec3> normals(surface.nodes.size(), Vec3::Zero());
  for (std::size_t t = 0; t < surface.mesh.triangles.size(); ++t) {
    std::array<Vec3, 3> corners;
    for (std::size_t k = 0; k < 3; ++k) {
      const auto node = surface.mesh.triangles[t][k];
      corners[k] = surface.mesh.vertices[static_cast<std::size_t>(node)] +
                   weight * by.segment<3>(3 * Eigen::Index{node});
    }
    const Vec3 area = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
    if (!(area.norm() > 0)) continue;
    for (std::size_t k = 0; k < 3; ++k) {
      const double angle = solvers::mesh::angle_between(corners[(k + 1) % 3] - corners[k],
                                                        corners[(k + 2) % 3] - corners[k]);
      normals[surface.smooth[3 * t + k]] += angle * area.normalized();
    }
  }
  for (Vec3& normal : normals) normal.normalize();  // leaves zero as it is
  return normals;
}

}  // namespace

GltfTarget gltf_target(const GltfSurface& surface, const Eigen::VectorXd& displacements) {
  const std::vector<Vec3> there = displaced_normals(surface, displacements, 1);
  const std::vector<Vec3> back = displaced_normals(surface, displacements, -1);
  GltfTarget target;
  target.positions.resize(surface.nodes.size());
  target.normals.resize(surface.nodes.size());
  std::size_t corner = 0;
  for (const solvers::mesh::Triangle& triangle : surface.mesh.triangles) {
    for (std::size_t k = 0; k < 3; ++k, ++corner) {
      const std::uint32_t vertex = surface.corners[corner];
      const Eigen::Index node = triangle[k];
      target.positions[vertex] = to_gltf_axes(displacements.segment<3>(3 * node));
      const std::uint32_t normal = surface.smooth[corner];
      target.normals[vertex] = to_gltf_axes((there[normal] - back[normal]) / 2);
    }
  }
  return target;
}

}  // namespace carillon::dataset::exporters
