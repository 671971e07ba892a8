#include <gtest/gtest.h>

#include <Eigen/QR>
#include <cmath>
#include <numbers>

#include "core/random.hpp"
#include "render/maps/detail/displaced_mesh.hpp"
#include "render/maps/generated_maps.hpp"

namespace carillon::solvers {
namespace {

using Eigen::Vector2d;

render::maps::SurfaceMap random_normals(int width, int height, bool repeats) {
  core::RandomStream random(4, 0, "test");
  render::maps::SurfaceMap map{"random", width, height, 0.3, repeats, {}, {}, {}};
  for (int i = 0; i < width * height; ++i) {
    map.slopes_u.push_back(float(random.normal()));
    map.slopes_v.push_back(float(random.normal()));
  }
  return map;
}

// Least squares over all control points by a dense solver, on a grid fine enough to stand for the
// integral (Gauss's three points in every texel are exact for these splines' squares to a
// thousandth; four are used).
TEST(IntegratedRelief, IsNearestInTheMeanSquare) {
  const render::maps::SurfaceMap normals = random_normals(6, 5, true);
  const double points[] = {-0.861136311594053, -0.339981043584856, 0.339981043584856,
                           0.861136311594053};
  const double weights[] = {0.347854845137454, 0.652145154862546, 0.652145154862546,
                            0.347854845137454};
  Eigen::MatrixXd basis(2 * 30 * 16, 30);
  Eigen::VectorXd target(basis.rows());
  render::maps::SurfaceMap unit{"unit", 6, 5, 0.3, true, std::vector<float>(30), {}, {}};
  for (int texel = 0; texel < 30; ++texel) {
    unit.heights.assign(30, 0);
    unit.heights[std::size_t(texel)] = 1;
    Eigen::Index row = 0;
    for (int cell = 0; cell < 30; ++cell) {
      for (int p = 0; p < 16; ++p, row += 2) {
        // Pieces of the spline end at the texels' centres.
        const Vector2d uv((cell % 6 + 1 + points[p % 4] / 2) * 0.3,
                          (cell / 6 + 1 + points[p / 4] / 2) * 0.3);
        const double weight = std::sqrt(weights[p % 4] * weights[p / 4]);
        basis.block<2, 1>(row, texel) = weight * render::maps::slope_at(unit, uv);
        target.segment<2>(row) = weight * render::maps::slope_at(normals, uv);
      }
    }
  }
  Eigen::VectorXd expected = basis.completeOrthogonalDecomposition().solve(target);
  expected.array() -= expected.maxCoeff();
  const render::maps::SurfaceMap relief = render::maps::integrated_relief(normals);
  for (int texel = 0; texel < 30; ++texel) {
    EXPECT_NEAR(relief.heights[std::size_t(texel)], expected[texel], 1e-6);
  }
}

TEST(IntegratedRelief, WithoutRepetitionIsThatOfTheMirroredMap) {
  const render::maps::SurfaceMap normals = random_normals(5, 7, false);
  render::maps::SurfaceMap mirrored{"mirrored", 10, 14, 0.3, true, {}, {}, {}};
  for (int j = 0; j < 14; ++j) {
    for (int i = 0; i < 10; ++i) {
      const bool left = i >= 5, up = j >= 7;
      const std::size_t texel = std::size_t((up ? 13 - j : j) * 5 + (left ? 9 - i : i));
      mirrored.slopes_u.push_back(left ? -normals.slopes_u[texel] : normals.slopes_u[texel]);
      mirrored.slopes_v.push_back(up ? -normals.slopes_v[texel] : normals.slopes_v[texel]);
    }
  }
  const render::maps::SurfaceMap expected = render::maps::integrated_relief(mirrored);
  const render::maps::SurfaceMap relief = render::maps::integrated_relief(normals);
  for (int j = 0; j < 7; ++j) {
    for (int i = 0; i < 5; ++i) {
      EXPECT_NEAR(relief.heights[std::size_t(j * 5 + i)], expected.heights[std::size_t(j * 10 + i)],
                  1e-6);
    }
  }
}

TEST(IntegratedRelief, GivesASmoothReliefBack) {
  for (const bool repeats : {true, false}) {
    render::maps::SurfaceMap relief{"waves", 64, 48, 0.001, repeats, {}, {}, {}};
    for (int j = 0; j < 48; ++j) {
      for (int i = 0; i < 64; ++i) {
        // Cosines about the texels' centres: even at the edges, so that both ways of going on fit.
        const double x = std::numbers::pi * (i + 0.5) / 64, y = std::numbers::pi * (j + 0.5) / 48;
        relief.heights.push_back(
            float(0.002 * (std::cos(2 * x) * std::cos(4 * y) + std::cos(2 * y) - 2)));
      }
    }
    const render::maps::SurfaceMap back =
        render::maps::integrated_relief(render::maps::normal_map_of(relief));
    EXPECT_EQ(back.repeats, repeats);
    const float top = *std::max_element(relief.heights.begin(), relief.heights.end());
    for (std::size_t i = 0; i < relief.heights.size(); ++i) {
      EXPECT_NEAR(back.heights[i], relief.heights[i] - top, 0.008 * 0.008);
    }
  }
}

TEST(DisplacedMesh, LiesOnTheReliefAndLooksOutward) {
  render::maps::TexturedFace face;
  face.map = std::make_shared<const render::maps::SurfaceMap>(
      render::maps::generate_map("pebbles", {}, 128, 2));
  face.origin = {1, 2, 3};
  face.u = Vec3(1, 1, 0).normalized();
  face.v = Vec3(0, 0, 1);
  face.size = {0.3, 0.2};
  const mesh::SurfaceMesh mesh = render::maps::displaced_mesh(face, 60, 40);
  ASSERT_EQ(mesh.vertices.size(), 61u * 41u);
  ASSERT_EQ(mesh.triangles.size(), 2u * 60u * 40u);
  for (const Vec3& vertex : mesh.vertices) {
    const Vec3 off = vertex - face.origin;
    const Vector2d uv(off.dot(face.u), off.dot(face.v));
    EXPECT_NEAR(off.dot(face.normal()), render::maps::height_at(*face.map, uv), 1e-12);
  }
  EXPECT_LT(
      (mesh.vertices.back() - (face.origin + 0.3 * face.u + 0.2 * face.v +
                               render::maps::height_at(*face.map, {0.3, 0.2}) * face.normal()))
          .norm(),
      1e-12);
  double projected = 0;
  for (const auto& [a, b, c] : mesh.triangles) {
    const auto at = [&](int i) { return mesh.vertices[std::size_t(i)]; };
    projected += (at(b) - at(a)).cross(at(c) - at(a)).dot(face.normal()) / 2;
  }
  EXPECT_NEAR(projected, 0.06, 1e-12);
  EXPECT_GT(mesh::area(mesh), 0.065);
  EXPECT_EQ(render::maps::displaced_mesh(face, 265, 249).vertices.size(), 66500u);
}

}  // namespace
}  // namespace carillon::solvers
