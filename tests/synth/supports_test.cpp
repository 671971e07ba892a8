#include "synth/support/supports.hpp"

#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "core/error.hpp"
#include "tests/synth/curved_bodies.hpp"
#include "tests/synth/support_cases.hpp"

namespace carillon::synth {
namespace {

constexpr double pi = std::numbers::pi;
constexpr double fixed_radius = 0.1;

Vec3 wavy(int mode, const Vec3& x) {
  return {std::sin(30 * x.x() + mode), std::cos(20 * x.y() * (mode + 1)),
          std::sin(10 * x.z() + 5.0 * mode * x.x())};
}

solvers::modes::Modes wavy_modes(int count) {
  std::vector<double> eigenvalues;
  for (int i = 0; i < count; ++i) eigenvalues.push_back(std::pow(2 * pi * 200 * (i + 1), 2));
  return modes_with(curved_sphere(fixed_radius, Vec3::Zero(), 3, 2), eigenvalues, wavy);
}

/// Box about the origin of flat first-order faces, turned.
solvers::modes::ModeSurface box(const Vec3& sides, const Eigen::Matrix3d& turn) {
  solvers::modes::ModeSurface surface;
  for (int corner = 0; corner < 8; ++corner) {
    const Vec3 at(corner & 1 ? 0.5 : -0.5, corner & 2 ? 0.5 : -0.5, corner & 4 ? 0.5 : -0.5);
    surface.nodes.push_back(turn * at.cwiseProduct(sides));
  }
  for (const std::array<int, 4>& side : {std::array{0, 2, 3, 1},
                                         {4, 5, 7, 6},
                                         {0, 1, 5, 4},
                                         {2, 6, 7, 3},
                                         {0, 4, 6, 2},
                                         {1, 3, 7, 5}}) {
    for (const int k : {0, 1, 2, 0, 2, 3}) {
      surface.faces.push_back(side[static_cast<std::size_t>(k)]);
    }
  }
  return surface;
}

std::vector<support::Contact> contacts_on(const solvers::modes::Modes& modes, int count,
                                          unsigned seed) {
  const modal::SurfaceSampler sampler(modes.surface);
  core::RandomStream random(seed, 0, "contacts");
  std::vector<support::Contact> contacts;
  for (int k = 0; k < count; ++k) {
    const modal::SurfacePoint point = sampler.sample(random);
    contacts.push_back({point, modal::frame_at(modes.surface, point).normal, random.uniform()});
  }
  return contacts;
}

/// Equation 21 of Sterling et al. 2019 as it stands.
Eigen::MatrixXd papers_damping(const solvers::modes::Modes& modes,
                               const std::vector<support::Contact>& contacts, double friction) {
  Eigen::MatrixXd g = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(modes.size()),
                                            static_cast<Eigen::Index>(modes.size()));
  for (const support::Contact& contact : contacts) {
    const Eigen::MatrixX3d phi = modal::shapes_at(modes, contact.point);
    const Eigen::Matrix3d middle = friction * Eigen::Matrix3d::Identity() +
                                   (1 - friction) * contact.normal * contact.normal.transpose();
    g += contact.fraction * phi * middle * phi.transpose();
  }
  return g;
}

TEST(Dashpots, AreThePapersDamping) {
  const auto modes = wavy_modes(6);
  for (const int count : {1, 2, 40}) {  // 40 have more columns than there are modes
    for (const double friction : {0.0, 0.4, 1.0, 1.5}) {
      const auto contacts = contacts_on(modes, count, 3);
      const Eigen::MatrixXd unit = support::contact_factor(modes, contacts, friction);
      EXPECT_LE(unit.cols(), 6);
      const Eigen::MatrixXd exact = papers_damping(modes, contacts, friction);
      EXPECT_LT((unit * unit.transpose() - exact).norm(), 1e-12 * exact.norm())
          << count << " " << friction;
    }
  }
}

TEST(Dashpots, GrowWithForceAndCoefficient) {
  const auto modes = wavy_modes(4);
  const Eigen::MatrixXd unit = support::contact_factor(modes, contacts_on(modes, 1, 1), 0.5);
  const std::vector<double> d = {1, 2, 3, 4};
  const auto soft = diagonal_rates(d, support::dashpots(unit, 0.5, 3));
  const auto hard = diagonal_rates(d, support::dashpots(unit, 2, 6));
  for (std::size_t i = 0; i < 4; ++i) {
    const double gii = unit.row(static_cast<Eigen::Index>(i)).squaredNorm();
    EXPECT_NEAR(soft[i] - d[i], 0.5 * 3 * gii / 2, 1e-12 * gii);
    EXPECT_NEAR(hard[i] - d[i], 2 * 6 * gii / 2, 1e-12 * gii);
    EXPECT_LT(modal::t60(hard[i]), modal::t60(soft[i]));
    EXPECT_LT(modal::t60(soft[i]), modal::t60(d[i]));
  }
}

TEST(Dashpots, NeverFeedEnergy) {
  rc::check("the damping of supports is positive semidefinite", [] {
    const auto modes = wavy_modes(*rc::gen::inRange(1, 8));
    const double friction = *rc::gen::inRange(0, 300) / 100.0;
    const auto contacts = contacts_on(modes, *rc::gen::inRange(1, 12), *rc::gen::inRange(0u, 99u));
    const Eigen::MatrixXd l =
        support::dashpots(support::contact_factor(modes, contacts, friction), 1, 7);
    const Eigen::MatrixXd g = l * l.transpose();
    const Eigen::VectorXd values =
        Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(g, Eigen::EigenvaluesOnly).eigenvalues();
    RC_ASSERT(values.minCoeff() >= -1e-12 * values.maxCoeff());
  });
}

TEST(Dashpots, AddNothingOnANodeLine) {
  // Shapes that vanish on the plane x = 0.
  const auto modes = modes_with(curved_sphere(fixed_radius, Vec3::Zero(), 2, 2), {1e6, 2e6},
                                [](int, const Vec3& x) -> Vec3 { return x.x() * x; });
  const modal::SurfaceSampler sampler(modes.surface);
  const auto on_node = support::point_contact(modes.surface, sampler.nearest({0, 0, fixed_radius}));
  const auto off_node =
      support::point_contact(modes.surface, sampler.nearest({fixed_radius, 0, 0}));
  const std::vector<double> d = {1, 2};
  EXPECT_EQ(diagonal_rates(d, support::dashpots(support::contact_factor(modes, on_node, 1), 1, 10)),
            d);
  EXPECT_GT(
      diagonal_rates(d, support::dashpots(support::contact_factor(modes, off_node, 1), 1, 10))[0],
      d[0]);
}

TEST(Dashpots, OfAFreeBodyPushItAsAWhole) {
  auto modes = wavy_modes(3);
  append(modes.surface, curved_sphere(fixed_radius / 2, Vec3::Zero(), 3, 2, true));
  modes.mass = 2;
  const surface::RigidBody body = surface::rigid_body(modes);
  EXPECT_LT(body.centre.norm(), 1e-6);
  // A hollow ball; straight pieces of the curved faces leave some per mille of its volume out.
  const double inertia = 0.4 * 2 * fixed_radius * fixed_radius * (1 - 1.0 / 32) / (1 - 1.0 / 8);
  for (Eigen::Index k = 0; k < 3; ++k) EXPECT_NEAR(body.inertia[k] / inertia, 1, 0.06);
  const modal::SurfaceSampler sampler(modes.surface);
  const auto contact = support::point_contact(modes.surface, sampler.nearest({0, 0, fixed_radius}));
  const Eigen::MatrixXd unit = support::contact_factor(modes, contact, 0.5, &body);
  ASSERT_EQ(unit.rows(), 9);
  // Pressed along z, rubbed along x and y: m^-1 (1, mu, mu), and r^2 / I more of mu for rotations.
  const Eigen::MatrixXd g = unit * unit.transpose();
  EXPECT_NEAR(g.block(3, 3, 3, 3).trace(), (1 + 2 * 0.5) / 2, 1e-9);
  EXPECT_NEAR(g.block(6, 6, 3, 3).trace() * inertia, 2 * 0.5 * fixed_radius * fixed_radius,
              0.07 * fixed_radius * fixed_radius);
  modes.mass = 0;
  EXPECT_THROW(surface::rigid_body(modes), core::InputError);
}

TEST(Dashpots, RefuseWhatIsNotPhysical) {
  const auto modes = wavy_modes(2);
  auto contacts = contacts_on(modes, 1, 1);
  const Eigen::MatrixXd unit = support::contact_factor(modes, contacts, 0.5);
  EXPECT_THROW(support::contact_factor(modes, contacts, -0.1), core::InputError);
  EXPECT_THROW(support::contact_factor(modes, contacts, std::nan("")), core::InputError);
  EXPECT_THROW(support::dashpots(unit, -1, 1), core::InputError);
  EXPECT_THROW(support::dashpots(unit, 1, -1), core::InputError);
  EXPECT_THROW(support::dashpots(unit, 1, std::nan("")), core::InputError);
  EXPECT_THROW(support::dashpots(unit, 1, INFINITY), core::InputError);
  EXPECT_THROW(support::dashpots(unit, 1e30, 1e30), core::InputError);
  EXPECT_THROW(diagonal_rates(std::vector<double>{1.0}, unit), core::InputError);
  contacts[0].normal *= 2;
  EXPECT_THROW(support::contact_factor(modes, contacts, 0.5), core::InputError);
}

TEST(SupportKinds, AreFoundByName) {
  for (const char* name : {"finger", "string", "foam", "table"}) {
    EXPECT_NO_THROW(support::check_support(support::parse_support(name)));
  }
  try {
    support::parse_support("fingr");
    FAIL();
  } catch (const core::InputError& error) {
    EXPECT_NE(error.message().find("did you mean \"finger\"?"), std::string::npos);
  }
}

TEST(PatchContacts, AreEvenOnACapOfASphere) {
  const auto surface = curved_sphere(fixed_radius, Vec3::Zero(), 8, 3);
  const modal::SurfaceSampler sampler(surface);
  const modal::SurfacePoint pole = sampler.nearest({0.03, -0.02, fixed_radius});
  const Vec3 axis = modal::frame_at(surface, pole).normal;
  const double reach = 0.04;
  const auto contacts =
      support::patch_contacts(surface, surface::outer_pieces(surface), pole, reach);
  double fractions = 0, cosine = 0;
  for (const support::Contact& contact : contacts) {
    fractions += contact.fraction;
    cosine += contact.fraction * contact.normal.dot(axis);
    const Vec3 at = modal::frame_at(surface, contact.point).position;
    EXPECT_LT((at - modal::frame_at(surface, pole).position).norm(), 1.05 * reach);
  }
  EXPECT_NEAR(fractions, 1, 1e-12);
  // Area is uniform along the axis (Archimedes), which a cap leaves at 1 - reach^2 / (2 R^2).
  const double drop = reach * reach / (2 * fixed_radius * fixed_radius);
  EXPECT_NEAR(1 - cosine, drop / 2, 0.03 * drop);
}

TEST(PatchContacts, TouchOneSideOfAThinWall) {
  const auto surface = box({0.1, 0.1, 0.002}, Eigen::Matrix3d::Identity());
  const modal::SurfaceSampler sampler(surface);
  const auto contacts = support::patch_contacts(surface, surface::outer_pieces(surface),
                                                sampler.nearest({0.01, 0.02, 0.1}), 0.01);
  EXPECT_GT(contacts.size(), 20u);
  for (const support::Contact& contact : contacts) {
    EXPECT_GT(modal::frame_at(surface, contact.point).position.z(), 0);
  }
  EXPECT_LT((support::centre_of(surface, contacts) - Vec3(0.01, 0.02, 0.001)).norm(), 0.0005);
  EXPECT_EQ(support::patch_contacts(surface, surface::outer_pieces(surface),
                                    sampler.nearest({0, 0, 1}), 0)
                .size(),
            1u);
  EXPECT_THROW(support::patch_contacts(surface, surface::outer_pieces(surface),
                                       sampler.nearest({0, 0, 1}), -1),
               core::InputError);
  EXPECT_THROW(support::patch_contacts(surface, surface::outer_pieces(surface),
                                       sampler.nearest({0, 0, 1}), std::nan("")),
               core::InputError);
}

TEST(LowestContacts, AreTheBaseTheEdgeOrTheCornerOfABox) {
  const Vec3 down(0, 0, -1);
  const Vec3 sides(0.1, 0.06, 0.04);
  const double height = 1e-3;
  const auto lowest = [&](const Eigen::Matrix3d& turn) {
    const auto surface = box(sides, turn);
    const auto contacts = support::lowest_contacts(surface, down, height);
    double bottom = 1;
    for (const Vec3& node : surface.nodes) bottom = std::min(bottom, node.z());
    double fractions = 0;
    for (const support::Contact& contact : contacts) {
      fractions += contact.fraction;
      EXPECT_EQ(contact.normal, down);
      EXPECT_LE(modal::frame_at(surface, contact.point).position.z(), bottom + height);
    }
    EXPECT_NEAR(fractions, 1, 1e-12);
    return support::centre_of(surface, contacts);
  };
  EXPECT_LT((lowest(Eigen::Matrix3d::Identity()) - Vec3(0, 0, -0.02)).norm(), 1e-12);
  const Eigen::AngleAxisd edge(pi / 4, Vec3::UnitX());
  const double depth = (0.06 + 0.04) / 2 * std::sqrt(0.5);
  const Vec3 on_edge = lowest(edge.toRotationMatrix());
  EXPECT_NEAR(on_edge.x(), 0, 1e-12);
  EXPECT_NEAR(on_edge.z(), -depth, height);
  const Vec3 diagonal = Vec3(1, 1, 1).normalized();
  const Eigen::Quaterniond corner = Eigen::Quaterniond::FromTwoVectors(diagonal, down);
  const Vec3 at_corner = lowest(corner.toRotationMatrix());
  EXPECT_LT((at_corner - corner * Vec3(sides / 2)).norm(), 2 * height);
}

TEST(LowestContacts, OfASphereAreACap) {
  const auto surface = curved_sphere(fixed_radius, Vec3(1, 2, 3), 8, 3);
  const auto contacts = support::lowest_contacts(surface, {0, -1, 0}, 1e-3);
  EXPECT_LT((support::centre_of(surface, contacts) - Vec3(1, 2 - fixed_radius, 3)).norm(), 1e-3);
  EXPECT_THROW(support::lowest_contacts(surface, {0, -2, 0}, 1e-3), core::InputError);
  EXPECT_THROW(support::lowest_contacts(surface, {0, -1, 0}, -1), core::InputError);
  // A height of nothing is the lowest point.
  EXPECT_LT((support::centre_of(surface, support::lowest_contacts(surface, {0, -1, 0}, 0)) -
             Vec3(1, 2 - fixed_radius, 3))
                .norm(),
            1e-12);
}

TEST(EdgeContacts, AreEvenAlongTheLine) {
  const auto surface = box({0.1, 0.06, 0.04}, Eigen::Matrix3d::Identity());
  const modal::SurfaceSampler sampler(surface);
  // A thread below the body, with a bend that is shorter than the way to it.
  const std::vector<Vec3> line = {{-0.04, 0, -0.1}, {0.02, 0, -0.1}, {0.02, 0.02, -0.1}};
  const auto contacts = support::edge_contacts(surface, sampler, line, 8);
  ASSERT_EQ(contacts.size(), 8u);
  for (std::size_t k = 0; k < 8; ++k) {
    const double along = 0.08 * (static_cast<double>(k) + 0.5) / 8;
    const Vec3 expected(std::min(-0.04 + along, 0.02), std::max(0.0, along - 0.06), -0.02);
    EXPECT_LT((modal::frame_at(surface, contacts[k].point).position - expected).norm(), 1e-12) << k;
    EXPECT_EQ(contacts[k].fraction, 1.0 / 8);
  }
  EXPECT_EQ(support::edge_contacts(surface, sampler, std::vector<Vec3>{{0, 0, 1}}, 3).size(), 3u);
  EXPECT_THROW(support::edge_contacts(surface, sampler, {}, 3), core::InputError);
  EXPECT_THROW(support::edge_contacts(surface, sampler, line, 0), core::InputError);
}

TEST(Weight, IsThatOfTheMass) {
  auto modes = wavy_modes(1);
  modes.mass = 2;
  EXPECT_NEAR(support::weight(modes), 19.6133, 1e-12);
}

}  // namespace
}  // namespace carillon::synth
