#include "render/shading_mesh.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>

#include "core/disjoint_sets.hpp"
#include "core/error.hpp"
#include "solvers/mesh/weld.hpp"

namespace carillon::render {

namespace {

/// One side of a face: its ends in ascending order and the corners that lie on them.
struct Side {
  std::array<std::int32_t, 2> ends;
  std::array<std::size_t, 2> corners;
  bool forward;  ///< the face runs from the lower end to the higher
};

}  // namespace

BoundingBall bounding_ball(const solvers::mesh::SurfaceMesh& mesh) {
  if (mesh.triangles.empty()) throw core::InputError("picture: the mesh has no faces");
  std::vector<Vec3> used;
  used.reserve(3 * mesh.triangles.size());
  for (const solvers::mesh::Triangle& triangle : mesh.triangles) {
    for (const std::int32_t vertex : triangle) {
      if (vertex < 0 || static_cast<std::size_t>(vertex) >= mesh.vertices.size() ||
          !mesh.vertices[static_cast<std::size_t>(vertex)].allFinite()) {
        throw core::InputError("picture: a face has a vertex that is missing or not finite");
      }
      used.push_back(mesh.vertices[static_cast<std::size_t>(vertex)]);
    }
  }
  BoundingBall ball;
  const solvers::mesh::Box box = solvers::mesh::bounding_box(used);
  ball.centre = (box.low + box.high) / 2;
  for (const Vec3& position : used) {
    ball.radius = std::max(ball.radius, (position - ball.centre).norm());
  }
  if (!(ball.radius > 0)) throw core::InputError("picture: the object has no extent");
  return ball;
}

ShadingMesh shading_mesh(const solvers::mesh::SurfaceMesh& mesh, const BoundingBall& ball,
                         double crease_angle) {
  const std::vector<std::int32_t> weld = solvers::mesh::first_at_place(mesh.vertices);
  const std::size_t corners = 3 * mesh.triangles.size();
  const auto position_of = [&](std::size_t corner) -> const Vec3& {
    return mesh.vertices[static_cast<std::size_t>(mesh.triangles[corner / 3][corner % 3])];
  };

  // Unit face normals (zero for faces without area) and all sides.
  std::vector<Vec3> face_normal(mesh.triangles.size());
  std::vector<Side> sides;
  sides.reserve(corners);
  for (std::size_t face = 0; face < mesh.triangles.size(); ++face) {
    const std::size_t c = 3 * face;
    const Vec3 normal =
        (position_of(c + 1) - position_of(c)).cross(position_of(c + 2) - position_of(c));
    face_normal[face] = normal.norm() > 0 ? normal.normalized() : Vec3(Vec3::Zero());
    for (std::size_t k = 0; k < 3; ++k) {
      const std::size_t from = c + k;
      const std::size_t to = c + (k + 1) % 3;
      const auto a = weld[static_cast<std::size_t>(mesh.triangles[face][k])];
      const auto b = weld[static_cast<std::size_t>(mesh.triangles[face][(k + 1) % 3])];
      if (a < b) {
        sides.push_back({{a, b}, {from, to}, true});
      } else if (b < a) {
        sides.push_back({{b, a}, {to, from}, false});
      }
    }
  }
  std::stable_sort(sides.begin(), sides.end(),
                   [](const Side& a, const Side& b) { return a.ends < b.ends; });

  core::DisjointSets smooth(corners);
  const double cosine = std::cos(crease_angle);
  for (std::size_t i = 0; i < sides.size();) {
    std::size_t end = i + 1;
    while (end < sides.size() && sides[end].ends == sides[i].ends) ++end;
    // Only proper edges are smooth: two faces, oriented alike.
    if (end - i == 2 && sides[i].forward != sides[i + 1].forward &&
        face_normal[sides[i].corners[0] / 3].dot(face_normal[sides[i + 1].corners[0] / 3]) >
            cosine) {
      smooth.join(sides[i].corners[0], sides[i + 1].corners[0]);
      smooth.join(sides[i].corners[1], sides[i + 1].corners[1]);
    }
    i = end;
  }

  std::vector<Vec3> normal(corners, Vec3(Vec3::Zero()));
  for (std::size_t corner = 0; corner < corners; ++corner) {
    const std::size_t base = corner / 3 * 3;
    const Vec3 here = position_of(corner);
    const Vec3 one = position_of(base + (corner + 1) % 3) - here;
    const Vec3 two = position_of(base + (corner + 2) % 3) - here;
    normal[smooth.find(corner)] += solvers::mesh::angle_between(one, two) * face_normal[corner / 3];
  }

  ShadingMesh result;
  std::vector<std::uint32_t> index(corners);
  std::uint32_t count = 0;
  for (std::size_t corner = 0; corner < corners; ++corner) {
    const std::size_t group = smooth.find(corner);
    if (group == corner) {
      const Vec3 place = (position_of(corner) - ball.centre) / ball.radius;
      Vec3 direction = normal[corner];
      if (!(direction.norm() > 0)) direction = face_normal[corner / 3];
      if (!(direction.norm() > 0)) direction = Vec3::UnitZ();
      direction.normalize();
      for (Eigen::Index k = 0; k < 3; ++k) {
        result.positions.push_back(static_cast<float>(place[k]));
        result.normals.push_back(static_cast<float>(direction[k]));
      }
      result.sources.push_back(mesh.triangles[corner / 3][corner % 3]);
      index[corner] = count++;
    }
    // Groups are named by their lowest corner, so that it came before.
    result.indices.push_back(index[group]);
  }
  return result;
}

}  // namespace carillon::render
