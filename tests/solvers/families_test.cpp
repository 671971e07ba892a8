#include "solvers/families/families.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <cmath>
#include <numbers>

#include "core/error.hpp"
#include "core/random.hpp"
#include "family_shapes.hpp"
#include "mesh_checks.hpp"
#include "solvers/families/detail/profile.hpp"
#include "solvers/mesh/tetrahedra/surface_search.hpp"
#include "tests/solvers/written_files.hpp"

namespace carillon::test {
namespace {

using namespace solvers;
constexpr double pi = std::numbers::pi;

TEST(Families, AreTwentyOneWithRanges) {
  std::string names;
  for (const auto& family : solvers::families::families()) {
    names += family.name + " ";
    EXPECT_FALSE(family.description.empty());
    for (const auto& p : family.parameters) {
      EXPECT_LT(0, p.low) << family.name << " " << p.name;
      EXPECT_LT(p.low, p.high) << family.name << " " << p.name;
    }
  }
  EXPECT_EQ(names,
            "bar block tile disc cylinder tube ring plate bowl cup vase bell box can bauble sphere "
            "pebble torus cone wrench turned ");
}

TEST(Families, AnUnknownOneNamesTheNearest) {
  EXPECT_NE(message_of<core::Error>([] { find_family("bowel"); }).find("did you mean \"bowl\""),
            std::string::npos);
  EXPECT_THROW(find_family(""), core::InputError);
}

TEST(Families, AWrongParameterSaysWhich) {
  auto shape = shape_at(find_family("tube"));
  shape.parameters["lenght"] = 0.1;
  EXPECT_NE(message_of<core::Error>([&] { mesh_of(shape, 1); }).find("did you mean \"length\""),
            std::string::npos);
  shape = shape_at(find_family("tube"));
  shape.parameters.erase("wall");
  EXPECT_NE(message_of<core::Error>([&] { mesh_of(shape, 1); }).find("wall is missing"),
            std::string::npos);
  for (double bad : {0.0, -0.01, std::nan(""), HUGE_VAL}) {
    shape.parameters["wall"] = bad;
    EXPECT_THROW(mesh_of(shape, 1), core::InputError) << bad;
  }
}

TEST(Families, ContradictionsAreRefusedWithTheirRule) {
  const auto refused = [](const std::string& family, const std::string& name, double value) {
    auto shape = shape_at(find_family(family));
    shape.parameters[name] = value;
    EXPECT_THROW(find_family(family).check(shape), core::InputError) << family << " " << name;
    EXPECT_THROW(mesh_of(shape, 2), core::InputError) << family << " " << name;
  };
  refused("tube", "wall", 0.05);
  refused("ring", "inner_radius", 0.2);
  refused("tile", "thickness", 0.3);
  refused("plate", "well_radius", 0.14);
  refused("plate", "height", 0.004);
  refused("bowl", "base_radius", 0.1);
  refused("bowl", "wall", 0.06);
  refused("cup", "wall", 0.02);
  refused("vase", "wall", 0.03);
  refused("vase", "neck_radius", 0.005);
  refused("bell", "shoulder_radius", 0.2);
  refused("bell", "lip_wall", 0.03);
  refused("wrench", "jaw_width", 0.06);
  refused("wrench", "length", 0.05);
  refused("sphere", "radius", -1);
  refused("box", "wall", 0.02);
  refused("bauble", "wall", 0.02);
  refused("can", "wall", 0.03);
  refused("pebble", "height", 0);
  refused("torus", "tube_radius", 0.06);
  refused("torus", "tube_radius", 0);
  refused("cone", "top_radius", 0.05);
  refused("cone", "top_radius", -0.001);
  refused("cone", "radius", 0);
}

TEST(Families, EveryMeshIsSoundAtEveryOrder) {
  const std::map<std::string, int> euler = {{"tube", 0}, {"ring", 0}, {"torus", 0},
                                            {"box", 4},  {"can", 4},  {"bauble", 4}};
  for (const auto& family : solvers::families::families())
    for (int order = 1; order <= 4; ++order) {
      SCOPED_TRACE(fmt::format("{} order {}", family.name, order));
      const auto shape = shape_at(family);
      family.check(shape);
      const auto result = mesh_of(shape, order);
      EXPECT_EQ(mesh_faults(result.mesh), "");
      EXPECT_EQ(result.mesh.order, order);
      EXPECT_EQ(boundary_euler_number(result.mesh),
                euler.count(family.name) ? euler.at(family.name) : 2);
      EXPECT_EQ(solvers::mesh::count_components(result.mesh), 1);
      EXPECT_EQ(result.quality.elements, static_cast<std::int64_t>(result.mesh.element_count()));
      EXPECT_LT(result.mesh.element_count(), order > 1 ? 5500u : 21000u);
      EXPECT_GT(result.mesh.element_count(), 100u);
    }
}

TEST(Families, SameShapeSameBytes) {
  for (const auto& family : solvers::families::families())
    for (int order : {2, 3}) {
      const auto shape = shape_at(family, 0.3);
      EXPECT_TRUE(same_bytes(mesh_of(shape, order).mesh, mesh_of(shape, order).mesh))
          << family.name;
    }
}

/// Triangles of order 4 are as wide as a handle: all three corners on its round end leave one flat.
TEST(Families, WrenchesHaveNoFlatCorners) {
  const auto& family = solvers::families::find_family("wrench");
  for (std::uint64_t seed = 0; seed < 80; ++seed) {
    core::RandomStream random(seed, 0, family.name);
    auto shape = shape_at(family);
    for (const auto& p : family.parameters)
      shape.parameters[p.name] = random.uniform(p.low, p.high);
    for (const int order : {3, 4}) {
      EXPECT_EQ(mesh_faults(mesh_of(shape, order).mesh), "") << "seed " << seed << " of " << order;
    }
  }
}

/// Least dihedral angle [degrees] of families that are swept, and of those that Gmsh fills.
double min_dihedral(const std::string& family) {
  return family == "turned" || family == "cone" ? 0.5 : 2.0;
}

TEST(Families, RandomParametersWithinTheRangesMesh) {
  EXPECT_TRUE(rc::check([] {
    const auto& family = solvers::families::families()[*rc::gen::inRange<std::size_t>(
        0, solvers::families::families().size())];
    const auto seed = *rc::gen::arbitrary<std::uint64_t>();
    const int order = *rc::gen::inRange(1, 5);
    core::RandomStream random(seed, 0, family.name);
    auto shape = shape_at(family);
    for (const auto& p : family.parameters)
      shape.parameters[p.name] = random.uniform(p.low, p.high);
    family.check(shape);
    RC_LOG() << family.name << " of order " << order;
    for (const auto& [name, value] : shape.parameters) RC_LOG() << ", " << name << " " << value;
    const auto made = mesh_of(shape, order);
    RC_ASSERT(mesh_faults(made.mesh) == "");
    // Elements of order 4 are so wide that the corners of a tight bend lie nearly in a plane.
    RC_ASSERT(made.quality.min_dihedral_deg > (order == 4 ? 0.5 : 1) * min_dihedral(family.name));
    RC_ASSERT(made.quality.elements < (order == 1 ? 25000 : 6000));
    RC_ASSERT(made.quality.straightened < made.quality.elements / 50 + 1);
  }));
}

TEST(Families, EveryCornerOfTheRangesMeshes) {
  for (const auto& family : solvers::families::families())
    for (unsigned corner = 0; corner < (1u << family.parameters.size()); ++corner) {
      auto shape = shape_at(family);
      for (std::size_t i = 0; i < family.parameters.size(); ++i)
        shape.parameters[family.parameters[i].name] =
            corner & (1u << i) ? family.parameters[i].high : family.parameters[i].low;
      SCOPED_TRACE(fmt::format("{} corner {:b}", family.name, corner));
      const auto made = mesh_of(shape, 2);
      EXPECT_EQ(mesh_faults(made.mesh), "");
      EXPECT_GT(made.quality.min_dihedral_deg, min_dihedral(family.name));
      EXPECT_LT(made.quality.elements, 6000);
    }
}

TEST(Box, IsExact) {
  for (int order = 1; order <= 4; ++order) {
    const auto result =
        mesh_of(shape_of("block", {{"length", 0.05}, {"width", 0.03}, {"height", 0.02}}), order);
    EXPECT_NEAR(result.quality.volume, 3e-5, 1e-12 * 3e-5);
    EXPECT_NEAR(boundary_area(result.mesh), 2 * (15e-4 + 10e-4 + 6e-4), 1e-15);
    for (std::int32_t n : boundary_nodes(result.mesh)) {
      const Vec3& p = result.mesh.nodes[static_cast<std::size_t>(n)];
      const double off =
          std::min({std::abs(std::abs(p.x()) - 0.025), std::abs(std::abs(p.y()) - 0.015),
                    std::abs(p.z()), std::abs(p.z() - 0.02)});
      EXPECT_LT(off, 1e-15);
    }
  }
}

/// Largest distance of a boundary node from the cylinders r = inner, outer and planes z = 0,
/// height.
double off_annulus(const solvers::mesh::TetMesh& mesh, double inner, double outer, double height) {
  double worst = 0;
  for (std::int32_t n : boundary_nodes(mesh)) {
    const Vec3& p = mesh.nodes[static_cast<std::size_t>(n)];
    const double r = p.head<2>().norm();
    worst = std::max(worst, std::min({std::abs(r - inner), std::abs(r - outer), std::abs(p.z()),
                                      std::abs(p.z() - height)}));
  }
  return worst;
}

TEST(RoundBodies, BoundaryNodesLieOnTheFormula) {
  for (int order = 1; order <= 4; ++order) {
    const auto tube =
        mesh_of(shape_of("tube", {{"radius", 0.04}, {"wall", 0.003}, {"length", 0.1}}), order);
    EXPECT_LT(off_annulus(tube.mesh, 0.037, 0.04, 0.1), 1e-15);
    const auto ring = mesh_of(
        shape_of("ring", {{"radius", 0.05}, {"inner_radius", 0.03}, {"height", 0.008}}), order);
    EXPECT_LT(off_annulus(ring.mesh, 0.03, 0.05, 0.008), 1e-15);
    const auto disc = mesh_of(shape_of("disc", {{"radius", 0.1}, {"thickness", 0.006}}), order);
    EXPECT_LT(off_annulus(disc.mesh, -1, 0.1, 0.006), 1e-15);
    const auto ball = mesh_of(shape_of("sphere", {{"radius", 0.05}}), order);
    const auto torus =
        mesh_of(shape_of("torus", {{"ring_radius", 0.05}, {"tube_radius", 0.01}}), order);
    for (std::int32_t n : boundary_nodes(torus.mesh)) {
      const Vec3& p = torus.mesh.nodes[static_cast<std::size_t>(n)];
      EXPECT_NEAR(std::hypot(p.head<2>().norm() - 0.05, p.z()), 0.01, 1e-15);
    }
    for (std::int32_t n : boundary_nodes(ball.mesh))
      EXPECT_NEAR(ball.mesh.nodes[static_cast<std::size_t>(n)].norm(), 0.05, 1e-15);
    EXPECT_EQ(ball.quality.straightened, 0);
  }
}

TEST(RoundBodies, VolumesConvergeAtTheRateOfTheOrder) {
  // Curved sides of order p leave out slivers of thickness h^(p+1); even orders gain one more.
  const auto tube = shape_of("tube", {{"radius", 0.03}, {"wall", 0.01}, {"length", 0.04}});
  const double tube_volume = pi * (9e-4 - 4e-4) * 0.04;
  const auto disc = shape_of("disc", {{"radius", 0.05}, {"thickness", 0.01}});
  const double disc_volume = pi * 25e-4 * 0.01;
  const auto ball = shape_of("sphere", {{"radius", 0.05}});
  const double ball_volume = 4 * pi / 3 * 1.25e-4;
  const auto torus = shape_of("torus", {{"ring_radius", 0.05}, {"tube_radius", 0.02}});
  const double torus_volume = 2 * pi * pi * 0.05 * 4e-4;
  for (const auto& [shape, exact, size] :
       {std::tuple{tube, tube_volume, 0.016}, std::tuple{disc, disc_volume, 0.03},
        std::tuple{ball, ball_volume, 0.032}, std::tuple{torus, torus_volume, 0.03}}) {
    const auto linear = volume_errors(shape, 1, size, exact);
    const auto quadratic = volume_errors(shape, 2, size, exact);
    EXPECT_GT(linear[0] / linear[1], 3) << shape.family;
    EXPECT_LT(linear[0] / linear[1], 8) << shape.family;
    EXPECT_GT(quadratic[0] / quadratic[1], 10) << shape.family;
    EXPECT_LT(quadratic[1], 2e-4) << shape.family;
    EXPECT_NEAR(mesh_of(shape, 4, size).quality.volume / exact, 1, 5e-5) << shape.family;
  }
  EXPECT_NEAR(boundary_area(mesh_of(ball, 3, 0.016).mesh), 4 * pi * 25e-4, 1e-4 * 4 * pi * 25e-4);
}

TEST(Shells, OneLayerOfWideElementsThroughAThinWall) {
  for (const char* name : {"tube", "plate", "bowl", "cup", "vase", "bell", "disc", "tile"})
    for (int order : {2, 3, 4}) {
      const auto mesh = mesh_of(shape_at(find_family(name), 0.3), order).mesh;
      // With one layer every corner is on the boundary.
      std::vector<bool> on_boundary(mesh.nodes.size(), false);
      for (std::int32_t n : mesh.faces) on_boundary[static_cast<std::size_t>(n)] = true;
      std::size_t inside = 0;
      for (std::size_t e = 0; e < mesh.element_count(); ++e)
        for (std::size_t i = 0; i < 4; ++i)
          inside += !on_boundary[static_cast<std::size_t>(mesh.element(e)[i])];
      EXPECT_EQ(inside, 0u) << name << " order " << order;
    }
}

TEST(Shells, TheWallIsAsThickAsItSays) {
  for (const char* name : {"plate", "bowl", "cup", "vase"}) {
    const auto shape = shape_at(find_family(name));
    const double wall = shape.parameters.at("wall");
    const auto mesh = mesh_of(shape, 1, 0.006).mesh;
    solvers::mesh::SurfaceMesh surface;
    surface.vertices = mesh.nodes;
    for (std::size_t f = 0; f < mesh.faces.size(); f += 3)
      surface.triangles.push_back({mesh.faces[f], mesh.faces[f + 1], mesh.faces[f + 2]});
    const solvers::mesh::tetrahedra::SurfaceSearch search(surface);
    std::size_t right = 0;
    for (std::size_t t = 0; t < surface.triangles.size(); ++t)
      right += std::abs(search.thickness_below(t) / wall - 1) < 0.06;
    // The rim's own faces look along the wall, not through it.
    EXPECT_GT(static_cast<double>(right) / static_cast<double>(surface.triangles.size()), 0.9)
        << name;
  }
}

TEST(Shells, ACupHasThePappusVolume) {
  // A wall w laid half to each side of a line: 2 pi w times the integral of r ds, and where the
  // line bends by k ds about a normal n, 2 pi w^3/12 times the integral of k n_r ds on top, which
  // is what the tangent loses of its radial part.
  solvers::families::Profile profile;
  profile.rounded({{0, 0.002}, {0.03, 0.002}, {0.04, 0.1}}, 0.35);
  const double wall = 0.004;
  double swept = 0;
  constexpr int steps = 20000;
  for (int i = 0; i < steps; ++i) {
    const double s = (i + 0.5) * profile.length() / steps;
    swept += profile.point(s).at.x() * profile.length() / steps;
  }
  const double bends = 1 - profile.point(profile.length()).tangent.x();
  const double exact = 2 * pi * (swept * wall + bends * std::pow(wall, 3) / 12);
  const auto cup = mesh_of(
      shape_of("cup",
               {{"radius", 0.042}, {"bottom_radius", 0.032}, {"height", 0.1}, {"wall", wall}}),
      3);
  EXPECT_NEAR(cup.quality.volume / exact, 1, 5e-5);
}

/// Elements across the place where the wall begins to swell would miss it at every order.
TEST(Shells, ABellsElementsEndWhereItsWallSwells) {
  const auto bell = shape_of("bell", {{"radius", 0.0525},
                                      {"shoulder_radius", 0.038},
                                      {"height", 0.11},
                                      {"wall", 0.003},
                                      {"lip_wall", 0.009}});
  const double fine = mesh_of(bell, 4, 0.008).quality.volume;
  for (const double size : {0.018, 0.022, 0.027})
    EXPECT_NEAR(mesh_of(bell, 4, size).quality.volume / fine, 1, 2e-6) << size;
}

TEST(Wrench, HasTheAreaOfItsOutline) {
  // Round head less slot, neck with fillets, handle and round end, by lines and circles.
  const double head = 0.025, jaw = 0.01, handle = 0.0085, length = 0.2, thickness = 0.006;
  const double fillet = head / 2, reach = head + fillet;
  const double x = -std::sqrt(reach * reach - std::pow(handle + fillet, 2));
  const double angle = std::atan2(handle + fillet, x);  // of the touching point
  // Above the x axis: the head's sector from the jaw's tip to the fillet, less what the slot takes
  // of it: a triangle under the tip, and a quarter of its round end.
  double half = 0.5 * head * head * (angle - std::asin(jaw / head));
  half -= 0.5 * jaw * std::sqrt(head * head - jaw * jaw) + pi / 4 * jaw * jaw;
  // The triangle from the head's centre to the fillet's, less the fillet's sector.
  half += 0.5 * -x * (handle + fillet) - 0.5 * fillet * fillet * (angle - pi / 2);
  half += handle * (length - head - handle + x) + pi / 4 * handle * handle;
  const auto wrench = mesh_of(shape_of("wrench", {{"length", length},
                                                  {"handle_width", 2 * handle},
                                                  {"head_radius", head},
                                                  {"jaw_width", 2 * jaw},
                                                  {"thickness", thickness}}),
                              4);
  EXPECT_NEAR(wrench.quality.volume / (2 * half * thickness), 1, 1e-7);
}

TEST(ElementBound, NamesASizeThatFits) {
  for (const auto& family : solvers::families::families()) {
    const auto shape = shape_at(family);
    MeshOptions options;
    options.order = 1;
    options.element_size = 0.002;
    options.max_elements = 4000;
    const auto message =
        message_of<core::Error>([&] { solvers::families::mesh_family(shape, options); });
    const auto at = message.find("element_size ");
    ASSERT_NE(at, std::string::npos) << family.name << ": " << message;
    options.element_size = std::stod(message.substr(at + 13));
    EXPECT_LE(solvers::families::mesh_family(shape, options).mesh.element_count(), 4200u)
        << family.name;
  }
  MeshOptions impossible;
  impossible.max_elements = 5;
  EXPECT_THROW(solvers::families::mesh_family(shape_at(find_family("tube")), impossible),
               core::SolverError);
}

TEST(ElementSize, IsTheLongestEdge) {
  for (const char* name : {"bar", "block", "tile", "disc", "tube", "ring", "cup", "bowl"}) {
    const auto mesh = mesh_of(shape_at(find_family(name)), 1, 0.012).mesh;
    EXPECT_LT(longest_edge(mesh), 1.1 * 0.012) << name;
    EXPECT_GT(longest_edge(mesh), 0.5 * 0.012) << name;
  }
  // Inside a solid that Gmsh fills, edges grow beyond those of the surface.
  const auto ball = mesh_of(shape_at(find_family("sphere")), 1, 0.012).mesh;
  EXPECT_LT(longest_edge(ball), 1.8 * 0.012);
}

}  // namespace
}  // namespace carillon::test
