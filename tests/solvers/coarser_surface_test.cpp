// Coarser surfaces: closed bodies whose volume and shape are known.
#include "solvers/mesh/simplify/coarser_surface.hpp"

#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <cmath>
#include <map>
#include <numbers>
#include <set>

#include "core/error.hpp"
#include "tests/solvers/test_surfaces.hpp"

namespace carillon::solvers {
namespace {

using namespace test;  // NOLINT: bodies

constexpr double crease = 40 * std::numbers::pi / 180;

std::set<std::int32_t> used(const mesh::SurfaceMesh& mesh) {
  std::set<std::int32_t> vertices;
  for (const mesh::Triangle& t : mesh.triangles) vertices.insert(t.begin(), t.end());
  return vertices;
}

double longest_edge(const mesh::SurfaceMesh& mesh) {
  double longest = 0;
  for (const mesh::Triangle& t : mesh.triangles) {
    for (std::size_t k = 0; k < 3; ++k) {
      const auto at = [&](std::size_t i) { return mesh.vertices[static_cast<std::size_t>(t[i])]; };
      longest = std::max(longest, (at(k) - at((k + 1) % 3)).norm());
    }
  }
  return longest;
}

/// Every edge has one triangle on either side, and vertices - edges + faces is as it was.
void expect_closed(const mesh::SurfaceMesh& mesh, int euler) {
  std::map<std::pair<std::int32_t, std::int32_t>, int> edges;
  for (const mesh::Triangle& t : mesh.triangles) {
    for (std::size_t k = 0; k < 3; ++k) ++edges[{t[k], t[(k + 1) % 3]}];
  }
  for (const auto& [edge, count] : edges) {
    EXPECT_EQ(count, 1);
    EXPECT_TRUE(edges.contains({edge.second, edge.first}));
  }
  EXPECT_EQ(static_cast<int>(used(mesh).size()) - static_cast<int>(edges.size()) / 2 +
                static_cast<int>(mesh.triangles.size()),
            euler);
}

TEST(CoarserSurface, RoundBodiesKeepTheirShape) {
  const double pi = std::numbers::pi;
  const struct {
    mesh::SurfaceMesh mesh;
    double volume;
    int euler;
  } bodies[] = {{sphere_surface(0.1, 24), 4 * pi / 3 * 1e-3, 2},
                {torus_surface(0.1, 0.03, 60), 2 * pi * pi * 0.1 * 0.03 * 0.03, 0}};
  for (const auto& body : bodies) {
    const mesh::SurfaceMesh coarser = mesh::simplify::coarser_surface(body.mesh, 600, crease);
    EXPECT_LE(used(coarser).size(), 601);
    EXPECT_GE(used(coarser).size(), 595);
    expect_closed(coarser, body.euler);
    EXPECT_NEAR(mesh::signed_volume(coarser) / body.volume, 1, 0.05);  // facets within a round body
    // Its vertices are the body's own, evenly spread: no edge is long for so many of them.
    EXPECT_EQ(coarser.vertices, body.mesh.vertices);
    EXPECT_LT(longest_edge(coarser), 3 * std::sqrt(mesh::area(coarser) / 600));
  }
}

TEST(CoarserSurface, EdgesAndCornersStay) {
  const mesh::SurfaceMesh box = box_surface({0.3, 0.2, 0.01}, 16);
  for (const std::size_t vertices : {800, 400, 100}) {
    const mesh::SurfaceMesh coarser = mesh::simplify::coarser_surface(box, vertices, crease);
    EXPECT_LE(used(coarser).size(), vertices + 1);
    expect_closed(coarser, 2);
    EXPECT_NEAR(mesh::signed_volume(coarser), 0.3 * 0.2 * 0.01, 1e-12);
    EXPECT_NEAR(mesh::area(coarser), 2 * (0.3 * 0.2 + 0.3 * 0.01 + 0.2 * 0.01), 1e-9);
  }
}

TEST(CoarserSurface, AnyNumberOfVerticesAndUnusedOnes) {
  EXPECT_TRUE(rc::check("closed at every number", [] {
    mesh::SurfaceMesh tube = tube_surface(0.04, 0.005, 0.1, 20);
    tube.vertices.insert(tube.vertices.begin(), Vec3(9, 9, 9));
    for (mesh::Triangle& t : tube.triangles) {
      for (std::int32_t& v : t) ++v;
    }
    const auto wanted = *rc::gen::inRange<std::size_t>(40, 2 * tube.vertices.size());
    const mesh::SurfaceMesh coarser = mesh::simplify::coarser_surface(tube, wanted, crease);
    expect_closed(coarser, 0);
    RC_ASSERT(!used(coarser).contains(0));
    RC_ASSERT(mesh::signed_volume(coarser) > 0);
    if (wanted >= tube.vertices.size()) RC_ASSERT(used(coarser).size() == tube.vertices.size() - 1);
  }));
}

TEST(CoarserSurface, OpenSurfacesAreRefused) {
  mesh::SurfaceMesh open = box_surface({1, 1, 1}, 4);
  open.triangles.pop_back();
  EXPECT_THROW(mesh::simplify::coarser_surface(open, 10, crease), core::InputError);
}

}  // namespace
}  // namespace carillon::solvers
