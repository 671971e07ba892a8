// What must hold for every body: scaling, symmetry, completeness, energies, refusals.
#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/error.hpp"
#include "solve.hpp"
#include "test_meshes.hpp"

namespace carillon {
namespace {

using namespace solvers;
using test::box_mesh;
using test::frequencies;
using test::lowest_modes;

solvers::modes::Modes solve_band(const test::TetMesh& mesh,
                                 const std::vector<solvers::elements::Elastic>& regions,
                                 const solvers::modes::Band& band, core::Trace* trace = nullptr) {
  core::Trace own;
  solvers::eigen::SolveOptions options;
  options.band = band;
  return solvers::eigen::solve_modes(mesh, regions, options, MPI_COMM_SELF, trace ? *trace : own);
}

test::TetMesh block(int order = 2) {
  return box_mesh({0.02, 0.03, 0.05}, {2, 3, 4}, order);
}

double worst_difference(const std::vector<double>& a, const std::vector<double>& b) {
  EXPECT_EQ(a.size(), b.size());
  double worst = 0;
  for (std::size_t k = 0; k < std::min(a.size(), b.size()); ++k) {
    worst = std::max(worst, std::abs(a[k] / b[k] - 1));
  }
  return worst;
}

TEST(Modes, MeetEveryCheckOfTheirCertificate) {
  core::Trace trace;
  const auto modes = solve_band(block(), {test::steel}, {20, 80000, 300}, &trace);
  const auto& c = modes.certificate;
  EXPECT_TRUE(c.complete);
  EXPECT_EQ(c.complete_to_hz, 80000);
  EXPECT_EQ(c.modes_in_band, c.modes_found);
  EXPECT_EQ(static_cast<std::size_t>(c.modes_found), modes.size());
  EXPECT_GT(modes.size(), 10u);
  EXPECT_EQ(c.rigid_modes, 6);
  EXPECT_EQ(c.components, 1);
  EXPECT_LT(c.max_residual, 1e-8);
  EXPECT_LT(c.orthonormality, 1e-10);
  EXPECT_EQ(c.unknowns, 3 * static_cast<std::int64_t>(block().nodes.size()));
  EXPECT_TRUE(std::is_sorted(modes.eigenvalues.begin(), modes.eigenvalues.end()));
  for (std::size_t k = 0; k < modes.size(); ++k) {
    EXPECT_LE(modes.frequency(k), 80000);
    const Eigen::VectorXd row = modes.shapes.of(static_cast<Eigen::Index>(k));
    EXPECT_GE(row.maxCoeff(), -row.minCoeff() * 0.99999);
  }
  for (const char* stage : {"partition", "assemble", "count", "solve", "extract"}) {
    EXPECT_GE(trace.stages[stage].calls, 1) << stage;
  }
}

/// More modes were known to lie in the band than max_modes lets through.
TEST(Modes, CutShortSayHowFarTheyReach) {
  const auto all = solve_band(block(), {test::steel}, {20, 120000, 300});
  ASSERT_TRUE(all.certificate.complete);
  ASSERT_GT(all.size(), 30u);
  const auto few = solve_band(block(), {test::steel}, {20, 120000, 12});
  EXPECT_EQ(few.size(), 12u);
  EXPECT_FALSE(few.certificate.complete);
  EXPECT_EQ(few.certificate.modes_in_band, all.certificate.modes_in_band);
  EXPECT_GE(few.certificate.complete_to_hz, all.frequency(11));
  EXPECT_LE(few.certificate.complete_to_hz, all.frequency(12));
}

TEST(Modes, BelowTheBandAreDroppedButNotMistakenForMissing) {
  const auto all = solve_band(block(), {test::steel}, {20, 90000, 300});
  const double middle = (all.frequency(5) + all.frequency(6)) / 2;
  for (const int maximum : {300, 4}) {
    const auto upper = solve_band(block(), {test::steel}, {middle, 90000, maximum});
    EXPECT_EQ(upper.certificate.modes_in_band, all.certificate.modes_in_band - 6);
    ASSERT_EQ(upper.size(),
              std::min<std::size_t>(all.size() - 6, static_cast<std::size_t>(maximum)));
    for (std::size_t k = 0; k < upper.size(); ++k) {
      EXPECT_NEAR(upper.frequency(k) / all.frequency(k + 6), 1, 1e-9);
    }
  }
}

TEST(Modes, NoneInTheBandIsALegalResult) {
  for (const solvers::modes::Band& band :
       {solvers::modes::Band{20, 20000, 300}, solvers::modes::Band{27500, 27600, 300},
        solvers::modes::Band{0, 1, 1}}) {
    const auto modes = solve_band(block(), {test::steel}, band);
    EXPECT_EQ(modes.size(), 0u);
    EXPECT_EQ(modes.certificate.modes_in_band, 0);
    EXPECT_TRUE(modes.certificate.complete);
    EXPECT_EQ(modes.certificate.complete_to_hz, band.max_frequency);
    EXPECT_EQ(modes.certificate.rigid_modes, 6);
    EXPECT_NEAR(modes.mass, 0.2355, 1e-10);
    EXPECT_EQ(modes.shapes.modes(), 0);
    EXPECT_FALSE(modes.surface.faces.empty());
  }
}

TEST(Rescale, EqualsAFreshSolve) {
  const double length = 3.7, modulus = 0.21, density = 1.9;
  const auto base = lowest_modes(block(), {test::steel}, 15);
  const auto scaled = solvers::modes::rescale(base, length, modulus, density);
  const auto big = test::moved(block(), [&](const Vec3& x) -> Vec3 { return length * x; });
  const auto fresh = lowest_modes(
      big, {{modulus * test::steel.youngs_modulus, 0.29, density * test::steel.density}}, 15);
  EXPECT_LT(worst_difference(scaled.eigenvalues, fresh.eigenvalues), 1e-9);
  EXPECT_NEAR(scaled.mass / fresh.mass, 1, 1e-12);
  EXPECT_NEAR(scaled.shapes.values().norm() / fresh.shapes.values().norm(), 1, 1e-6);
  EXPECT_NEAR(scaled.certificate.complete_to_hz / fresh.certificate.complete_to_hz, 1, 1e-6);
  EXPECT_EQ(scaled.residuals, base.residuals);
  EXPECT_LT((scaled.surface.nodes.back() - fresh.surface.nodes.back()).norm(), 1e-12);
}

TEST(Modes, DoNotDependOnWhereAndHowTheBodyLies) {
  // A body without symmetry, so that no pair of modes can turn.
  const auto body = box_mesh({0.02, 0.031, 0.053}, {2, 2, 3}, 2);
  const auto truth = frequencies(lowest_modes(body, {test::steel}, 12));
  EXPECT_TRUE(rc::check([&] {
    const Vec3 axis(*rc::gen::inRange(1, 10), *rc::gen::inRange(1, 10), *rc::gen::inRange(1, 10));
    const Eigen::AngleAxisd turn(*rc::gen::inRange(0, 628) * 0.01, axis.normalized());
    const Vec3 shift(*rc::gen::inRange(-9, 9), *rc::gen::inRange(-9, 9), 1);
    const bool mirror = *rc::gen::inRange(0, 2) == 1;
    const auto other = test::moved(body, [&](const Vec3& x) -> Vec3 {
      const Vec3 y(mirror ? -x[0] : x[0], x[1], x[2]);
      return turn * y + shift * 0.1;
    });
    RC_ASSERT(worst_difference(frequencies(lowest_modes(other, {test::steel}, 12)), truth) < 1e-9);
  }));
}

TEST(Regions, OfEqualMaterialAreOneBody) {
  const auto halves = box_mesh({0.02, 0.03, 0.05}, {2, 3, 4}, 2,
                               [](const Vec3& x) { return x[2] < 0.025 ? 0 : 1; });
  const auto one = lowest_modes(block(), {test::steel}, 12);
  const auto two = lowest_modes(halves, {test::steel, test::steel}, 12);
  EXPECT_LT(worst_difference(one.eigenvalues, two.eigenvalues), 1e-10);
  ASSERT_EQ(two.kinetic_fraction.cols(), 2);
  // By symmetry each half holds half of every energy.
  EXPECT_LT((two.kinetic_fraction.array() - 0.5).abs().maxCoeff(), 1e-6);
  EXPECT_LT((two.strain_fraction.array() - 0.5).abs().maxCoeff(), 1e-6);
}

TEST(Regions, ShareTheEnergiesOfATwoMaterialBar) {
  const auto bar =
      box_mesh({0.01, 0.01, 0.1}, {1, 1, 10}, 3, [](const Vec3& x) { return x[2] < 0.05 ? 0 : 1; });
  const solvers::elements::Elastic soft{2e9, 0.35, 1100};
  const auto modes = lowest_modes(bar, {test::steel, soft}, 10);
  EXPECT_LT((modes.kinetic_fraction.rowwise().sum().array() - 1).abs().maxCoeff(), 1e-12);
  EXPECT_LT((modes.strain_fraction.rowwise().sum().array() - 1).abs().maxCoeff(), 1e-12);
  EXPECT_GT(modes.kinetic_fraction.minCoeff(), 0);
  EXPECT_GT(modes.strain_fraction(0, 1), 0.9) << "the soft half bends";
  EXPECT_NEAR(modes.mass, 0.5e-5 * (7850 + 1100), 1e-10);
  // Sensitivities: dln(lambda) / dln(E) of a region is its strain share, and to its density minus
  // its kinetic share. Summed over the pairs of bending in two planes, whose basis is free.
  const auto slope_of_pair = [&](const solvers::elements::Elastic& nudged, std::size_t first) {
    const auto other = lowest_modes(bar, {test::steel, nudged}, 10);
    return std::log(other.eigenvalues[first] * other.eigenvalues[first + 1] /
                    (modes.eigenvalues[first] * modes.eigenvalues[first + 1])) /
           std::log(1.0001);
  };
  const auto fraction_of_pair = [](const Eigen::MatrixXd& fraction, Eigen::Index first) {
    return fraction(first, 1) + fraction(first + 1, 1);
  };
  solvers::elements::Elastic stiffer = soft, heavier = soft;
  stiffer.youngs_modulus *= 1.0001;
  heavier.density *= 1.0001;
  for (const Eigen::Index first : {0, 2}) {
    const auto k = static_cast<std::size_t>(first);
    EXPECT_NEAR(slope_of_pair(stiffer, k), fraction_of_pair(modes.strain_fraction, first), 1e-3);
    EXPECT_NEAR(slope_of_pair(heavier, k), -fraction_of_pair(modes.kinetic_fraction, first), 1e-3);
  }
}

TEST(Components, HaveSixRigidModesEach) {
  const auto body = block();
  const auto two = test::joined(
      body, test::moved(body, [](const Vec3& x) -> Vec3 { return 0.8 * x + Vec3(0.1, 0, 0); }));
  const auto modes = lowest_modes(two, {test::steel, test::steel}, 12);
  EXPECT_EQ(modes.certificate.components, 2);
  EXPECT_EQ(modes.certificate.rigid_modes, 12);
  // The spectrum is that of both bodies together.
  auto expected = frequencies(lowest_modes(body, {test::steel}, 12));
  for (std::size_t k = 0, n = expected.size(); k < n; ++k) expected.push_back(expected[k] / 0.8);
  std::sort(expected.begin(), expected.end());
  expected.resize(12);
  EXPECT_LT(worst_difference(frequencies(modes), expected), 1e-9);
}

/// Shapes on the surface obey Parseval: with every mode of a small body, mass-normalised, the sum
/// of phi phi^T over all modes (rigid ones too) is the inverse of M. Here: a body so small that its
/// kinetic energy can be summed from its surface alone, since all nodes of order 1 lie on it.
TEST(Shapes, AreMassNormalised) {
  const auto mesh = box_mesh({0.02, 0.03, 0.05}, {1, 1, 1}, 1);
  const auto modes = lowest_modes(mesh, {test::steel}, 18);
  ASSERT_EQ(modes.size(), 18u);
  ASSERT_EQ(modes.surface.nodes.size(), mesh.nodes.size());
  // Consistent mass of four-node tetrahedra: rho V / 20 (1 + delta).
  Eigen::MatrixXd mass = Eigen::MatrixXd::Zero(8, 8);
  for (std::size_t e = 0; e < mesh.element_count(); ++e) {
    const double fraction = 7850 * 0.02 * 0.03 * 0.05 / 6 / 20;
    for (const auto a : mesh.element(e))
      for (const auto b : mesh.element(e)) mass(a, b) += a == b ? 2 * fraction : fraction;
  }
  const solvers::modes::ModeShapes::Rows shapes = modes.shapes.at_nodes();
  for (Eigen::Index i = 0; i < 18; ++i)
    for (Eigen::Index j = 0; j < 18; ++j) {
      double product = 0;
      for (Eigen::Index c = 0; c < 3; ++c) {
        Eigen::VectorXd a(8), b(8);
        for (Eigen::Index n = 0; n < 8; ++n) {
          a[n] = static_cast<double>(shapes(i, 3 * n + c));
          b[n] = static_cast<double>(shapes(j, 3 * n + c));
        }
        product += a.dot(mass * b);
      }
      EXPECT_NEAR(product, i == j ? 1 : 0, 1e-6);
    }
}

TEST(Restrict, IsExactWhereTheSetWasComplete) {
  const auto wide = solve_band(block(), {test::steel}, {20, 100000, 300});
  const double low = (wide.frequency(2) + wide.frequency(3)) / 2;
  const double high = (wide.frequency(9) + wide.frequency(10)) / 2;
  const solvers::modes::Band narrow{low, high, 300};
  const auto cut = solvers::modes::restrict_to(wide, narrow);
  const auto fresh = solve_band(block(), {test::steel}, narrow);
  EXPECT_LT(worst_difference(cut.eigenvalues, fresh.eigenvalues), 1e-10);
  EXPECT_EQ(cut.size(), 7u);
  EXPECT_TRUE(cut.certificate.complete);
  EXPECT_EQ(cut.certificate.complete_to_hz, high);
  EXPECT_EQ(cut.certificate.modes_in_band, fresh.certificate.modes_in_band);
  EXPECT_EQ(cut.shapes.modes(), 7);
  const auto first = solvers::modes::restrict_to(wide, {low, high, 3});
  EXPECT_EQ(first.size(), 3u);
  EXPECT_FALSE(first.certificate.complete);
  EXPECT_EQ(first.certificate.modes_in_band, 7);
  EXPECT_GT(first.certificate.complete_to_hz, first.frequency(2));
  EXPECT_LT(first.certificate.complete_to_hz, wide.frequency(6));
  // Beyond what is known nothing is claimed.
  const auto beyond = solvers::modes::restrict_to(wide, {20, 200000, 300});
  EXPECT_FALSE(beyond.certificate.complete);
  EXPECT_EQ(beyond.certificate.complete_to_hz, 100000);
}

TEST(Flatten, FollowsTheCurvedFaces) {
  for (int order = 1; order <= 4; ++order) {
    const auto ball = test::ball_mesh(0.05, 2, order);
    solvers::modes::Modes modes;
    modes.surface.order = order;
    modes.surface.nodes = ball.nodes;
    modes.surface.faces = ball.faces;
    const auto flat = solvers::modes::flatten(modes.surface);
    EXPECT_EQ(flat.triangles.size(), ball.face_count() * static_cast<std::size_t>(order * order));
    const double exact = 4 * std::numbers::pi / 3 * std::pow(0.05, 3);
    // Inscribed, and outward.
    EXPECT_LT(solvers::mesh::signed_volume(flat), exact);
    EXPECT_GT(solvers::mesh::signed_volume(flat), exact * (1 - 0.2 / (order * order)));
  }
}

TEST(Refusals, NameWhatIsWrong) {
  const auto expect_input_error = [](const test::TetMesh& mesh,
                                     const solvers::elements::Elastic& material,
                                     const std::string& word) {
    try {
      lowest_modes(mesh, {material}, 3);
      ADD_FAILURE() << "no error about " << word;
    } catch (const core::InputError& e) {
      EXPECT_NE(std::string(e.what()).find(word), std::string::npos) << e.what();
    }
  };
  expect_input_error(block(), {2e11, 0.5, 7850}, "Poisson");
  expect_input_error(block(), {2e11, -1.0, 7850}, "Poisson");
  expect_input_error(block(), {0, 0.3, 7850}, "Young");
  expect_input_error(block(), {2e11, 0.3, -1}, "density");
  expect_input_error(solvers::mesh::TetMesh{}, test::steel, "no elements");
  auto broken = block();
  broken.elements[5] = 1000000;
  expect_input_error(broken, test::steel, "nodes that do not exist");
  EXPECT_THROW(solve_band(block(), {test::steel}, {100, 50, 10}), core::InputError);
}

TEST(Refusals, AnElementTurnedInsideOutIsNamed) {
  auto mesh = block();
  const std::size_t wrong = 17;
  auto* v = &mesh.elements[wrong * 10];
  std::swap(v[0], v[1]);
  try {
    lowest_modes(mesh, {test::steel}, 3);
    ADD_FAILURE() << "no error";
  } catch (const core::SolverError& e) {
    EXPECT_NE(std::string(e.what()).find("element 17"), std::string::npos) << e.what();
  }
}

/// Two boxes that share one edge: a hinge, whose swing has no strain.
TEST(Refusals, PartsThatHangByAnEdgeAreAMechanism) {
  const auto checker = box_mesh({0.04, 0.04, 0.02}, {2, 2, 1}, 2, [](const Vec3& x) {
    return (x[0] < 0.02) == (x[1] < 0.02) ? 0 : 1;
  });
  test::TetMesh hinge = checker;
  hinge.elements.clear();
  hinge.regions.clear();
  hinge.region_names = {"body"};
  for (std::size_t e = 0; e < checker.element_count(); ++e) {
    if (checker.regions[e] != 0) continue;
    const auto element = checker.element(e);
    hinge.elements.insert(hinge.elements.end(), element.begin(), element.end());
    hinge.regions.push_back(0);
  }
  hinge.faces = solvers::mesh::boundary_faces(hinge);
  try {
    lowest_modes(hinge, {test::steel}, 5);
    ADD_FAILURE() << "no error";
  } catch (const core::SolverError& e) {
    EXPECT_NE(std::string(e.what()).find("hang together"), std::string::npos) << e.what();
  }
}

TEST(Modes, AreTheSameBitsWhenSolvedAgain) {
  const auto a = lowest_modes(block(3), {test::steel}, 20);
  const auto b = lowest_modes(block(3), {test::steel}, 20);
  EXPECT_EQ(a.eigenvalues, b.eigenvalues);
  EXPECT_EQ(a.shapes.values(), b.shapes.values());
}

TEST(WholeClusters, RepeatedEigenvaluesAreTakenWholeOrNotAtAll) {
  const std::vector<double> pairs = {1, 2, 2 + 1e-9, 3, 4, 4, 4};
  EXPECT_EQ(solvers::modes::whole_clusters(pairs, 2), 1u);
  EXPECT_EQ(solvers::modes::whole_clusters(pairs, 3), 3u);
  EXPECT_EQ(solvers::modes::whole_clusters(pairs, 5), 4u);
  EXPECT_EQ(solvers::modes::whole_clusters(pairs, 6), 4u);
  EXPECT_EQ(solvers::modes::whole_clusters(pairs, 7), 7u);
  EXPECT_EQ(solvers::modes::whole_clusters(pairs, 100), 7u);
  EXPECT_EQ(solvers::modes::whole_clusters(std::vector<double>{2, 2, 2}, 2), 2u);
}

TEST(RestrictTo, ARescaledSetIsStillComplete) {
  // Steel at 0.6 of its size: the certificate comes back a rounding below the band's top.
  solvers::modes::Modes modes;
  modes.eigenvalues = {4e6, 9e6};
  modes.residuals = {0, 0};
  modes.shapes = solvers::modes::ModeShapes(Eigen::MatrixXf::Zero(2, 3));
  modes.kinetic_fraction.setOnes(2, 1);
  modes.strain_fraction.setOnes(2, 1);
  modes.surface.nodes = {{0, 0, 0}};
  for (const double size : {0.3, 0.6, 0.7, 1.1, 1.9, 3.0}) {
    auto solved = modes;
    solved.certificate.min_frequency = 20 * size;
    solved.certificate.max_frequency = 20000 * size;
    solved.certificate.complete_to_hz = 20000 * size;
    solved.certificate.modes_in_band = 2;
    solved.certificate.complete = true;
    const auto cut =
        solvers::modes::restrict_to(solvers::modes::rescale(solved, size, 1, 1), {20, 20000, 300});
    EXPECT_TRUE(cut.certificate.complete) << size;
    EXPECT_EQ(cut.certificate.complete_to_hz, 20000) << size;
  }
}

}  // namespace
}  // namespace carillon
