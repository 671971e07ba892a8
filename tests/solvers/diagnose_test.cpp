// Diagnosis of surfaces whose defects are known.
#include <gtest/gtest.h>

#include <utility>

#include "tests/solvers/repaired.hpp"

namespace carillon::solvers {
namespace {

using namespace test;  // NOLINT: bodies and damages

TEST(Diagnose, FindsNothingWrongWithCleanBodies) {
  for (const Body& body : bodies()) {
    SCOPED_TRACE(body.name);
    const mesh::Diagnosis d = mesh::repair::diagnose(body.mesh);
    EXPECT_TRUE(d.clean);
    EXPECT_TRUE(d.closed);
    EXPECT_EQ(d.components, 1);
    EXPECT_GT(d.volume, 0);
  }
  const mesh::Diagnosis box = mesh::repair::diagnose(box_surface(Vec3(1, 2, 3), 2));
  EXPECT_NEAR(box.volume, 6, 1e-14);
  EXPECT_NEAR(box.area, 22, 1e-13);
  EXPECT_EQ(box.extent, (std::array<double, 3>{1, 2, 3}));
  EXPECT_EQ(box.vertices, 26);
  EXPECT_EQ(box.triangles, 48);
}

TEST(Diagnose, CountsEveryDefect) {
  mesh::SurfaceMesh mesh = box_surface(Vec3(1, 1, 1), 2);
  mesh.triangles.push_back(mesh.triangles[3]);  // a twin: three new edges of 3
  mesh.vertices.push_back(mesh.vertices[0]);    // a duplicate nobody uses
  mesh.triangles.push_back({mesh.triangles[0][0], mesh.triangles[0][0], mesh.triangles[0][1]});
  mesh::Diagnosis d = mesh::repair::diagnose(mesh);
  EXPECT_EQ(d.duplicate_triangles, 1);
  EXPECT_EQ(d.duplicate_vertices, 1);
  EXPECT_EQ(d.unreferenced_vertices, 1);
  EXPECT_EQ(d.degenerate_triangles, 1);
  EXPECT_GE(d.nonmanifold_edges, 3);
  EXPECT_FALSE(d.clean);

  mesh = box_surface(Vec3(1, 1, 1), 2);
  std::swap(mesh.triangles[5][0], mesh.triangles[5][1]);
  EXPECT_EQ(mesh::repair::diagnose(mesh).misoriented_edges, 3);
  mesh.triangles.erase(mesh.triangles.begin() + 5);
  EXPECT_EQ(mesh::repair::diagnose(mesh).boundary_edges, 3);
  EXPECT_FALSE(mesh::repair::diagnose(mesh).closed);

  const mesh::SurfaceMesh sphere = sphere_surface(1, 6);
  d = mesh::repair::diagnose(together(sphere, moved(sphere, Vec3(1, 0, 0))));
  EXPECT_EQ(d.components, 2);
  EXPECT_EQ(d.touching_components, 2);
  EXPECT_GT(d.self_intersections, 10);
  d = mesh::repair::diagnose(together(sphere, turned_over(sphere_surface(0.5, 4))));
  EXPECT_EQ(d.nested_components, 1);
  EXPECT_TRUE(d.clean);  // a hollow ball
  EXPECT_FALSE(mesh::repair::diagnose(together(sphere, sphere_surface(0.5, 4))).clean);
  EXPECT_FALSE(mesh::repair::diagnose(turned_over(sphere)).clean);
}

TEST(Diagnose, FindsVerticesWhereSurfacesOnlyTouch) {
  const mesh::SurfaceMesh box = box_surface(Vec3(1, 1, 1), 1);
  mesh::SurfaceMesh mesh = together(box, moved(box, Vec3(1, 1, 1)));
  // Join the corners that meet.
  std::int32_t corner = -1;
  for (std::size_t v = 0; v < 8; ++v) {
    if (mesh.vertices[v] == Vec3(1, 1, 1)) corner = static_cast<std::int32_t>(v);
  }
  for (mesh::Triangle& t : mesh.triangles) {
    for (std::int32_t& v : t) {
      if (mesh.vertices[static_cast<std::size_t>(v)] == Vec3(1, 1, 1)) v = corner;
    }
  }
  const mesh::Diagnosis d = mesh::repair::diagnose(mesh);
  EXPECT_EQ(d.nonmanifold_vertices, 1);
  EXPECT_EQ(d.nonmanifold_edges, 0);
  EXPECT_EQ(d.touching_components, 2);
}

}  // namespace
}  // namespace carillon::solvers
