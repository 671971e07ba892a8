// Thin layers at inward edges: the same body in more elements, which neither overlap nor leave
// gaps.
#include "solvers/mesh/grade_to_edges.hpp"

#include <gtest/gtest.h>
#include <rapidcheck.h>
#include <rapidcheck/gtest.h>

#include <cmath>
#include <limits>
#include <set>
#include <utility>

#include "family_shapes.hpp"
#include "mesh_checks.hpp"
#include "prisms.hpp"
#include "solvers/mesh/conformity.hpp"
#include "solvers/mesh/inward_edges.hpp"
#include "solvers/mesh/raise_order.hpp"
#include "solvers/mesh/tetrahedra/mesher.hpp"
#include "test_surfaces.hpp"

namespace carillon::test {
namespace {

using namespace solvers;

mesh::TetMesh angle_bracket(int order) {
  mesh::MeshOptions options;
  options.order = order;
  options.element_size = 0.8;
  return mesh::tetrahedra::tetrahedralise(
             prism({{0, 0}, {3, 0}, {3, 1}, {1, 1}, {1, 3}, {0, 3}}, 1), options)
      .mesh;
}

/// A shaft with a step: its inward edge is a circle on curved faces.
mesh::TetMesh stepped_shaft(int order) {
  mesh::MeshOptions options;
  options.order = order;
  return families::mesh_family(
             {"turned",
              {},
              {{0, 0}, {0.02, 0}, {0.02, 0.02}, {0.01, 0.02}, {0.01, 0.06}, {0, 0.06}}},
             options)
      .mesh;
}

void expect_same_body(const mesh::TetMesh& plain, int layers) {
  const mesh::TetMesh graded = mesh::grade_to_edges(plain, layers);
  EXPECT_EQ(mesh_faults(graded), "");
  EXPECT_NO_THROW(mesh::refuse_overlaps(graded));
  const double volume = mesh::measure_quality(plain).volume, area = boundary_area(plain);
  EXPECT_NEAR(mesh::measure_quality(graded).volume, volume, 1e-12 * volume);
  EXPECT_NEAR(boundary_area(graded), area, 1e-5 * area);
  EXPECT_LE(longest_edge(graded), 1.05 * longest_edge(plain));
  EXPECT_EQ(graded.finer_nodes.empty(), plain.finer_nodes.empty());
  const double finer = mesh::measure_quality(mesh::next_order(plain)).volume;
  EXPECT_NEAR(mesh::measure_quality(mesh::next_order(graded)).volume, finer, 1e-12 * finer);
}

/// Length of the inward edges that grading goes to [m], and the shortest edge across them.
std::pair<double, double> edges_and_sizes(const mesh::TetMesh& mesh) {
  std::set<std::int32_t> ends;
  std::set<std::pair<std::int32_t, std::int32_t>> along;
  double length = 0, shortest = std::numeric_limits<double>::infinity();
  const auto distance = [&mesh](std::int32_t a, std::int32_t b) {
    return (mesh.nodes[static_cast<std::size_t>(a)] - mesh.nodes[static_cast<std::size_t>(b)])
        .norm();
  };
  for (const mesh::InwardEdge& edge : mesh::inward_edges(mesh)) {
    length += distance(edge.from, edge.to);
    along.insert({edge.from, edge.to});
    ends.insert({edge.from, edge.to});
  }
  for (std::size_t e = 0; e < mesh.element_count(); ++e) {
    const auto corners = mesh.element(e).first(4);
    for (const std::int32_t a : corners)
      for (const std::int32_t b : corners)
        if (a < b && (ends.contains(a) || ends.contains(b)) && !along.contains({a, b}))
          shortest = std::min(shortest, distance(a, b));
  }
  return {length, shortest};
}

TEST(GradeToEdges, KeepsTheBody) {
  for (const int order : {1, 2, 3, 4})
    for (const int layers : {1, 3}) {
      SCOPED_TRACE(testing::Message() << "order " << order << ", layers " << layers);
      expect_same_body(angle_bracket(order), layers);
      EXPECT_FALSE(mesh::find_hanging_node(mesh::grade_to_edges(angle_bracket(order), layers)));
      expect_same_body(stepped_shaft(order), layers);
    }
}

TEST(GradeToEdges, ThinsElementsAcrossEdgesAndNotAlong) {
  for (const auto& plain : {angle_bracket(3), stepped_shaft(3)}) {
    const auto [length, size] = edges_and_sizes(plain);
    ASSERT_GT(length, 0);
    for (const int layers : {1, 2}) {
      const mesh::TetMesh graded = mesh::grade_to_edges(plain, layers);
      const auto [same, thinner] = edges_and_sizes(graded);
      EXPECT_NEAR(same, length, 1e-9 * length);
      EXPECT_NEAR(thinner, size * std::pow(mesh::layer_ratio, layers),
                  0.3 * size * std::pow(mesh::layer_ratio, layers));
      EXPECT_EQ(mesh::inward_edges(graded).size(), mesh::inward_edges(plain).size());
    }
  }
}

/// The least Passage::rho of lines between corners of elements that an inward edge passes amid.
double nearest_passage(const mesh::TetMesh& mesh) {
  const auto edges = mesh::inward_edges(mesh);
  double rho = std::numeric_limits<double>::infinity();
  for (std::size_t e = 0; e < mesh.element_count(); ++e) {
    const auto corners = mesh.element(e).first(4);
    for (const std::int32_t a : corners)
      for (const std::int32_t b : corners)
        for (const mesh::InwardEdge& edge : edges) {
          const mesh::Passage passed = mesh::passage(mesh, a, b, edge);
          if (a < b && passed.share > 0.1 && passed.share < 0.9) rho = std::min(rho, passed.rho);
        }
  }
  return rho;
}

TEST(GradeToEdges, CutsLinesThatAnEdgePasses) {
  // Legs of 4 mm on a base of 10 mm: lines run from the base's top to the legs' outer sides.
  std::vector<Vec2> section{{0, 0},   {59, 0}, {59, 66}, {55, 66},
                            {55, 10}, {4, 10}, {4, 66},  {0, 66}};
  for (Vec2& p : section) p *= 1e-3;
  mesh::MeshOptions options;
  options.element_size = 0.0156;
  const auto plain = mesh::tetrahedra::tetrahedralise(prism(section, 0.028), options).mesh;
  EXPECT_LT(nearest_passage(plain), 1.3);
  expect_same_body(plain, 1);
  EXPECT_GT(nearest_passage(mesh::grade_to_edges(plain, 1)), 1.5);
}

TEST(GradeToEdges, PassesOverLinesMuchSmallerThanTheElements) {
  for (const double side : {0.2, 0.002}) {
    SCOPED_TRACE(side);
    const SurfaceMesh cavity =
        turned_over(moved(box_surface(Vec3(side, side, side), 1), Vec3(0.4, 0.4, 0.4)));
    const mesh::TetMesh body =
        mesh::tetrahedra::tetrahedralise(together(box_surface(Vec3(1, 1, 1), 1), cavity), {}).mesh;
    EXPECT_FALSE(mesh::inward_edges(body).empty());
    EXPECT_EQ(mesh::has_edges_to_grade(body), side > 0.1);
  }
}

TEST(GradeToEdges, LeavesConvexBodiesAlone) {
  const auto plate = families::mesh_family(shape_at(find_family("plate")), {}).mesh;
  EXPECT_FALSE(mesh::has_edges_to_grade(plate));
  EXPECT_TRUE(same_bytes(mesh::grade_to_edges(plate, 2), plate));
  EXPECT_TRUE(mesh::has_edges_to_grade(angle_bracket(1)));
  EXPECT_TRUE(same_bytes(mesh::grade_to_edges(angle_bracket(2), 0), angle_bracket(2)));
}

/// Slots so narrow that elements reach from one inward edge to the other are parted first.
RC_GTEST_PROP(GradeToEdges, NarrowSlotsAreParted, ()) {
  const double slot = 1e-3 * *rc::gen::inRange(1, 12), depth = 1e-3 * *rc::gen::inRange(5, 30);
  const double a = 0.02;
  mesh::MeshOptions options;
  options.order = *rc::gen::inRange(1, 4);
  options.element_size = 1e-3 * *rc::gen::inRange(6, 20);
  const auto body = prism({{0, 0},
                           {2 * a + slot, 0},
                           {2 * a + slot, 0.04},
                           {a + slot, 0.04},
                           {a + slot, 0.04 - depth},
                           {a, 0.04 - depth},
                           {a, 0.04},
                           {0, 0.04}},
                          1e-3 * *rc::gen::inRange(2, 20));
  expect_same_body(mesh::tetrahedra::tetrahedralise(body, options).mesh, *rc::gen::inRange(1, 4));
}

}  // namespace
}  // namespace carillon::test
