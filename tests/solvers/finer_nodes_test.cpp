// Nodes of the next order, which errors are measured against.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "core/error.hpp"
#include "family_shapes.hpp"
#include "mesh_checks.hpp"
#include "solvers/mesh/curve_mesh.hpp"
#include "solvers/mesh/raise_order.hpp"

namespace carillon::test {
namespace {

using namespace solvers;
constexpr double pi = std::numbers::pi;

TEST(FinerNodes, EveryFamilyIsSoundAtTheNextOrder) {
  for (const auto& family : solvers::families::families())
    for (int order = 1; order <= 4; ++order) {
      SCOPED_TRACE(fmt::format("{} order {}", family.name, order));
      // Meshes of order 1 are fine by themselves: one of each way to make a mesh will do.
      if (order == 1 && family.name != "bell" && family.name != "turned") continue;
      const solvers::mesh::TetMesh mesh = mesh_of(shape_at(family, 0.4), order).mesh;
      ASSERT_FALSE(mesh.finer_nodes.empty());
      const solvers::mesh::TetMesh next = solvers::mesh::next_order(mesh);
      EXPECT_EQ(next.order, order + 1);
      EXPECT_EQ(mesh_faults(next), "");
      // The same elements: corners stay where they were.
      for (std::size_t e = 0; e < mesh.element_count(); ++e)
        for (std::size_t i = 0; i < 4; ++i)
          EXPECT_EQ(next.nodes[static_cast<std::size_t>(next.element(e)[i])],
                    mesh.nodes[static_cast<std::size_t>(mesh.element(e)[i])]);
    }
}

struct RoundBody {
  GeneratedShape shape;
  double volume;  ///< [m^3]
  double size;    ///< of its elements [m]
};

std::vector<RoundBody> round_bodies() {
  return {{shape_of("tube", {{"radius", 0.03}, {"wall", 0.01}, {"length", 0.04}}),
           pi * (9e-4 - 4e-4) * 0.04, 0.016},
          {shape_of("disc", {{"radius", 0.05}, {"thickness", 0.01}}), pi * 25e-4 * 0.01, 0.03},
          {shape_of("sphere", {{"radius", 0.05}}), 4 * pi / 3 * 1.25e-4, 0.032}};
}

TEST(FinerNodes, TheNextOrderIsNearerToTheTrueBody) {
  for (const RoundBody& body : round_bodies())
    for (int order = 1; order <= 4; ++order) {
      const solvers::mesh::TetMesh mesh = mesh_of(body.shape, order, body.size).mesh;
      const auto error = [&](const solvers::mesh::TetMesh& m) {
        return std::abs(solvers::mesh::measure_quality(m).volume / body.volume - 1);
      };
      // An odd order that follows an even one has the same rate and a smaller constant.
      const double gain = order % 2 == 1 ? 20 : 1.5;
      EXPECT_LT(error(solvers::mesh::next_order(mesh)), std::max(1e-12, error(mesh) / gain))
          << body.shape.family << " order " << order;
      EXPECT_NEAR(
          solvers::mesh::measure_quality(solvers::mesh::raise_order(mesh, order + 1)).volume,
          solvers::mesh::measure_quality(mesh).volume, 1e-12 * body.volume);
    }
}

TEST(FinerNodes, TheNextOrderConvergesFaster) {
  // Volumes of order 1 converge with h^2, of orders 2 and 3 with h^4, of order 4 with h^6.
  for (const RoundBody& body : round_bodies())
    for (int order : {1, 3}) {
      if (order == 3 && body.shape.family == "sphere") continue;  // its elements are not nested
      double errors[2][2];
      for (int i = 0; i < 2; ++i) {
        const solvers::mesh::TetMesh mesh = mesh_of(body.shape, order, body.size / (1 + i)).mesh;
        errors[0][i] = std::abs(solvers::mesh::measure_quality(mesh).volume / body.volume - 1);
        errors[1][i] = std::abs(
            solvers::mesh::measure_quality(solvers::mesh::next_order(mesh)).volume / body.volume -
            1);
      }
      EXPECT_GT(errors[1][0] / errors[1][1], 2 * errors[0][0] / errors[0][1])
          << body.shape.family << " order " << order;
    }
}

solvers::mesh::TetMesh one_tetrahedron(double height) {
  solvers::mesh::TetMesh one;
  one.nodes = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, height}};
  one.elements = {0, 1, 2, 3};
  one.regions = {0};
  one.region_names = {"body"};
  one.faces = solvers::mesh::boundary_faces(one);
  return one;
}

/// A projection that moves points of the bottom, which looks down, along z. Others would move too
/// far to be followed.
solvers::mesh::SurfaceProjection lift_bottom(double (*lift)(const Vec3&)) {
  return {[lift](const Vec3& p, const Vec3& normal) -> Vec3 {
            return normal.z() < -0.9 ? Vec3(p.x(), p.y(), p.z() + lift(p)) : p + Vec3(5, 0, 0);
          },
          {}};
}

TEST(FinerNodes, AnElementThatOnlyTheNextOrderWouldFoldStaysAsItIs) {
  // The bottom's middle is a node of order 3 alone, and there it would pass through the top.
  std::int64_t straightened = 0;
  const auto peak = [](const Vec3& p) {
    return (p - Vec3(1.0 / 3, 1.0 / 3, p.z())).norm() < 1e-6 ? 0.2 : 0.0;
  };
  const solvers::mesh::TetMesh mesh =
      solvers::mesh::curve_mesh(one_tetrahedron(0.1), 2, lift_bottom(peak), straightened);
  EXPECT_EQ(straightened, 0);
  const solvers::mesh::TetMesh next = solvers::mesh::next_order(mesh);
  EXPECT_EQ(mesh_faults(next), "");
  EXPECT_NEAR(solvers::mesh::measure_quality(next).volume,
              solvers::mesh::measure_quality(mesh).volume, 1e-15);
  // What it lacks is known: that one node, a fifth of a metre.
  ASSERT_EQ(mesh.finer_gaps.size(), mesh.finer_nodes.size());
  double maximum = 0, sum = 0;
  for (const auto& gap : mesh.finer_gaps) {
    maximum = std::max(maximum, gap.norm());
    sum += gap.norm();
  }
  EXPECT_NEAR(maximum, 0.2, 1e-12);
  EXPECT_NEAR(sum, maximum, 1e-12);
}

TEST(FinerNodes, AnElementThatWasStraightenedIsCurvedWhereTheNextOrderIsSound) {
  // Order 3 has the middle as a node and folds; order 4 does not see it, but a gentle dent beside
  // it.
  std::int64_t straightened = 0;
  const auto peak = [](const Vec3& p) {
    if ((p - Vec3(1.0 / 3, 1.0 / 3, p.z())).norm() < 1e-6) return 0.2;
    return (p - Vec3(0.25, 0.25, p.z())).norm() < 1e-6 ? 0.005 : 0.0;
  };
  const solvers::mesh::TetMesh mesh =
      solvers::mesh::curve_mesh(one_tetrahedron(0.1), 3, lift_bottom(peak), straightened);
  EXPECT_EQ(straightened, 1);
  EXPECT_NEAR(solvers::mesh::measure_quality(mesh).volume, 0.1 / 6, 1e-15);
  const solvers::mesh::TetMesh next = solvers::mesh::next_order(mesh);
  EXPECT_EQ(mesh_faults(next), "");
  EXPECT_LT(solvers::mesh::measure_quality(next).volume, 0.1 / 6 * (1 - 1e-3));
}

TEST(FinerNodes, WithoutAProjectionTheElementsAreTheTruth) {
  std::int64_t straightened = 0;
  EXPECT_TRUE(
      solvers::mesh::curve_mesh(one_tetrahedron(0.1), 3, {}, straightened).finer_nodes.empty());
}

TEST(FinerNodes, NodesOfAnotherMeshAreRefused) {
  solvers::mesh::TetMesh mesh = mesh_of(shape_at(find_family("block")), 2).mesh;
  mesh.finer_gaps.assign(mesh.finer_nodes.size() - 1, Vec3::Zero());
  EXPECT_THROW(solvers::mesh::next_order(mesh), core::InputError);
  mesh.finer_gaps.clear();
  mesh.finer_nodes.pop_back();
  EXPECT_THROW(solvers::mesh::next_order(mesh), core::InputError);
}

}  // namespace
}  // namespace carillon::test
