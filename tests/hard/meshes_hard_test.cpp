// Surfaces as people export them: in few triangles, with holes, cavities and slots.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "../solvers/closed_forms.hpp"
#include "../solvers/prisms.hpp"
#include "../solvers/repaired.hpp"
#include "../solvers/test_meshes.hpp"
#include "hard_case.hpp"
#include "solvers/mesh/mesh_warnings.hpp"
#include "solvers/mesh/readers/read_mesh.hpp"
#include "solvers/mesh/tetrahedra/mesher.hpp"
#include "solvers/mesh/weld.hpp"

namespace carillon {
namespace {

using namespace test;

/// Steel of the references, which were solved by hexahedra of high order [Hz].
const solvers::elements::Elastic reference_steel{200e9, 0.29, 7850};

struct Made {
  solvers::mesh::MeshResult mesh;
  std::vector<double> hertz;
  std::vector<double> estimates;  ///< of their errors [cent]
};

/// A surface repaired, meshed and solved.
Made made(const solvers::mesh::SurfaceMesh& surface, const solvers::elements::Elastic& material,
          std::size_t count, double residual = 1e-8) {
  const Outcome outcome = repaired(surface);
  solvers::mesh::MeshOptions options;
  options.order = 3;
  Made result{solvers::mesh::tetrahedra::tetrahedralise(outcome.body, options), {}, {}};
  result.mesh.repair = outcome.report;
  const auto modes = lowest_modes(result.mesh.mesh, {material}, static_cast<int>(count));
  expect_sound(modes, residual);
  result.hertz = frequencies(modes);
  result.estimates = modes.pitch_errors;
  return result;
}

/// Estimates hold the true errors, but for `doubt` [cent] of the truth itself, and are no more than
/// 2.5 times as large.
void expect_true_estimates(const Made& body, const std::vector<double>& truth, double doubt) {
  for (std::size_t i = 0; i < truth.size(); ++i) {
    // Elements of the same body lie above the truth.
    const double error = std::max(0.0, 1200 * std::log2(body.hertz[i] / truth[i]));
    EXPECT_GT(body.estimates[i], 0.7 * (error - doubt)) << "mode " << i + 1 << ": " << error;
    EXPECT_LT(body.estimates[i], 2.5 * (error + doubt)) << "mode " << i + 1 << ": " << error;
  }
}

void expect_hertz(const std::vector<double>& found, const std::vector<double>& truth,
                  double tolerance) {
  ASSERT_GE(found.size(), truth.size());
  for (std::size_t i = 0; i < truth.size(); ++i)
    EXPECT_NEAR(found[i] / truth[i], 1, tolerance) << "mode " << i + 1;
}

/// Two prongs of 10 x 6 mm, 75 mm long and 1 mm apart, on a common end of 25 mm [m].
const std::vector<Vec2> slotted_bar = {{0, 0},     {0.1, 0},       {0.1, 0.021},  {0, 0.021},
                                       {0, 0.011}, {0.075, 0.011}, {0.075, 0.01}, {0, 0.01}};

/// Every triangle in four, `times` times.
solvers::mesh::SurfaceMesh refined(solvers::mesh::SurfaceMesh mesh, int times) {
  for (; times > 0; --times) {
    solvers::mesh::SurfaceMesh finer{mesh.vertices, {}};
    const auto middle = [&](std::int32_t a, std::int32_t b) {
      finer.vertices.push_back(0.5 * (mesh.vertices[static_cast<std::size_t>(a)] +
                                      mesh.vertices[static_cast<std::size_t>(b)]));
      return static_cast<std::int32_t>(finer.vertices.size()) - 1;
    };
    for (const auto& [a, b, c] : mesh.triangles) {
      const std::int32_t ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
      for (const auto& t : {std::array{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}})
        finer.triangles.push_back({t[0], t[1], t[2]});
    }
    solvers::mesh::weld(finer);
    mesh = std::move(finer);
  }
  return mesh;
}

/// A round rod whose axis runs up, around a half circle and up again: the two prongs of a fork [m].
solvers::mesh::SurfaceMesh bent_rod(double radius, double bend, double prong, int sides) {
  constexpr int prong_steps = 30, bend_steps = 60;
  solvers::mesh::readers::PolygonMesh rod;
  const auto ring = [&](const Vec3& centre, const Vec3& across) {
    for (int i = 0; i < sides; ++i) {
      const double angle = 2 * std::numbers::pi * i / sides;
      rod.vertices.emplace_back(
          centre + radius * (std::cos(angle) * across + std::sin(angle) * Vec3::UnitY()));
    }
  };
  for (int i = 0; i < prong_steps; ++i)
    ring(Vec3(-bend, 0, prong * (prong_steps - i) / prong_steps), -Vec3::UnitX());
  for (int i = 0; i <= bend_steps; ++i) {
    const double angle = std::numbers::pi * (1 + static_cast<double>(i) / bend_steps);
    const Vec3 outward(std::cos(angle), 0, std::sin(angle));
    ring(bend * outward, outward);
  }
  for (int i = 1; i <= prong_steps; ++i)
    ring(Vec3(bend, 0, prong * i / prong_steps), Vec3::UnitX());
  const auto rings = static_cast<std::int32_t>(rod.vertices.size()) / sides;
  for (std::int32_t i = 0; i < sides; ++i) rod.corners.push_back(i);
  rod.end_polygon();
  for (std::int32_t i = 0; i < sides; ++i) rod.corners.push_back(rings * sides - 1 - i);
  rod.end_polygon();
  for (std::int32_t r = 0; r + 1 < rings; ++r) {
    for (std::int32_t i = 0; i < sides; ++i) {
      const std::int32_t next = (i + 1) % sides;
      rod.corners.insert(rod.corners.end(), {r * sides + i, (r + 1) * sides + i,
                                             (r + 1) * sides + next, r * sides + next});
      rod.end_polygon();
    }
  }
  solvers::mesh::SurfaceMesh surface = solvers::mesh::readers::triangulate(std::move(rod));
  return solvers::mesh::signed_volume(surface) > 0 ? surface : turned_over(surface);
}

TEST(MeshesHard, ATumbler) {
  // Outside, a foot of 10 mm and a cone; inside, the same cone from the foot's height on.
  std::vector<std::array<double, 2>> profile = {{0, 0}, {0.03353, 0}};
  const auto wider = [](int i) { return 0.015008 * (i - 1) / 13; };
  for (int i = 1; i <= 14; ++i) profile.push_back({0.03353 + wider(i), 0.01 * i});
  for (int i = 14; i >= 1; --i) profile.push_back({0.027524 + wider(i), 0.01 * i});
  profile.push_back({0, 0.01});
  const Made glass = made(turned_surface(profile, 64), {56e9, 0.25, 2500}, 10);
  EXPECT_NEAR(2500 * glass.mesh.quality.volume, 0.5537, 2e-4);
  expect_hertz(glass.hertz,
               {2127.9, 2127.9, 5366.3, 5366.3, 5544.5, 5544.5, 8378.7, 8378.7, 9803.4, 9803.4},
               3e-3);
}

TEST(MeshesHard, AMarimbaBar) {
  std::vector<Vec2> outline = {{0.15, 0}, {0.15, 0.01915}, {-0.15, 0.01915}, {-0.15, 0}};
  for (int i = -30; i <= 30; ++i) {
    const double share = i / 30.0;
    outline.emplace_back(0.09466 * share, 0.012816 * (1 - std::pow(std::abs(share), 3)));
  }
  // E 17.96 GPa, G 6.75 GPa.
  const Made bar = made(prism(outline, 0.06), {17.96e9, 17.96 / (2 * 6.75) - 1, 837.19}, 5);
  expect_hertz(bar.hertz, {299.7, 815, 1198.5, 2197, 2968.6}, 3e-3);
}

TEST(MeshesHard, AForkOfABentRod) {
  // Its first mode lies far below what its elements could do: more is lost to rounding.
  const Made fork = made(bent_rod(0.00252071, 0.0075, 0.079, 20), {205e9, 0.28, 7850}, 6, 1e-7);
  const std::vector<double> truth = {437.31, 679.07, 2137.8, 2766.1, 2795.9, 3649.1};
  expect_hertz(fork.hertz, truth, 3e-3);
  expect_true_estimates(fork, truth, 1.7);
}

/// Of a plate of 100 x 60 x 5 mm.
const std::vector<double> plate_hertz = {2581.1, 2622.8, 5865.1, 6983.9, 7265.7, 8990.1};

TEST(MeshesHard, APlateOfTwelveTriangles) {
  const auto plate = prism({{0, 0}, {0.1, 0}, {0.1, 0.06}, {0, 0.06}}, 0.005);
  ASSERT_EQ(plate.triangles.size(), 12u);
  const Made body = made(plate, reference_steel, 6);
  EXPECT_NEAR(body.mesh.quality.volume, 3e-5, 1e-15);
  expect_hertz(body.hertz, plate_hertz, 1e-3);
}

TEST(MeshesHard, APlateInSquares) {
  const Made body = made(box_surface(Vec3(0.1, 0.06, 0.005), 8), reference_steel, 6);
  EXPECT_NEAR(body.mesh.quality.volume, 3e-5, 1e-15);
  expect_hertz(body.hertz, plate_hertz, 1e-3);
}

TEST(MeshesHard, ABarInInches) {
  const Vec3 sides(9.883, 1, 0.25);
  solvers::mesh::MeshFile file;
  file.unit = 0.0254;
  auto surface = box_surface(sides, 1);
  const double scale =
      solvers::mesh::readers::scale_to_metres(solvers::mesh::bounding_box(surface.vertices), file);
  for (Vec3& v : surface.vertices) v *= scale;
  const Made bar = made(surface, {68.9e9, 0.33, 2700}, 6);
  EXPECT_NEAR(bar.mesh.quality.volume, sides.prod() * std::pow(0.0254, 3), 1e-15);
  expect_hertz(bar.hertz, {522.3, 1435.4, 2020.5, 2753.1, 2801.6, 4604.5}, 2e-3);
}

TEST(MeshesHard, LayersThatShareAWall) {
  // Boxes of 20 and 30 mm on each other; their common wall is there once.
  solvers::mesh::SurfaceMesh layers =
      together(box_surface(Vec3(0.06, 0.04, 0.02), 1),
               moved(box_surface(Vec3(0.06, 0.04, 0.03), 1), Vec3(0, 0, 0.02)));
  solvers::mesh::weld(layers);
  std::vector<solvers::mesh::Triangle> kept;
  int walls = 0;
  for (const auto& t : layers.triangles) {
    const bool wall = std::all_of(t.begin(), t.end(), [&layers](std::int32_t v) {
      return layers.vertices[static_cast<std::size_t>(v)].z() == 0.02;
    });
    walls += wall ? 1 : 0;
    if (!wall || walls > 2) kept.push_back(t);
  }
  layers.triangles = kept;
  ASSERT_EQ(layers.triangles.size(), 22u);
  const Outcome outcome = repaired(layers);
  EXPECT_TRUE(says(outcome.report, "dropped 2 triangles of walls"));
  EXPECT_EQ(solvers::mesh::repair::diagnose(outcome.body).components, 1);
  EXPECT_NEAR(solvers::mesh::signed_volume(repaired(refined(layers, 2)).body), 1.2e-4, 1e-15);
  const Made body = made(layers, reference_steel, 6);
  EXPECT_NEAR(body.mesh.quality.volume, 0.06 * 0.04 * 0.05, 1e-15);
  expect_hertz(body.hertz, box_frequencies({0.06, 0.04, 0.05}, {9, 9, 9}, 200e9, 0.29, 7850, 6),
               1e-3);
}

TEST(MeshesHard, ADoubleSidedBox) {
  const auto box = box_surface(Vec3(0.05, 0.04, 0.03), 1);
  solvers::mesh::SurfaceMesh both = box;
  for (const auto& t : turned_over(box).triangles) both.triangles.push_back(t);
  const Made body = made(both, reference_steel, 6);
  EXPECT_TRUE(says(body.mesh.repair, "dropped 12 double triangles"));
  EXPECT_NEAR(body.mesh.quality.volume, 6e-5, 1e-15);
  expect_hertz(body.hertz, box_frequencies({0.05, 0.04, 0.03}, {9, 9, 9}, 200e9, 0.29, 7850, 6),
               1e-3);
}

TEST(MeshesHard, CubesThatTouch) {
  // 27 and 125 closed cubes in a grid are one.
  for (const int n : {3, 5}) {
    solvers::mesh::SurfaceMesh cubes;
    for (int x = 0; x < n; ++x)
      for (int y = 0; y < n; ++y)
        for (int z = 0; z < n; ++z)
          cubes =
              together(cubes, moved(box_surface(Vec3::Constant(0.01), 1), 0.01 * Vec3(x, y, z)));
    const Made body = made(cubes, reference_steel, 5);
    const double side = 0.01 * n;
    EXPECT_NEAR(body.mesh.quality.volume, std::pow(side, 3), 1e-9 * std::pow(side, 3));
    EXPECT_TRUE(solvers::mesh::mesh_warnings({}, body.mesh, 1).empty());
    expect_hertz(body.hertz, box_frequencies({side, side, side}, {9, 9, 9}, 200e9, 0.29, 7850, 2),
                 1e-3);
  }
}

TEST(MeshesHard, ASlotOfAMillimetre) {
  const std::vector<double> truth = {938.4, 1225.8, 3056.4, 4603.0, 5007.6, 7346.6};
  const auto bar = prism(slotted_bar, 0.006);
  const Made body = made(bar, reference_steel, 6);
  EXPECT_NEAR(body.mesh.quality.volume, 1.215e-5, 1e-14);
  expect_hertz(body.hertz, truth, 0.01);
  expect_true_estimates(body, truth, 1.7);
  // A hole over the whole width of the common end: closed, and the slot stays open.
  auto holed = refined(bar, 4);
  const std::size_t whole = holed.triangles.size();
  std::erase_if(holed.triangles, [&holed](const solvers::mesh::Triangle& t) {
    return std::all_of(t.begin(), t.end(), [&holed](std::int32_t v) {
      const Vec3& p = holed.vertices[static_cast<std::size_t>(v)];
      return p.x() > 0.09 && p.z() > 0.0059;
    });
  });
  ASSERT_LT(holed.triangles.size(), whole);
  const Made closed = made(holed, reference_steel, 6);
  EXPECT_TRUE(says(closed.mesh.repair, "filled 1 hole"));
  EXPECT_NEAR(closed.mesh.quality.volume, 1.215e-5, 1e-14);
  expect_hertz(closed.hertz, truth, 0.02);
}

TEST(MeshesHard, ACupWhoseCavityPokesOut) {
  const auto outer = prism({{0, 0}, {0.06, 0}, {0.06, 0.06}, {0, 0.06}}, 0.05);
  const auto inner = prism({{0.005, 0.005}, {0.055, 0.005}, {0.055, 0.055}, {0.005, 0.055}}, 0.047);
  const Made cup =
      made(together(outer, turned_over(moved(inner, Vec3(0, 0, 0.005)))), reference_steel, 4);
  EXPECT_NEAR(cup.mesh.quality.volume, 6.75e-5, 1e-13);
  // The reference is at most 0.5 % too high.
  expect_hertz(cup.hertz, {2710.4, 5143.0, 8242.1, 8242.1}, 6e-3);
}

TEST(MeshesHard, ACavityThatLooksOutward) {
  const auto box = box_surface(Vec3(0.1, 0.08, 0.06), 2);
  const auto inner = moved(box_surface(Vec3(0.093, 0.073, 0.053), 2), Vec3(3.5e-3, 3.5e-3, 3.5e-3));
  const double solid = 0.1 * 0.08 * 0.06, hollow = solid - 0.093 * 0.073 * 0.053;
  const Made hollow_box = made(together(box, turned_over(inner)), reference_steel, 3);
  EXPECT_NEAR(hollow_box.mesh.quality.volume, hollow, 1e-13);
  expect_hertz(hollow_box.hertz, {2992.7, 3953.4, 5175.2}, 6e-3);
  const solvers::mesh::MeshFile file;
  EXPECT_TRUE(mesh_warnings(file, hollow_box.mesh, 7850 * hollow).empty());

  // A core in the cavity is a body of its own, far higher.
  const auto core = moved(box_surface(Vec3::Constant(0.02), 1), Vec3(0.04, 0.03, 0.02));
  const Made with_core =
      made(together(together(box, turned_over(inner)), core), reference_steel, 3);
  EXPECT_NEAR(with_core.mesh.quality.volume, hollow + 8e-6, 1e-13);
  expect_hertz(with_core.hertz, {2992.7, 3953.4, 5175.2}, 6e-3);

  const Made filled = made(together(box, inner), reference_steel, 3);
  EXPECT_NEAR(filled.mesh.quality.volume, solid, 1e-13);
  const auto warnings = mesh_warnings(file, filled.mesh, 7850 * solid);
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_NE(warnings[0].find("3.768 kg"), std::string::npos) << warnings[0];
  EXPECT_NE(warnings[0].find("943.4 g"), std::string::npos) << warnings[0];
}

}  // namespace
}  // namespace carillon
