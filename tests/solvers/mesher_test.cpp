#include "solvers/mesh/tetrahedra/mesher.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "core/error.hpp"
#include "mesh_checks.hpp"
#include "solvers/elements/node_numbering.hpp"
#include "solvers/families/revolve.hpp"
#include "solvers/mesh/raise_order.hpp"
#include "solvers/mesh/readers/read_mesh.hpp"
#include "solvers/mesh/tetrahedra/detail/feature_lines.hpp"
#include "solvers/mesh/tetrahedra/detail/remesh.hpp"
#include "tests/solvers/test_surfaces.hpp"
#include "tests/solvers/written_files.hpp"

namespace carillon::test {
namespace {

using namespace solvers;
constexpr double pi = std::numbers::pi;

solvers::mesh::SurfaceMesh box_surface(const Vec3& sides) {
  solvers::mesh::SurfaceMesh box;
  for (int i = 0; i < 8; ++i)
    box.vertices.emplace_back(i & 1 ? sides.x() : 0, i & 2 ? sides.y() : 0, i & 4 ? sides.z() : 0);
  box.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                   {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  return box;
}

/// Section as a finely cut circle, turned: a ball for centre 0, a torus beyond.
solvers::families::ProfilePolygon round_section(double centre, double radius, int pieces) {
  solvers::families::ProfilePolygon section;
  const double from = centre > 0 ? 0 : -pi / 2, turn = centre > 0 ? 2 * pi : pi;
  for (int i = 0; i < pieces + (centre > 0 ? 0 : 1); ++i) {
    const double a = from + turn * i / pieces;
    section.push_back({centre + radius * std::cos(a), radius * std::sin(a)});
  }
  return solvers::families::checked_profile(section, "section");
}

/// Half of a hollow ball: a thin round bowl.
solvers::families::ProfilePolygon bowl_section(double radius, double wall, int pieces) {
  solvers::families::ProfilePolygon section;
  for (int i = 0; i <= pieces; ++i) {
    const double a = -pi / 2 + pi / 2 * i / pieces;
    section.push_back({radius * std::cos(a), radius * std::sin(a)});
  }
  for (int i = pieces; i >= 0; --i) {
    const double a = -pi / 2 + pi / 2 * i / pieces;
    section.push_back({(radius - wall) * std::cos(a), (radius - wall) * std::sin(a)});
  }
  return solvers::families::checked_profile(section, "section");
}

solvers::mesh::SurfaceMesh moved(solvers::mesh::SurfaceMesh surface, const Vec3& by) {
  for (auto& v : surface.vertices) v += by;
  return surface;
}

solvers::mesh::SurfaceMesh turned_inside_out(solvers::mesh::SurfaceMesh surface) {
  for (auto& t : surface.triangles) std::swap(t[1], t[2]);
  return surface;
}

solvers::mesh::SurfaceMesh joined(solvers::mesh::SurfaceMesh a,
                                  const solvers::mesh::SurfaceMesh& b) {
  const auto first = static_cast<std::int32_t>(a.vertices.size());
  a.vertices.insert(a.vertices.end(), b.vertices.begin(), b.vertices.end());
  for (solvers::mesh::Triangle t : b.triangles)
    a.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
  return a;
}

solvers::mesh::TetMesh mesh_of(const solvers::mesh::SurfaceMesh& surface, int order,
                               double element_size = 0) {
  solvers::mesh::MeshOptions options;
  options.order = order;
  options.element_size = element_size;
  auto result = solvers::mesh::tetrahedra::tetrahedralise(surface, options);
  EXPECT_LE(result.quality.straightened, result.quality.elements / 20);
  EXPECT_LT(std::abs(result.quality.volume_error), 1e-6);
  return std::move(result.mesh);
}

double volume_of(const solvers::mesh::TetMesh& mesh) {
  return solvers::mesh::measure_quality(mesh).volume;
}

TEST(NodeNumbering, SharesNodesOnVerticesEdgesAndFaces) {
  const solvers::mesh::TetMesh linear = mesh_of(box_surface({0.03, 0.02, 0.01}), 1);
  std::set<std::pair<int, int>> edges;
  std::set<std::array<int, 3>> faces;
  for (std::size_t e = 0; e < linear.element_count(); ++e) {
    std::array<int, 4> c{};
    std::copy_n(linear.element(e).begin(), 4, c.begin());
    std::sort(c.begin(), c.end());
    for (std::size_t i = 0; i < 4; ++i) {
      std::array<int, 3> face{};
      std::size_t k = 0;
      for (std::size_t j = 0; j < 4; ++j)
        if (j != i) face[k++] = c[j];
      faces.insert(face);
      for (std::size_t j = i + 1; j < 4; ++j) edges.insert({c[i], c[j]});
    }
  }
  for (int order = 1; order <= 4; ++order) {
    std::int64_t straightened = 0;
    const solvers::mesh::TetMesh mesh = solvers::mesh::curve_mesh(linear, order, {}, straightened);
    const auto p = static_cast<std::size_t>(order);
    const std::size_t inside_tetrahedron = p == 4 ? 1 : 0;
    EXPECT_EQ(mesh.nodes.size(), linear.nodes.size() + edges.size() * (p - 1) +
                                     faces.size() * (p - 1) * (p - 2) / 2 +
                                     linear.element_count() * inside_tetrahedron);
    // Straight nodes lie where the lattice says, whichever element numbered them first.
    const auto& lattice = solvers::elements::tetrahedron_lattice(order);
    double worst = 0;
    for (std::size_t e = 0; e < mesh.element_count(); ++e)
      for (std::size_t n = 0; n < lattice.size(); ++n) {
        Vec3 at = Vec3::Zero();
        for (std::size_t i = 0; i < 4; ++i)
          at +=
              lattice[n][i] * linear.nodes[static_cast<std::size_t>(linear.element(e)[i])] / order;
        worst =
            std::max(worst, (at - mesh.nodes[static_cast<std::size_t>(mesh.element(e)[n])]).norm());
      }
    EXPECT_LT(worst, 1e-16);
    EXPECT_EQ(mesh_faults(mesh), "");
    EXPECT_EQ(straightened, 0);
  }
}

TEST(Tetrahedralise, ABoxOfTwelveTrianglesKeepsEdgesAndCorners) {
  const Vec3 sides(0.1, 0.06, 0.02);
  const auto box = box_surface(sides);
  for (int order : {1, 2, 4}) {
    const auto mesh = mesh_of(box, order);
    EXPECT_EQ(mesh_faults(mesh), "");
    EXPECT_EQ(boundary_euler_number(mesh), 2);
    EXPECT_NEAR(volume_of(mesh), sides.prod(), 1e-12 * sides.prod());
    EXPECT_NEAR(boundary_area(mesh), 2 * (6e-3 + 2e-3 + 1.2e-3), 1e-12);
    for (const auto& corner : box.vertices) {
      double nearest = 1;
      for (const auto& node : mesh.nodes) nearest = std::min(nearest, (node - corner).norm());
      EXPECT_EQ(nearest, 0);
    }
    const auto quality = solvers::mesh::measure_quality(mesh);
    EXPECT_GT(quality.min_dihedral_deg, 8);
    EXPECT_GT(quality.elements, 200);
    EXPECT_LT(quality.elements, order == 1 ? 30000 : 6000);
  }
}

TEST(Tetrahedralise, ABallAndATorusFollowTheirSurface) {
  const auto ball = solvers::families::revolve(round_section(0, 0.05, 200), 0.003);
  const auto torus = solvers::families::revolve(round_section(0.04, 0.012, 200), 0.002);
  for (int order : {2, 3}) {
    const auto round = mesh_of(ball, order);
    EXPECT_EQ(mesh_faults(round), "");
    EXPECT_EQ(boundary_euler_number(round), 2);
    EXPECT_NEAR(volume_of(round) / solvers::mesh::signed_volume(ball), 1, 1e-6);
    EXPECT_LT(round.element_count(), 8000u);
    const auto ring = mesh_of(torus, order);
    EXPECT_EQ(mesh_faults(ring), "");
    EXPECT_EQ(boundary_euler_number(ring), 0);
    EXPECT_NEAR(volume_of(ring) / solvers::mesh::signed_volume(torus), 1, 1e-6);
    EXPECT_LT(ring.element_count(), 8000u);
    EXPECT_GT(solvers::mesh::measure_quality(ring).min_dihedral_deg, 4);
  }
}

TEST(Tetrahedralise, AThinBowlGetsOneLayerOfWideElements) {
  const double radius = 0.07, wall = 0.0025;
  const auto bowl = solvers::families::revolve(bowl_section(radius, wall, 100), 0.002);
  ASSERT_GT(bowl.triangles.size(), 20000u);
  const auto mesh = mesh_of(bowl, 2);
  EXPECT_EQ(mesh_faults(mesh), "");
  EXPECT_EQ(boundary_euler_number(mesh), 2);
  EXPECT_NEAR(volume_of(mesh) / solvers::mesh::signed_volume(bowl), 1, 1e-6);
  EXPECT_LT(mesh.element_count(), 8000u);
  // Edges are several walls long, and hardly a corner lies inside the wall.
  EXPECT_GT(longest_edge(mesh), 3 * wall);
  std::set<std::int32_t> corners;
  for (std::size_t e = 0; e < mesh.element_count(); ++e)
    corners.insert(mesh.element(e).begin(), mesh.element(e).begin() + 4);
  std::size_t inside = corners.size();
  for (std::int32_t n : boundary_nodes(mesh)) inside -= corners.count(n);
  EXPECT_LT(inside, corners.size() / 20);
  // Curved nodes stay on their own side of the wall.
  for (std::int32_t n : boundary_nodes(mesh)) {
    const Vec3& p = mesh.nodes[static_cast<std::size_t>(n)];
    if (p.z() > -1e-4) continue;  // the rim
    const double off = std::min(std::abs(p.norm() - radius), std::abs(p.norm() - radius + wall));
    EXPECT_LT(off, 0.1 * wall);
  }
}

TEST(Tetrahedralise, ACylinderKeepsItsRims) {
  const double radius = 0.03, height = 0.04;
  const auto cylinder = solvers::families::revolve(
      solvers::families::checked_profile({{0, 0}, {radius, 0}, {radius, height}, {0, height}}, ""),
      0.0015);
  const auto mesh = mesh_of(cylinder, 2);
  EXPECT_EQ(mesh_faults(mesh), "");
  // Both rims and faces survive: all of the area, and nodes of the rims on both neighbours.
  EXPECT_NEAR(boundary_area(mesh), 2 * pi * radius * (radius + height), 2e-3 * 0.0132);
  EXPECT_NEAR(volume_of(mesh) / solvers::mesh::signed_volume(cylinder), 1, 1e-6);
  std::size_t on_rim = 0;
  for (std::int32_t n : boundary_nodes(mesh)) {
    const Vec3& p = mesh.nodes[static_cast<std::size_t>(n)];
    on_rim += std::abs(p.head<2>().norm() - radius) < 1e-4 &&
              std::min(std::abs(p.z()), std::abs(p.z() - height)) < 1e-9;
  }
  EXPECT_GT(on_rim, 40u);
}

TEST(Tetrahedralise, CavitiesStayEmptyAndBodiesApart) {
  const auto outside = solvers::families::revolve(round_section(0, 0.05, 60), 0.006);
  const auto inside = solvers::families::revolve(round_section(0, 0.03, 60), 0.006);
  const auto hollow = joined(outside, turned_inside_out(inside));
  const auto shell = mesh_of(hollow, 2);
  EXPECT_EQ(mesh_faults(shell), "");
  EXPECT_EQ(boundary_euler_number(shell), 4);
  EXPECT_EQ(solvers::mesh::count_components(shell), 1);
  EXPECT_NEAR(volume_of(shell) / solvers::mesh::signed_volume(hollow), 1, 1e-6);

  // Two bodies, one of them inside the other's cavity.
  const auto kernel = solvers::families::revolve(round_section(0, 0.02, 60), 0.006);
  const auto three = joined(joined(hollow, kernel), moved(outside, {0.2, 0, 0}));
  const auto bodies = mesh_of(three, 2);
  EXPECT_EQ(mesh_faults(bodies), "");
  EXPECT_EQ(solvers::mesh::count_components(bodies), 3);
  EXPECT_NEAR(volume_of(bodies) / solvers::mesh::signed_volume(three), 1, 1e-6);
}

TEST(Tetrahedralise, SameSurfaceSameBytes) {
  const auto torus = solvers::families::revolve(round_section(0.04, 0.012, 80), 0.004);
  EXPECT_TRUE(same_bytes(mesh_of(torus, 2), mesh_of(torus, 2)));
}

TEST(Tetrahedralise, ElementSizeAndItsBound) {
  const auto box = box_surface({0.1, 0.06, 0.02});
  solvers::mesh::MeshOptions options;
  options.element_size = 0.01;
  const auto mesh = solvers::mesh::tetrahedra::tetrahedralise(box, options).mesh;
  EXPECT_LT(longest_edge(mesh), 1.5 * 0.01);
  EXPECT_GT(mesh.element_count(), 1000u);
  options.element_size = 0.0005;
  options.max_elements = 5000;
  const auto message = message_of<core::SolverError>(
      [&] { solvers::mesh::tetrahedra::tetrahedralise(box, options); });
  const auto at = message.find("element_size ");
  ASSERT_NE(at, std::string::npos) << message;
  options.element_size = std::stod(message.substr(at + 13));
  EXPECT_LE(solvers::mesh::tetrahedra::tetrahedralise(box, options).mesh.element_count(), 5000u);
}

TEST(Tetrahedralise, WhatIsNoBodyIsRefused) {
  auto open = box_surface({1, 1, 1});
  open.triangles.pop_back();
  EXPECT_THROW(solvers::mesh::tetrahedra::tetrahedralise(open, {}), core::InputError);
  EXPECT_THROW(
      solvers::mesh::tetrahedra::tetrahedralise(turned_inside_out(box_surface({1, 1, 1})), {}),
      core::InputError);
  EXPECT_THROW(solvers::mesh::tetrahedra::tetrahedralise({}, {}), core::InputError);
}

TEST(Elevate, StraightensWhatWouldFold) {
  solvers::mesh::TetMesh one;
  one.nodes = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 0.1}};
  one.elements = {0, 1, 2, 3};
  one.regions = {0};
  one.region_names = {"body"};
  std::int64_t straightened = -1;
  // The bottom's edges are to bow up through the top.
  const auto dented =
      solvers::mesh::curve_mesh(one, 2,
                                {[](const Vec3& p, const Vec3& normal) -> Vec3 {
                                   return normal.z() < 0 ? Vec3(p.x(), p.y(), 0.2) : p;
                                 },
                                 {}},
                                straightened);
  EXPECT_EQ(straightened, 1);
  EXPECT_EQ(mesh_faults(dented), "");
  // A projection that strays is not followed at all.
  const auto astray = solvers::mesh::curve_mesh(
      one, 3, {[](const Vec3& p, const Vec3&) -> Vec3 { return p + Vec3(5, 0, 0); }, {}},
      straightened);
  EXPECT_EQ(straightened, 0);
  EXPECT_NEAR(volume_of(astray), 0.1 / 6, 1e-15);
}

TEST(Elevate, ProjectionKeepsToItsSideOfAWall) {
  const auto sheet = box_surface({0.1, 0.1, 0.001});
  const solvers::mesh::tetrahedra::SurfaceSearch search(sheet);
  const solvers::mesh::tetrahedra::FeatureLines lines(sheet);
  const auto project = solvers::mesh::tetrahedra::projection_on(search, lines).to_surface;
  // Nearer to the underside, but the boundary there looks up.
  const Vec3 up = project({0.05, 0.05, 0.0002}, {0, 0, 1});
  EXPECT_NEAR((up - Vec3(0.05, 0.05, 0.001)).norm(), 0, 1e-15);
  const Vec3 down = project({0.05, 0.05, 0.0008}, {0, 0, -1});
  EXPECT_NEAR((down - Vec3(0.05, 0.05, 0)).norm(), 0, 1e-15);
}

TEST(Tetrahedralise, FlatElementsOfAPlateAreMended) {
  // Corners of both sides in rectangles: Gmsh leaves elements of 0.00 degrees between them.
  const auto plate = mesh_of(box_surface({0.1, 0.06, 0.005}), 1, 0.012);
  EXPECT_EQ(mesh_faults(plate), "");
  EXPECT_GT(solvers::mesh::measure_quality(plate).min_dihedral_deg, 8);
}

TEST(Remesh, FollowsSizesThatChange) {
  const auto box = box_surface({0.1, 0.1, 0.1});
  auto fine = solvers::mesh::tetrahedra::remesh(box, std::vector<double>(8, 0.01),
                                                std::vector<bool>(8, false),
                                                solvers::mesh::tetrahedra::SurfaceSearch(box));
  EXPECT_NEAR(solvers::mesh::signed_volume(fine), 1e-3, 1e-15);
  EXPECT_TRUE(solvers::mesh::tetrahedra::crossings(fine).empty());
  // Small at one end, large at the other: edges follow.
  const solvers::mesh::tetrahedra::SurfaceSearch search(fine);
  std::vector<double> sizes;
  for (const auto& v : fine.vertices) sizes.push_back(0.006 + 0.2 * v.x());
  const auto graded = solvers::mesh::tetrahedra::remesh(
      fine, sizes, std::vector<bool>(sizes.size(), false), search);
  EXPECT_NEAR(solvers::mesh::signed_volume(graded), 1e-3, 1e-12);
  EXPECT_TRUE(solvers::mesh::tetrahedra::crossings(graded).empty());
  double small = 0, large = 0;
  int few = 0, many = 0;
  for (const auto& t : graded.triangles)
    for (std::size_t i = 0; i < 3; ++i) {
      const Vec3& a = graded.vertices[static_cast<std::size_t>(t[i])];
      const Vec3& b = graded.vertices[static_cast<std::size_t>(t[(i + 1) % 3])];
      if (std::max(a.x(), b.x()) < 0.02) small += (a - b).norm(), ++many;
      if (std::min(a.x(), b.x()) > 0.06) large += (a - b).norm(), ++few;
    }
  ASSERT_GT(few, 0);
  ASSERT_GT(many, few);
  // Wanted: 0.006 to 0.01, and 0.018 to 0.026; edges may be a fifth shorter, and the smaller of an
  // edge's two ends decides.
  EXPECT_GT(small / many, 0.0048);
  EXPECT_LT(small / many, 0.01);
  EXPECT_GT(large / few, 0.0144);
  EXPECT_LT(large / few, 0.026);
}

TEST(Remesh, KeepsTheSidesOfAThinWallApart) {
  const auto bowl = test::bowl_surface(0.07, 0.001, 24);
  const solvers::mesh::tetrahedra::SurfaceSearch search(bowl);
  auto field = solvers::mesh::tetrahedra::measure_sizes(bowl, search);
  // Sizes that know nothing of how the wall bends.
  std::fill(field.radius.begin(), field.radius.end(), std::numeric_limits<double>::infinity());
  std::fill(field.thickness.begin(), field.thickness.end(), 1.0);
  const std::vector<double> sizes(bowl.vertices.size(), 0.03);
  const std::vector<bool> none(bowl.vertices.size(), false);
  const auto crossed = solvers::mesh::tetrahedra::remesh(bowl, sizes, none, search);
  ASSERT_FALSE(solvers::mesh::tetrahedra::crossings(crossed).empty());
  const auto apart = solvers::mesh::tetrahedra::remesh_apart(bowl, field, 0.03, 1, search);
  ASSERT_TRUE(apart);
  EXPECT_TRUE(solvers::mesh::tetrahedra::crossings(*apart).empty());
  EXPECT_LT(apart->triangles.size(), bowl.triangles.size());
}

TEST(Tetrahedralise, ScannedAndDesignedShapes) {
  const char* folder = std::getenv("CARILLON_TEST_DATA");
  if (folder == nullptr) GTEST_SKIP() << "set CARILLON_TEST_DATA to the folder of test data";
  for (const char* name : {"bell_english.obj", "dish_evo_bowl.obj", "fandisk.off", "joint.off",
                           "knot_tube.off", "spot_cow.obj", "ycb_scissors.obj"}) {
    SCOPED_TRACE(name);
    solvers::mesh::SurfaceMesh surface =
        solvers::mesh::readers::read_surface(std::string(folder) + "/meshes/clean/" + name);
    const double scale = 0.12 / solvers::mesh::bounding_box(surface.vertices).longest_side();
    for (auto& v : surface.vertices) v *= scale;
    const solvers::mesh::TetMesh mesh = mesh_of(surface, 2);
    EXPECT_EQ(mesh_faults(solvers::mesh::next_order(mesh)), "");
    EXPECT_EQ(mesh_faults(mesh), "");
    EXPECT_LT(mesh.element_count(), 12000u);
    EXPECT_NEAR(volume_of(mesh) / solvers::mesh::signed_volume(surface), 1, 1e-6);
  }
}

}  // namespace
}  // namespace carillon::test
