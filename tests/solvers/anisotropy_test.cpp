// Anisotropic solids: closed forms of their constants, Ritz solutions of boxes, a published
// crystal.
#include "solvers/elements/anisotropy.hpp"

#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "closed_forms.hpp"
#include "reference_bodies.hpp"
#include "solve.hpp"
#include "solvers/elements/element.hpp"
#include "solvers/elements/node_numbering.hpp"
#include "test_meshes.hpp"

namespace carillon::solvers {
namespace {

using elements::Elastic;
using elements::Voigt;
using test::spruce;

Eigen::Matrix3d turn(double angle, const Vec3& axis) {
  return Eigen::AngleAxisd(angle, axis.normalized()).toRotationMatrix();
}

TEST(Anisotropy, ConstantsAreThoseOfTheirLaws) {
  const Voigt compliance = elements::orthotropic_stiffness(spruce).inverse();
  EXPECT_NEAR(1 / compliance(0, 0), 11.9e9, 1);
  EXPECT_NEAR(1 / compliance(2, 2), 0.51e9, 1);
  EXPECT_NEAR(-compliance(1, 0) / compliance(0, 0), 0.372, 1e-9);
  EXPECT_NEAR(-compliance(2, 0) / compliance(0, 0), 0.467, 1e-9);
  EXPECT_NEAR(-compliance(2, 1) / compliance(1, 1), 0.435, 1e-9);
  EXPECT_NEAR(1 / compliance(3, 3), 0.036e9, 1);
  EXPECT_NEAR(1 / compliance(5, 5), 0.76e9, 1);
  // An isotropic solid by any law is itself.
  const Voigt steel = elements::isotropic_stiffness(2e11, 0.29);
  const Elastic mean = elements::anisotropic(steel, 7850);
  EXPECT_NEAR(mean.youngs_modulus, 2e11, 1);
  EXPECT_NEAR(mean.poisson_ratio, 0.29, 1e-12);
  EXPECT_NEAR(mean.density, 7850, 0);
  const double g = 2e11 / 2.58;
  EXPECT_LT(
      (elements::orthotropic_stiffness({{2e11, 2e11, 2e11}, {0.29, 0.29, 0.29}, {g, g, g}}) - steel)
          .norm(),
      1e-9 * steel.norm());
  // Copper, 168.4, 121.4 and 75.4 GPa: Voigt 54.6, Reuss 40.0 for the shear modulus, bulk 137.1.
  const Elastic copper =
      elements::anisotropic(elements::cubic_stiffness(168.4e9, 121.4e9, 75.4e9), 8960);
  const double shear = copper.youngs_modulus / (2 * (1 + copper.poisson_ratio));
  const double voigt = (168.4 - 121.4 + 3 * 75.4) / 5,
               reuss = 5 * 47.0 * 75.4 / (4 * 75.4 + 3 * 47.0);
  EXPECT_NEAR(shear, (voigt + reuss) / 2 * 1e9, 1e3);
  EXPECT_NEAR(copper.youngs_modulus / (3 * (1 - 2 * copper.poisson_ratio)), 137.0667e9, 1e5);
}

TEST(Anisotropy, TurnsAsSymmetryWants) {
  const Voigt cubic = elements::cubic_stiffness(168.4, 121.4, 75.4);
  const Voigt hexagonal = elements::hexagonal_stiffness(162, 92, 69, 181, 46.7);
  const double quarter = std::numbers::pi / 2;
  for (const Vec3& axis : {Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(0, 0, 1)})
    EXPECT_LT((elements::rotated(cubic, turn(quarter, axis)) - cubic).norm(), 1e-12 * cubic.norm());
  EXPECT_GT((elements::rotated(cubic, turn(0.3, Vec3(0, 0, 1))) - cubic).norm(), 1);
  for (const double angle : {0.1, 0.7, 2.0})
    EXPECT_LT((elements::rotated(hexagonal, turn(angle, Vec3(0, 0, 1))) - hexagonal).norm(),
              1e-12 * hexagonal.norm());
  // The first axis along y: E along y is that along the grain.
  Eigen::Matrix3d axes;
  axes << 0, 0, 1, 1, 0, 0, 0, 1, 0;
  const Voigt laid = elements::rotated(elements::orthotropic_stiffness(spruce), axes);
  EXPECT_NEAR(1 / laid.inverse()(1, 1), 11.9e9, 1);
  EXPECT_NEAR(1 / laid.inverse()(2, 2), 0.93e9, 1);
  EXPECT_NEAR(1 / laid.inverse()(3, 3), 0.76e9, 1);  // between grain and radius: y and z
}

TEST(Anisotropy, TurnsBack) {
  EXPECT_TRUE(rc::check("turning by R, then by its inverse, changes nothing", [] {
    const auto number = [] { return *rc::gen::inRange(-1000, 1000) / 1000.0; };
    Voigt root;
    for (Eigen::Index i = 0; i < 36; ++i) root(i / 6, i % 6) = number();
    const Voigt stiffness = root * root.transpose() + Voigt::Identity();
    const Vec3 axis(number(), number(), 1.5);
    const Eigen::Matrix3d r = turn(3 * number(), axis);
    const Voigt there = elements::rotated(stiffness, r);
    RC_ASSERT((elements::rotated(there, r.transpose()) - stiffness).norm() <
              1e-12 * stiffness.norm());
    RC_ASSERT(std::abs(there.topLeftCorner<3, 3>().sum() - stiffness.topLeftCorner<3, 3>().sum()) <
              1e-12 * stiffness.norm());
  }));
}

TEST(Anisotropy, RefusesWhatCostsNoEnergy) {
  elements::EngineeringConstants bad = spruce;
  bad.poisson_ratios[2] = 4;  // sqrt(E1 / E2) is 3.6
  const auto fault =
      elements::elastic_fault(elements::anisotropic(elements::orthotropic_stiffness(bad), 400));
  ASSERT_TRUE(fault);
  EXPECT_NE(fault->message.find("positive definite"), std::string::npos);
  EXPECT_NE(fault->hint.find("nu12^2 < E1 / E2"), std::string::npos);
  EXPECT_TRUE(
      elements::elastic_fault(elements::anisotropic(elements::cubic_stiffness(100, 120, 50), 1)));
  EXPECT_FALSE(
      elements::elastic_fault(elements::anisotropic(elements::orthotropic_stiffness(spruce), 400)));
}

TEST(Anisotropy, ElementsKnowIt) {
  for (int order = 1; order <= 4; ++order) {
    const auto mesh = test::box_mesh(Vec3(1, 0.8, 0.6), {1, 1, 1}, order);
    elements::ElementKernel kernel(order);
    elements::Coordinates nodes(3, elements::nodes_per_tetrahedron(order));
    for (Eigen::Index n = 0; n < nodes.cols(); ++n)
      nodes.col(n) =
          mesh.nodes[static_cast<std::size_t>(mesh.element(0)[static_cast<std::size_t>(n)])];
    kernel.place(nodes);
    Eigen::MatrixXd lame, general, spruces;
    elements::ElasticConstants material = elements::isotropic_constants(2.5, 0.3, 1);
    kernel.stiffness(material, lame);
    material.stiffness = elements::isotropic_stiffness(2.5, 0.3);
    kernel.stiffness(material, general);
    EXPECT_LT((lame - general).norm(), 1e-13 * lame.norm());
    material.stiffness =
        elements::rotated(elements::orthotropic_stiffness(spruce) / 1e9, turn(0.6, Vec3(1, 2, 3)));
    kernel.stiffness(material, spruces);
    EXPECT_LT((spruces - spruces.transpose()).norm(), 1e-13 * spruces.norm());
    // Energies are those of the matrix, and a constant strain has that of the law.
    const Eigen::Index n = nodes.cols();
    Eigen::Matrix3d slope;
    slope << 0.1, 0.7, -0.2, 0.3, -0.4, 0.5, 0.2, 0.6, -0.1;
    const Eigen::MatrixXd u = (slope * nodes).transpose();
    Eigen::VectorXd flat(3 * n);
    for (Eigen::Index i = 0; i < n; ++i) flat.segment<3>(3 * i) = u.row(i).transpose();
    Eigen::ArrayXd strain = Eigen::ArrayXd::Zero(1), kinetic = Eigen::ArrayXd::Zero(1);
    kernel.add_energies(material, u, strain, kinetic);
    EXPECT_NEAR(strain[0], flat.dot(spruces * flat), 1e-12 * strain[0]);
    Eigen::Vector<double, 6> e;
    e << slope(0, 0), slope(1, 1), slope(2, 2), slope(1, 2) + slope(2, 1),
        slope(0, 2) + slope(2, 0), slope(0, 1) + slope(1, 0);
    EXPECT_NEAR(strain[0], 0.08 * e.dot(*material.stiffness * e), 1e-12 * strain[0]);
  }
}

TEST(Anisotropy, OrthotropicBoxesAreRitzs) {
  const Voigt stiffness = elements::orthotropic_stiffness(spruce);
  const auto truth = test::box_frequencies({0.05, 0.03, 0.02}, {9, 9, 9}, stiffness, 400, 12);
  const auto mesh = test::box_mesh(Vec3(0.05, 0.03, 0.02), {5, 4, 4}, 4);
  const auto modes = test::lowest_modes(mesh, {elements::anisotropic(stiffness, 400)}, 12);
  const auto found = test::frequencies(modes);
  for (std::size_t i = 0; i < truth.size(); ++i)
    EXPECT_LT(std::abs(1200 * std::log2(found[i] / truth[i])), 1) << "mode " << i + 1;
  EXPECT_EQ(modes.certificate.rigid_modes, 6);
}

TEST(Anisotropy, EstimatesAreTrue) {
  const Voigt stiffness = elements::orthotropic_stiffness(spruce);
  const auto truth = test::box_frequencies({0.05, 0.03, 0.02}, {11, 11, 11}, stiffness, 400, 12);
  for (const auto& [order, cells] :
       {std::pair(1, std::array{20, 14, 10}), {2, {8, 6, 5}}, {3, {5, 4, 4}}, {4, {5, 4, 4}}}) {
    const auto modes = test::lowest_modes(test::box_mesh(Vec3(0.05, 0.03, 0.02), cells, order),
                                          {elements::anisotropic(stiffness, 400)}, 20);
    const auto found = test::measure_effectivity(modes, truth);
    EXPECT_GT(found.compared, 7u) << "order " << order;
    EXPECT_EQ(found.complaint, "") << "order " << order;
  }
}

TEST(Anisotropy, ABodyAndItsAxesTurnTogether) {
  const Voigt stiffness = elements::orthotropic_stiffness(spruce);
  const Eigen::Matrix3d axes = turn(0.8, Vec3(1, -1, 2));
  auto mesh = test::box_mesh(Vec3(0.05, 0.03, 0.02), {3, 3, 2}, 3);
  const Elastic solid = elements::anisotropic(stiffness, 400);
  const auto straight = test::frequencies(test::lowest_modes(mesh, {solid}, 12));
  for (Vec3& node : mesh.nodes) node = axes * node;
  const auto turned =
      test::frequencies(test::lowest_modes(mesh, {elements::rotated(solid, axes)}, 12));
  const auto wrong = test::frequencies(test::lowest_modes(mesh, {solid}, 12));
  for (std::size_t i = 0; i < straight.size(); ++i)
    EXPECT_NEAR(turned[i] / straight[i], 1, 1e-8) << "mode " << i + 1;
  EXPECT_GT(std::abs(wrong[0] / straight[0] - 1), 0.05);
}

TEST(Anisotropy, APublishedCrystalOfStrontiumTitanate) {
  const auto folder = test::data_folder();
  if (folder.empty()) GTEST_SKIP() << "CARILLON_TEST_DATA is not set";
  // Computed with polynomials of degree 20 from the constants that were fitted to the crystal.
  const auto published = test::csv_column(
      folder + "/reference_modes/published_rus_SrTiO3_cubic.csv", "f_ours_order20_MHz");
  ASSERT_GT(published.size(), 30u);
  const Vec3 sides(1.45e-3, 2.01e-3, 3.02e-3);
  const Elastic crystal = elements::anisotropic(
      elements::cubic_stiffness(321.876e9, 103.883e9, 124.350e9), 45.0e-6 / sides.prod());
  const auto found = test::frequencies(test::lowest_modes(
      test::box_mesh(sides, {4, 5, 7}, 4), {crystal}, static_cast<int>(published.size())));
  for (std::size_t i = 0; i < std::min<std::size_t>(found.size(), 40); ++i)
    EXPECT_NEAR(found[i] / (1e6 * std::stod(published[i])), 1, 1e-4) << "mode " << i + 1;
}

}  // namespace
}  // namespace carillon::solvers
