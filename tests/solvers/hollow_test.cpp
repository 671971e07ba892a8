// Solid bodies and their hollow twins: volumes and surfaces in closed form, and alike outside.
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "family_shapes.hpp"
#include "mesh_checks.hpp"
#include "solvers/families/detail/cube_grid.hpp"

namespace carillon::test {
namespace {

using namespace solvers;
constexpr double pi = std::numbers::pi;

GeneratedShape sided(const std::string& family, double x, double y, double z, double wall = 0) {
  auto shape = shape_of(family, {{"length", x}, {"width", y}, {"height", z}});
  if (wall > 0) shape.parameters["wall"] = wall;
  return shape;
}

TEST(CubeGrid, IsAClosedSurfaceOfTheCube) {
  const solvers::families::PlanarGrid grid = solvers::families::cube_grid({3, 4, 5});
  EXPECT_EQ(solvers::families::cube_cells({3, 4, 5}), 2 * (12 + 20 + 15));
  EXPECT_EQ(static_cast<std::int64_t>(grid.triangles.size()),
            2 * solvers::families::cube_cells({3, 4, 5}));
  // Euler: vertices - edges + triangles = 2, and three edges for two triangles.
  EXPECT_EQ(grid.vertices, 2 + static_cast<std::int32_t>(grid.triangles.size()) / 2);
  double volume = 0;  // by the theorem of Gauss: outward everywhere, or the sum is not 8
  for (std::size_t t = 0; t < grid.triangles.size(); ++t) {
    Eigen::Matrix3d corners;
    for (int k = 0; k < 3; ++k)
      corners.col(k) = solvers::families::on_cube(grid.point(t, Eigen::Vector3d::Unit(k)));
    const Eigen::RowVector3d reach = corners.cwiseAbs().colwise().maxCoeff();
    EXPECT_EQ(reach, Eigen::RowVector3d::Ones());
    volume += corners.determinant() / 6;
  }
  EXPECT_NEAR(volume, 8, 1e-12);
}

TEST(HollowBox, IsExact) {
  const double x = 0.08, y = 0.05, z = 0.04, w = 0.003;
  const double inside = (x - 2 * w) * (y - 2 * w) * (z - 2 * w);
  const auto faces = [](double a, double b, double c) { return 2 * (a * b + b * c + c * a); };
  for (int order = 1; order <= 4; ++order) {
    const auto box = mesh_of(sided("box", x, y, z, w), order);
    EXPECT_NEAR(box.quality.volume / (x * y * z - inside), 1, 1e-12);
    const double area = faces(x, y, z) + faces(x - 2 * w, y - 2 * w, z - 2 * w);
    EXPECT_NEAR(boundary_area(box.mesh) / area, 1, 1e-12);
    for (std::int32_t n : boundary_nodes(box.mesh)) {
      // How far within the block, at the nearest of its six faces.
      const Vec3& p = box.mesh.nodes[static_cast<std::size_t>(n)];
      const double depth = std::min(
          {x / 2 - std::abs(p.x()), y / 2 - std::abs(p.y()), z / 2 - std::abs(p.z() - z / 2)});
      EXPECT_LT(std::min(std::abs(depth), std::abs(depth - w)), 1e-15);
    }
  }
}

TEST(HollowBodies, HaveTheVolumesOfTheirFormulas) {
  const double r = 0.03, h = 0.08, w = 0.003;
  const double a = 0.045, b = 0.03, c = 0.025;
  const auto ellipsoid = [](double i, double j, double k) { return 4 * pi / 3 * i * j * k; };
  const auto cylinder = [](double radius, double height) { return pi * radius * radius * height; };
  for (const auto& [shape, exact] :
       {std::pair{shape_of("cylinder", {{"radius", r}, {"length", h}}), cylinder(r, h)},
        std::pair{shape_of("can", {{"radius", r}, {"length", h}, {"wall", w}}),
                  cylinder(r, h) - cylinder(r - w, h - 2 * w)},
        std::pair{sided("pebble", 2 * a, 2 * b, 2 * c), ellipsoid(a, b, c)},
        std::pair{sided("bauble", 2 * a, 2 * b, 2 * c, w),
                  ellipsoid(a, b, c) - ellipsoid(a - w, b - w, c - w)}}) {
    EXPECT_NEAR(mesh_of(shape, 2).quality.volume / exact, 1, 3e-3) << shape.family;
    EXPECT_NEAR(mesh_of(shape, 3).quality.volume / exact, 1, 1e-3) << shape.family;
    EXPECT_NEAR(mesh_of(shape, 3, 0.008).quality.volume / exact, 1, 5e-5) << shape.family;
  }
}

TEST(HollowCan, OfAThinWallKeepsItsVolumeAtEveryOrder) {
  const double r = 0.133, h = 0.4, w = 0.004;
  const double exact = pi * (r * r * h - (r - w) * (r - w) * (h - 2 * w));
  for (int order = 2; order <= 4; ++order) {
    const auto can = mesh_of(shape_of("can", {{"radius", r}, {"length", h}, {"wall", w}}), order);
    EXPECT_EQ(can.quality.straightened, 0) << order;
    EXPECT_NEAR(can.quality.volume / exact, 1, 1e-4) << order;
    EXPECT_LT(can.quality.elements, 5500) << order;
  }
}

/// Farthest boundary node of the mesh from both of two surfaces given by functions that are 1 on
/// them.
template <class Outer, class Inner>
double off(const solvers::mesh::TetMesh& mesh, const Outer& outer, const Inner& inner) {
  double worst = 0;
  for (std::int32_t n : boundary_nodes(mesh)) {
    const Vec3& p = mesh.nodes[static_cast<std::size_t>(n)];
    worst = std::max(worst, std::min(std::abs(outer(p) - 1), std::abs(inner(p) - 1)));
  }
  return worst;
}

TEST(HollowBodies, TwinsHaveTheSameSkin) {
  const Vec3 half(0.045, 0.03, 0.025);
  const auto skin = [](const Vec3& axes) {
    return [axes](const Vec3& p) { return p.cwiseQuotient(axes).norm(); };
  };
  for (int order = 1; order <= 4; ++order) {
    const auto bauble = mesh_of(sided("bauble", 0.09, 0.06, 0.05, 0.002), order).mesh;
    EXPECT_LT(off(bauble, skin(half), skin(half.array() - 0.002)), 1e-12);
    const auto pebble = mesh_of(sided("pebble", 0.09, 0.06, 0.05), order).mesh;
    EXPECT_LT(off(pebble, skin(half), skin(half)), 1e-12);
    const auto skin_of_cylinder = [](double r, double low, double high) {
      return [=](const Vec3& p) {
        return std::max(p.head<2>().norm() / r, std::abs(2 * p.z() - low - high) / (high - low));
      };
    };
    const auto can =
        mesh_of(shape_of("can", {{"radius", 0.03}, {"length", 0.08}, {"wall", 0.002}}), order);
    EXPECT_EQ(can.quality.straightened, 0);
    EXPECT_LT(off(can.mesh, skin_of_cylinder(0.03, 0, 0.08), skin_of_cylinder(0.028, 0.002, 0.078)),
              1e-12);
    const auto rod = mesh_of(shape_of("cylinder", {{"radius", 0.03}, {"length", 0.08}}), order);
    const auto whole = skin_of_cylinder(0.03, 0, 0.08);
    EXPECT_LT(off(rod.mesh, whole, whole), 1e-12);
  }
}

}  // namespace
}  // namespace carillon::test
