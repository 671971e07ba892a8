#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>
#include <set>

#include "solvers/elements/lagrange.hpp"
#include "solvers/elements/quadrature.hpp"
#include "solvers/mesh/tet_mesh.hpp"
#include "test_meshes.hpp"

namespace carillon {
namespace {

using namespace solvers;
using test::box_mesh;

double factorial(int n) {
  return n < 2 ? 1 : n * factorial(n - 1);
}

/// Random barycentric coordinates in small steps.
Eigen::Vector4d random_point() {
  Eigen::Vector4d l;
  for (int c = 0; c < 4; ++c) l[c] = *rc::gen::inRange(1, 1000);
  return l / l.sum();
}

class Orders : public testing::TestWithParam<int> {};
INSTANTIATE_TEST_SUITE_P(Lagrange, Orders, testing::Values(1, 2, 3, 4));

TEST_P(Orders, LatticeHasEveryNodeOnceInTheDocumentedOrder) {
  const int p = GetParam();
  const auto& tet = solvers::elements::tetrahedron_lattice(p);
  ASSERT_EQ(static_cast<int>(tet.size()), solvers::elements::nodes_per_tetrahedron(p));
  EXPECT_EQ(std::set(tet.begin(), tet.end()).size(), tet.size());
  for (const auto& t : tet) EXPECT_EQ(t[0] + t[1] + t[2] + t[3], p);
  for (std::size_t v = 0; v < 4; ++v) EXPECT_EQ(tet[v][v], p);
  // First node on edge (01) is the one next to vertex 0; the second edge is (02).
  if (p > 1) {
    EXPECT_EQ(tet[4], (std::array<int, 4>{p - 1, 1, 0, 0}));
    EXPECT_EQ(tet[4 + static_cast<std::size_t>(p - 1)], (std::array<int, 4>{p - 1, 0, 1, 0}));
    EXPECT_EQ(tet[4 + 5 * static_cast<std::size_t>(p - 1)], (std::array<int, 4>{0, 0, p - 1, 1}));
  }
  if (p > 2) {
    const auto first_face = 4 + 6 * static_cast<std::size_t>(p - 1);
    EXPECT_EQ(tet[first_face], (std::array<int, 4>{p - 2, 1, 1, 0}));
  }
  const auto& triangle = solvers::elements::triangle_lattice(p);
  ASSERT_EQ(static_cast<int>(triangle.size()), solvers::elements::nodes_per_face(p));
  EXPECT_EQ(std::set(triangle.begin(), triangle.end()).size(), triangle.size());
  for (const auto& t : triangle) EXPECT_EQ(t[0] + t[1] + t[2], p);
}

TEST_P(Orders, ShapeFunctionsAreOneAtTheirNodeAndZeroAtTheOthers) {
  const int p = GetParam();
  const auto& tet = solvers::elements::tetrahedron_lattice(p);
  for (std::size_t n = 0; n < tet.size(); ++n) {
    const Eigen::Vector4d at(tet[n][0], tet[n][1], tet[n][2], tet[n][3]);
    Eigen::VectorXd values = solvers::elements::tetrahedron_shape_functions(p, at / p, nullptr);
    values[static_cast<Eigen::Index>(n)] -= 1;
    EXPECT_LT(values.cwiseAbs().maxCoeff(), 1e-14);
  }
  const auto& triangle = solvers::elements::triangle_lattice(p);
  for (std::size_t n = 0; n < triangle.size(); ++n) {
    const Eigen::Vector3d at(triangle[n][0], triangle[n][1], triangle[n][2]);
    Eigen::VectorXd values = solvers::elements::triangle_shape_functions(p, at / p, nullptr);
    values[static_cast<Eigen::Index>(n)] -= 1;
    EXPECT_LT(values.cwiseAbs().maxCoeff(), 1e-14);
  }
}

/// x^i y^j z^k with x, y, z = the last three barycentric coordinates is reproduced, and so is its
/// gradient, whenever i + j + k <= p.
TEST_P(Orders, PolynomialsOfTheOrderAreReproducedWithTheirGradients) {
  const int p = GetParam();
  EXPECT_TRUE(rc::check([p] {
    const auto l = random_point();
    const int i = *rc::gen::inRange(0, p + 1);
    const int j = *rc::gen::inRange(0, p - i + 1);
    const int k = *rc::gen::inRange(0, p - i - j + 1);
    const auto f = [&](double x, double y, double z) {
      return std::pow(x, i) * std::pow(y, j) * std::pow(z, k);
    };
    Eigen::Matrix<double, Eigen::Dynamic, 4> gradient;
    const auto values = solvers::elements::tetrahedron_shape_functions(p, l, &gradient);
    double sum = 0;
    Eigen::Vector3d slope = Eigen::Vector3d::Zero();
    const auto& lattice = solvers::elements::tetrahedron_lattice(p);
    for (std::size_t n = 0; n < lattice.size(); ++n) {
      const double nodal =
          f(double(lattice[n][1]) / p, double(lattice[n][2]) / p, double(lattice[n][3]) / p);
      const auto row = static_cast<Eigen::Index>(n);
      sum += nodal * values[row];
      for (int c = 0; c < 3; ++c) slope[c] += nodal * (gradient(row, c + 1) - gradient(row, 0));
    }
    RC_ASSERT(std::abs(sum - f(l[1], l[2], l[3])) < 1e-13);
    const Eigen::Vector3d exact(i == 0 ? 0 : i * f(l[1], l[2], l[3]) / l[1],
                                j == 0 ? 0 : j * f(l[1], l[2], l[3]) / l[2],
                                k == 0 ? 0 : k * f(l[1], l[2], l[3]) / l[3]);
    RC_ASSERT((slope - exact).cwiseAbs().maxCoeff() < 1e-11);
  }));
}

TEST_P(Orders, TetrahedronRestrictedToAFaceIsTheTriangle) {
  const int p = GetParam();
  EXPECT_TRUE(rc::check([p] {
    Eigen::Vector3d l(*rc::gen::inRange(1, 99), *rc::gen::inRange(1, 99), *rc::gen::inRange(1, 99));
    l /= l.sum();
    const auto on_face = solvers::elements::triangle_shape_functions(p, l, nullptr);
    const auto in_body =
        solvers::elements::tetrahedron_shape_functions(p, {l[0], l[1], l[2], 0}, nullptr);
    const auto& triangle = solvers::elements::triangle_lattice(p);
    const auto& tet = solvers::elements::tetrahedron_lattice(p);
    for (std::size_t a = 0; a < triangle.size(); ++a) {
      for (std::size_t b = 0; b < tet.size(); ++b) {
        if (tet[b] != std::array<int, 4>{triangle[a][0], triangle[a][1], triangle[a][2], 0}) {
          continue;
        }
        RC_ASSERT(std::abs(on_face[static_cast<Eigen::Index>(a)] -
                           in_body[static_cast<Eigen::Index>(b)]) < 1e-14);
      }
    }
  }));
}

/// Integral of L0^a L1^b L2^c L3^d over the reference tetrahedron: a! b! c! d! / (a+b+c+d+3)!.
TEST(Quadrature, IsExactToItsDegreeAndNotBeyond) {
  for (int points = 1; points <= 8; ++points) {
    const auto& rule = solvers::elements::tetrahedron_rule(points);
    const auto integral = [&rule](int a, int b, int c, int d) {
      double sum = 0;
      for (std::size_t q = 0; q < rule.size(); ++q) {
        const auto& l = rule.barycentric[q];
        sum += rule.weights[q] * std::pow(l[0], a) * std::pow(l[1], b) * std::pow(l[2], c) *
               std::pow(l[3], d);
      }
      return sum;
    };
    const int degree = 2 * points - 1;
    for (int a = 0; a <= degree; ++a)
      for (int b = 0; a + b <= degree; ++b)
        for (int c = 0; a + b + c <= degree; ++c) {
          const int d = degree - a - b - c;
          const double exact =
              factorial(a) * factorial(b) * factorial(c) * factorial(d) / factorial(degree + 3);
          EXPECT_NEAR(integral(a, b, c, d) / exact, 1, 1e-11) << points << a << b << c << d;
        }
    const double next = factorial(degree + 1) / factorial(degree + 4);
    EXPECT_GT(std::abs(integral(0, degree + 1, 0, 0) / next - 1), 1e-9);
    for (const double w : rule.weights) EXPECT_GT(w, 0);
  }
}

TEST_P(Orders, BoundaryFacesEncloseTheVolumeOutward) {
  const int p = GetParam();
  const auto mesh = box_mesh({0.03, 0.02, 0.05}, {2, 1, 3}, p);
  const auto per_face = static_cast<std::size_t>(solvers::elements::nodes_per_face(p));
  // Two triangles on each cell face of the box's six sides.
  EXPECT_EQ(mesh.face_count(), 2u * 2u * (2 * 1 + 1 * 3 + 2 * 3));
  double volume = 0;
  const auto& lattice = solvers::elements::triangle_lattice(p);
  for (std::size_t f = 0; f < mesh.face_count(); ++f) {
    const auto node = [&](std::size_t n) {
      return mesh.nodes[static_cast<std::size_t>(mesh.faces[f * per_face + n])];
    };
    volume += node(0).dot(node(1).cross(node(2))) / 6;
    for (std::size_t n = 0; n < per_face; ++n) {
      const Vec3 expected =
          (lattice[n][0] * node(0) + lattice[n][1] * node(1) + lattice[n][2] * node(2)) / p;
      EXPECT_LT((node(n) - expected).norm(), 1e-15);
    }
  }
  EXPECT_NEAR(volume, 0.03 * 0.02 * 0.05, 1e-17);
}

TEST_P(Orders, VolumeOfACurvedBodyIsIntegrated) {
  const int p = GetParam();
  const auto quality = solvers::mesh::measure_quality(test::ball_mesh(0.05, 6, p));
  const double exact = 4 * std::numbers::pi / 3 * std::pow(0.05, 3);
  const double error[] = {0.1, 3e-3, 1e-3, 1e-4};
  EXPECT_NEAR(quality.volume / exact, 1, error[p - 1]);
  EXPECT_GT(quality.min_radius_ratio, 0.05);
}

/// Integral of L0^a L1^b L2^c over the reference triangle: a! b! c! / (a+b+c+2)!.
TEST(Quadrature, OfTrianglesIsExactToItsDegree) {
  for (int points = 1; points <= 8; ++points) {
    const auto& rule = solvers::elements::triangle_rule(points);
    const int degree = 2 * points - 1;
    for (int a = 0; a <= degree; ++a)
      for (int b = 0; a + b <= degree; ++b) {
        const int c = degree - a - b;
        double sum = 0;
        for (std::size_t q = 0; q < rule.size(); ++q) {
          const auto& l = rule.barycentric[q];
          sum += rule.weights[q] * std::pow(l[0], a) * std::pow(l[1], b) * std::pow(l[2], c);
        }
        const double exact = factorial(a) * factorial(b) * factorial(c) / factorial(degree + 2);
        EXPECT_NEAR(sum / exact, 1, 1e-11) << points << ": " << a << ' ' << b << ' ' << c;
      }
  }
}

TEST(Quality, OfTheRegularTetrahedron) {
  test::TetMesh mesh;
  mesh.nodes = {{1, 1, 1}, {-1, 1, -1}, {1, -1, -1}, {-1, -1, 1}};
  mesh.elements = {0, 1, 2, 3};
  mesh.regions = {0};
  mesh.region_names = {"body"};
  const auto quality = solvers::mesh::measure_quality(mesh);
  EXPECT_NEAR(quality.min_dihedral_deg, std::acos(1 / 3.0) * 180 / std::numbers::pi, 1e-12);
  EXPECT_NEAR(quality.max_dihedral_deg, std::acos(1 / 3.0) * 180 / std::numbers::pi, 1e-12);
  EXPECT_NEAR(quality.min_radius_ratio, 1, 1e-14);
  EXPECT_NEAR(quality.volume, 8 / 3.0, 1e-14);
  EXPECT_EQ(quality.elements, 1);
  EXPECT_EQ(quality.nodes, 4);
}

TEST(Quality, OfTheCornerOfACube) {
  test::TetMesh mesh;
  mesh.nodes = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  mesh.elements = {0, 1, 2, 3};
  mesh.regions = {0};
  mesh.region_names = {"body"};
  const auto quality = solvers::mesh::measure_quality(mesh);
  EXPECT_NEAR(quality.max_dihedral_deg, 90, 1e-12);
  EXPECT_NEAR(quality.min_dihedral_deg, std::acos(1 / std::sqrt(3)) * 180 / std::numbers::pi,
              1e-12);
  const double inradius = 0.5 / (1.5 + std::sqrt(3) / 2);
  EXPECT_NEAR(quality.min_radius_ratio, 3 * inradius / (std::sqrt(3) / 2), 1e-13);
}

TEST(Quality, IsTheSameAfterARotation) {
  EXPECT_TRUE(rc::check([] {
    const double angle = *rc::gen::inRange(0, 1000) * 0.01;
    const Eigen::AngleAxisd turn(angle, Vec3(1, 2, 3).normalized());
    const auto mesh = box_mesh({1, 2, 0.1}, {2, 3, 1}, 2);
    const auto a = solvers::mesh::measure_quality(mesh);
    const auto b = solvers::mesh::measure_quality(
        test::moved(mesh, [&](const Vec3& x) -> Vec3 { return turn * x; }));
    RC_ASSERT(std::abs(a.min_dihedral_deg - b.min_dihedral_deg) < 1e-9);
    RC_ASSERT(std::abs(a.median_radius_ratio - b.median_radius_ratio) < 1e-10);
    RC_ASSERT(std::abs(a.volume / b.volume - 1) < 1e-12);
  }));
}

TEST(Components, AreCountedByNodesAndIgnoreUnusedOnes) {
  const auto box = box_mesh({1, 1, 1}, {1, 1, 1}, 2);
  EXPECT_EQ(solvers::mesh::count_components(box), 1);
  auto two =
      test::joined(box, test::moved(box, [](const Vec3& x) -> Vec3 { return x + Vec3(2, 0, 0); }));
  EXPECT_EQ(solvers::mesh::count_components(two), 2);
  two.nodes.emplace_back(9, 9, 9);
  EXPECT_EQ(solvers::mesh::count_components(two), 2);
  const auto component = solvers::mesh::node_components(two);
  EXPECT_EQ(component.front(), 0);
  EXPECT_EQ(component[box.nodes.size()], 1);
  EXPECT_EQ(component.back(), -1);
  EXPECT_EQ(solvers::mesh::count_components(solvers::mesh::TetMesh{}), 0);
}

}  // namespace
}  // namespace carillon
