// One shape keeps its signature wherever it lies and however it is written; others have another.
#include "solvers/mesh/shape_signature.hpp"

#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <random>

#include "test_surfaces.hpp"

namespace carillon {
namespace {

using namespace solvers;

/// Bodies with distinct, double and threefold principal axes.
std::vector<test::SurfaceMesh> bodies() {
  return {test::box_surface({0.02, 0.03, 0.05}, 2),
          test::box_surface({0.03, 0.03, 0.03}, 3),  // a cube
          test::sphere_surface(0.1, 6),              // no axes at all
          test::tube_surface(0.02, 0.004, 0.1, 24),  // one axis
          test::bowl_surface(0.06, 0.004, 24),
          test::torus_surface(0.05, 0.01, 20),
          test::together(test::box_surface({0.02, 0.03, 0.05}, 1),
                         test::moved(test::box_surface({0.01, 0.01, 0.07}, 1), {0.02, 0.01, 0.0}))};
}

double uniform(std::mt19937_64& random, double low, double high) {
  return std::uniform_real_distribution<double>(low, high)(random);
}

/// Turned, moved and scaled at random, its vertices and triangles in another order, a fraction of
/// the corners with a vertex of their own, faces turned over, vertices that nobody uses.
test::SurfaceMesh written_otherwise(const test::SurfaceMesh& mesh, std::mt19937_64& random,
                                    bool mirrored) {
  Eigen::Quaterniond turn(uniform(random, -1, 1), uniform(random, -1, 1), uniform(random, -1, 1),
                          uniform(random, -1, 1));
  turn.normalize();
  const double scale = std::exp(uniform(random, -7, 7));
  const Vec3 by = scale * solvers::mesh::bounding_box(mesh.vertices).longest_side() *
                  Vec3(uniform(random, -1, 1), uniform(random, -1, 1), 1);
  std::vector<std::int32_t> place(mesh.vertices.size());
  for (std::size_t i = 0; i < place.size(); ++i) place[i] = static_cast<std::int32_t>(i);
  std::shuffle(place.begin(), place.end(), random);
  test::SurfaceMesh other;
  other.vertices.resize(mesh.vertices.size());
  for (std::size_t i = 0; i < place.size(); ++i) {
    Vec3 at = mesh.vertices[i];
    if (mirrored) at.x() = -at.x();
    other.vertices[static_cast<std::size_t>(place[i])] = turn * (scale * at) + by;
  }
  for (solvers::mesh::Triangle t : mesh.triangles) {
    for (std::int32_t& corner : t) {
      corner = place[static_cast<std::size_t>(corner)];
      if (uniform(random, 0, 1) < 0.3) {
        other.vertices.push_back(other.vertices[static_cast<std::size_t>(corner)]);
        corner = static_cast<std::int32_t>(other.vertices.size() - 1);
      }
    }
    std::rotate(t.begin(), t.begin() + static_cast<int>(uniform(random, 0, 2.99)), t.end());
    if (uniform(random, 0, 1) < 0.2) std::swap(t[0], t[1]);
    other.triangles.push_back(t);
    if (uniform(random, 0, 1) < 0.1) other.triangles.push_back(t);
  }
  other.vertices.push_back(by + Vec3::Constant(100 * scale));
  std::shuffle(other.triangles.begin(), other.triangles.end(), random);
  return other;
}

TEST(ShapeSignature, is_that_of_the_shape_alone) {
  const auto all = bodies();
  rc::check([&] {
    std::mt19937_64 random(*rc::gen::arbitrary<std::uint64_t>());
    const test::SurfaceMesh& mesh = all[*rc::gen::inRange<std::size_t>(0, all.size())];
    const test::SurfaceMesh other = written_otherwise(mesh, random, *rc::gen::arbitrary<bool>());
    RC_ASSERT(solvers::mesh::signature_difference(solvers::mesh::shape_signature(mesh),
                                                  solvers::mesh::shape_signature(other)) < 1e-9);
  });
}

TEST(ShapeSignature, survives_six_digits_and_single_precision) {
  std::mt19937_64 random(7);
  for (const test::SurfaceMesh& mesh : bodies()) {
    test::SurfaceMesh text = written_otherwise(mesh, random, false), single = text;
    for (Vec3& v : text.vertices) {
      for (double& x : v) {
        char digits[32];
        std::snprintf(digits, sizeof digits, "%.6g", x);
        x = std::stod(digits);
      }
    }
    for (Vec3& v : single.vertices) v = v.cast<float>().cast<double>();
    EXPECT_LT(solvers::mesh::signature_difference(solvers::mesh::shape_signature(mesh),
                                                  solvers::mesh::shape_signature(text)),
              solvers::mesh::same_shape_tolerance);
    EXPECT_LT(solvers::mesh::signature_difference(solvers::mesh::shape_signature(mesh),
                                                  solvers::mesh::shape_signature(single)),
              1e-6);
  }
}

TEST(ShapeSignature, does_not_see_how_a_face_is_cut) {
  const solvers::mesh::ShapeSignature coarse =
      solvers::mesh::shape_signature(test::box_surface({0.02, 0.03, 0.05}, 1));
  const solvers::mesh::ShapeSignature fine =
      solvers::mesh::shape_signature(test::box_surface({0.02, 0.03, 0.05}, 7));
  EXPECT_LT(solvers::mesh::signature_difference(coarse, fine), 1e-12);
}

TEST(ShapeSignature, is_another_for_another_shape) {
  const auto all = bodies();
  for (std::size_t i = 0; i < all.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      EXPECT_GT(solvers::mesh::signature_difference(solvers::mesh::shape_signature(all[i]),
                                                    solvers::mesh::shape_signature(all[j])),
                0.01);
    }
  }
}

TEST(ShapeSignature, tells_boxes_that_differ_by_a_thousandth_of_a_side) {
  rc::check([] {
    std::mt19937_64 random(*rc::gen::arbitrary<std::uint64_t>());
    Vec3 sides(uniform(random, 0.01, 0.1), uniform(random, 0.01, 0.1), uniform(random, 0.01, 0.1));
    const solvers::mesh::ShapeSignature one =
        solvers::mesh::shape_signature(test::box_surface(sides, 1));
    sides[*rc::gen::inRange(0, 3)] *= 1.001;
    RC_ASSERT(solvers::mesh::signature_difference(
                  one, solvers::mesh::shape_signature(test::box_surface(sides, 1))) >
              solvers::mesh::same_shape_tolerance);
  });
}

TEST(ShapeSignature, tells_a_thicker_wall) {
  const auto bowl = [](double wall) {
    return solvers::mesh::shape_signature(test::bowl_surface(0.06, wall, 24));
  };
  EXPECT_GT(solvers::mesh::signature_difference(bowl(0.004), bowl(0.00402)),
            solvers::mesh::same_shape_tolerance);
}

/// The surface of a sphere: every mean of r^n is that of its radius, and no direction stands out.
TEST(ShapeSignature, of_a_sphere_is_known) {
  const solvers::mesh::ShapeSignature sphere =
      solvers::mesh::shape_signature(test::sphere_surface(0.3, 40));
  EXPECT_NEAR(sphere[0], 1 / (4 * std::numbers::pi), 1e-3);
  EXPECT_NEAR(sphere[1], 1, 1e-3);
  EXPECT_NEAR(sphere[2], 1, 1e-3);
  for (std::size_t i = 3; i < sphere.size(); ++i) EXPECT_NEAR(sphere[i], 0, 2e-3) << i;
}

/// Of a square sheet of side a: mean r^2 = a^2/6, mean r^4 = 7 a^4/180, mean r^6 = a^6/89.6.
TEST(ShapeSignature, of_a_square_is_known) {
  test::SurfaceMesh square;
  square.vertices = {{0, 0, 0}, {2, 0, 0}, {2, 2, 0}, {0, 2, 0}};
  square.triangles = {{0, 1, 2}, {0, 2, 3}};
  // Mean of (x^2 + y^2)^3 over [-1, 1]^2: 2/7 + 6 * 1/5 * 1/3.
  const double sixth = 2.0 / 7 + 2.0 / 5, length2 = std::cbrt(sixth);
  const solvers::mesh::ShapeSignature signature = solvers::mesh::shape_signature(square);
  EXPECT_NEAR(signature[0], length2 / 4, 1e-12);
  EXPECT_NEAR(signature[1], 2.0 / 3 / length2, 1e-12);
  EXPECT_NEAR(signature[2], (2.0 / 5 + 2.0 / 9) / (length2 * length2), 1e-12);
}

TEST(ShapeSignature, of_nothing_is_like_no_other) {
  EXPECT_TRUE(solvers::mesh::shape_signature({}).empty());
  EXPECT_TRUE(std::isinf(solvers::mesh::signature_difference({}, {})));
  EXPECT_EQ(solvers::mesh::signature_name({}), "");
  solvers::mesh::SignatureIndex index;
  EXPECT_EQ(index.add({}), 0U);
  EXPECT_EQ(index.add({}), 1U);
}

TEST(SignatureIndex, finds_copies_on_either_side_of_any_border) {
  rc::check([] {
    const auto cells = *rc::gen::container<std::vector<int>>(10, rc::gen::inRange(0, 4));
    solvers::mesh::SignatureIndex index;
    std::vector<solvers::mesh::ShapeSignature> all;
    for (std::size_t i = 0; i < cells.size(); ++i) {
      // Of each kind, copies that differ by less than the tolerance; other kinds by far more.
      const double noise = 0.9 * solvers::mesh::same_shape_tolerance * (i % 2 == 0 ? 1 : 0);
      all.push_back({0.25, 0.001 * cells[i] + noise});
      std::size_t first = 0;
      while (solvers::mesh::signature_difference(all[first], all.back()) >
             solvers::mesh::same_shape_tolerance)
        ++first;
      RC_ASSERT(index.add(all.back()) == first);
    }
  });
}

}  // namespace
}  // namespace carillon
