#include "solvers/mesh/flat_elements.hpp"

#include <gtest/gtest.h>

namespace carillon::solvers {
namespace {

mesh::TetMesh mesh_of(std::vector<Vec3> nodes, std::vector<std::int32_t> elements) {
  mesh::TetMesh mesh;
  mesh.order = 1;
  mesh.nodes = std::move(nodes);
  mesh.elements = std::move(elements);
  mesh.regions.assign(mesh.elements.size() / 4, 0);
  mesh.region_names = {"body"};
  mesh.faces = mesh::boundary_faces(mesh);
  return mesh;
}

const std::vector<Vec3> corners = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0.3, 0.3, 0}};

TEST(FlatElements, CapWithThreeOuterFacesGoesWithItsNode) {
  // Node 4 lies in the bottom face; the flat element 0, 1, 2, 4 hangs below it.
  mesh::TetMesh mesh = mesh_of(corners, {0, 1, 2, 3, 0, 2, 1, 4});
  EXPECT_EQ(mesh::peel_flat_elements(mesh), 1);
  EXPECT_EQ(mesh.element_count(), 1u);
  EXPECT_EQ(mesh.nodes.size(), 4u);
  EXPECT_EQ(mesh.face_count(), 4u);
}

TEST(FlatElements, SliverWithTwoOuterFacesGoes) {
  // A square pyramid cut along one diagonal of its base; the flat element flips to the other.
  const std::vector<Vec3> nodes = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0.5, 0.5, 1}};
  mesh::TetMesh mesh = mesh_of(nodes, {0, 1, 2, 4, 0, 2, 3, 4, 0, 2, 1, 3});
  EXPECT_EQ(mesh::peel_flat_elements(mesh), 1);
  EXPECT_EQ(mesh.element_count(), 2u);
  EXPECT_EQ(mesh.nodes.size(), 5u);
  EXPECT_EQ(mesh.face_count(), 6u);
}

TEST(FlatElements, SoundMeshesStayAsTheyAre) {
  mesh::TetMesh mesh = mesh_of(corners, {0, 1, 4, 3, 1, 2, 4, 3, 2, 0, 4, 3});
  const mesh::TetMesh before = mesh;
  EXPECT_EQ(mesh::peel_flat_elements(mesh), 0);
  EXPECT_EQ(mesh.elements, before.elements);
  EXPECT_EQ(mesh.faces, before.faces);
}

TEST(FlatElements, ThinButRealElementsStay) {
  std::vector<Vec3> nodes(corners.begin(), corners.begin() + 4);
  nodes[3].z() = 1e-5;
  mesh::TetMesh mesh = mesh_of(nodes, {0, 1, 2, 3});
  EXPECT_EQ(mesh::peel_flat_elements(mesh), 0);
}

}  // namespace
}  // namespace carillon::solvers
