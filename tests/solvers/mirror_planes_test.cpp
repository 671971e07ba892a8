// Bodies solved by the classes of their mirror planes against the same bodies solved whole.
#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "family_shapes.hpp"
#include "solve.hpp"
#include "solvers/assembly/mirror_class.hpp"
#include "solvers/basis/solve_materials.hpp"
#include "solvers/eigen/mirrored_solve.hpp"
#include "solvers/eigen/search.hpp"
#include "solvers/families/families.hpp"
#include "solvers/mesh/mirrored_part.hpp"
#include "test_meshes.hpp"

namespace carillon {
namespace {

using namespace solvers;
using elements::Elastic;
using mesh::MirrorPlane;
using test::TetMesh;

const std::array<int, 3> all_axes = {0, 1, 2};

/// A box about the origin made of its part above planes through it. Nodes of the next order are
/// there, so that what is made of them is seen.
TetMesh mirrored_box(const Vec3& sides, const std::array<int, 3>& cells, int order,
                     const std::vector<int>& axes,
                     const std::function<int(const Vec3&)>& region = {}) {
  Vec3 low = -sides / 2, extent = sides;
  std::vector<MirrorPlane> planes;
  for (const int axis : axes) {
    low[axis] = 0;
    extent[axis] /= 2;
    planes.push_back({axis, 0});
  }
  const auto at_order = [&](int n) {
    return test::moved(test::box_mesh(extent, cells, n, region),
                       [low](const Vec3& x) -> Vec3 { return x + low; });
  };
  return mesh::unfold(test::with_finer_nodes(at_order(order), at_order(order + 1)), planes);
}

modes::Modes solve(const TetMesh& mesh, const std::vector<Elastic>& regions,
                   const modes::Band& band, bool mirror_planes) {
  core::Trace trace;
  eigen::SolveOptions options;
  options.band = band;
  options.mirror_planes = mirror_planes;
  return eigen::solve_modes(mesh, regions, options, MPI_COMM_SELF, trace);
}

bool is_alone(const modes::Modes& modes, std::size_t k) {
  const auto apart = [&](std::size_t i, std::size_t j) {
    return std::abs(modes.eigenvalues[i] / modes.eigenvalues[j] - 1) > 1e-4;
  };
  return (k == 0 || apart(k, k - 1)) && (k + 1 == modes.size() || apart(k, k + 1));
}

/// Everything that both ways tell.
/// @param rounding  of eigenvalues: on curved elements quadrature sees the order of an element's
///                  corners, which a mirror changes
void expect_alike(const modes::Modes& own, const modes::Modes& whole, double rounding = 1e-8) {
  ASSERT_EQ(own.size(), whole.size());
  for (std::size_t k = 0; k < own.size(); ++k) {
    EXPECT_NEAR(own.eigenvalues[k] / whole.eigenvalues[k], 1, rounding) << k;
    EXPECT_LT(own.residuals[k], 1e-8) << k;
    if (!is_alone(whole, k)) continue;
    const auto mode = static_cast<Eigen::Index>(k);
    const Eigen::VectorXd difference = own.shapes.of(mode) - whole.shapes.of(mode);
    const Eigen::VectorXd sum = own.shapes.of(mode) + whole.shapes.of(mode);
    // Where two entries are equally large, rounding chooses which of them is positive.
    EXPECT_LT(std::min(difference.norm(), sum.norm()), 2e-4 * whole.shapes.of(mode).norm()) << k;
    EXPECT_TRUE(own.kinetic_fraction.row(mode).isApprox(whole.kinetic_fraction.row(mode), 1e-5));
    EXPECT_TRUE(own.strain_fraction.row(mode).isApprox(whole.strain_fraction.row(mode), 1e-5));
  }
  EXPECT_EQ(own.surface.faces, whole.surface.faces);
  EXPECT_NEAR(own.mass / whole.mass, 1, 1e-10);
  const auto &a = own.certificate, &b = whole.certificate;
  EXPECT_EQ(a.modes_in_band, b.modes_in_band);
  EXPECT_EQ(a.modes_found, b.modes_found);
  EXPECT_EQ(a.complete, b.complete);
  EXPECT_EQ(a.rigid_modes, b.rigid_modes);
  EXPECT_EQ(a.components, b.components);
  EXPECT_EQ(a.count_verified, b.count_verified);
  // Each unknown of the body is in one class.
  EXPECT_EQ(a.unknowns, b.unknowns);
  EXPECT_LT(a.orthonormality, 1e-8);
  EXPECT_GT(a.complete_to_hz, own.size() > 0 ? own.frequency(own.size() - 1) : 0);
}

/// Estimates of the same modes, as far as the conjugate gradients inside go (CorrectionGoal).
/// @param part  of an estimate by which it may differ
void expect_same_errors(const modes::Modes& own, const modes::Modes& whole, double part = 0.05) {
  ASSERT_EQ(own.pitch_errors.size(), whole.pitch_errors.size());
  for (std::size_t k = 0; k < own.size(); ++k) {
    EXPECT_NEAR(own.pitch_errors[k], whole.pitch_errors[k], 0.02 + part * whole.pitch_errors[k])
        << k;
  }
}

TEST(MirrorPlanes, PartAndImagesAreTheBody) {
  const auto body = mirrored_box({0.1, 0.07, 0.05}, {3, 2, 2}, 3, {0, 1, 2});
  const auto part = mesh::mirrored_part(body, all_axes);
  ASSERT_TRUE(part);
  ASSERT_EQ(part->planes.size(), 3u);
  EXPECT_EQ(8 * part->mesh.element_count(), body.element_count());
  EXPECT_NEAR(8 * mesh::measure_quality(part->mesh).volume / mesh::measure_quality(body).volume, 1,
              1e-12);
  for (std::size_t n = 0; n < body.nodes.size(); ++n) {
    Vec3 at = part->mesh.nodes[static_cast<std::size_t>(part->nodes[n])];
    for (std::size_t p = 0; p < 3; ++p) {
      if ((part->images[n] >> p & 1) != 0) at = mesh::reflect(at, part->planes[p]);
    }
    EXPECT_LT((at - body.nodes[n]).norm(), 1e-12);
  }
  // A face of the body belongs to one of its eight parts.
  EXPECT_EQ(8 * part->mesh.face_count(), body.face_count());
}

TEST(MirrorPlanes, AreLeftWhereAnythingDiffers) {
  const auto body = mirrored_box({0.1, 0.07, 0.05}, {3, 2, 2}, 2, {0, 1});
  const auto axes_of = [](const TetMesh& mesh) {
    std::vector<int> axes;
    if (const auto part = mesh::mirrored_part(mesh, all_axes)) {
      for (const auto& plane : part->planes) axes.push_back(plane.axis);
    }
    return axes;
  };
  EXPECT_EQ(axes_of(body), (std::vector{0, 1}));
  auto bent = body;
  bent.nodes.back().x() += 1e-8;
  EXPECT_EQ(axes_of(bent), std::vector<int>());
  auto bulged = body;
  bulged.finer_nodes.back().y() += 1e-8;
  EXPECT_EQ(axes_of(bulged), std::vector<int>());
  auto rounded = body;
  rounded.nodes.back().x() += 1e-12;
  EXPECT_EQ(axes_of(rounded), (std::vector{0, 1}));
  auto two = body;
  two.region_names = {"left", "right"};
  for (std::size_t e = 0; e < two.element_count(); ++e) {
    double middle = 0;
    for (const auto n : two.element(e)) middle += two.nodes[static_cast<std::size_t>(n)].x();
    two.regions[e] = middle > 0;
  }
  EXPECT_EQ(axes_of(two), std::vector{1});
}

/// A half of cells cut along one diagonal each is not symmetric, but its images are.
TEST(MirrorPlanes, ASymmetrisedMeshIsTheSameBody) {
  const auto box = test::moved(test::box_mesh({0.1, 0.07, 0.05}, {4, 2, 1}, 2),
                               [](const Vec3& x) -> Vec3 { return x + Vec3(3, 2, 1); });
  EXPECT_FALSE(mesh::mirrored_part(box, all_axes));
  const auto both = mesh::symmetrised(box);
  const auto part = mesh::mirrored_part(both, all_axes);
  ASSERT_TRUE(part);
  // One cell through its thickness has no plane there.
  EXPECT_EQ(part->planes.size(), 2u);
  EXPECT_EQ(both.element_count(), box.element_count());
  EXPECT_EQ(both.nodes.size(), box.nodes.size());
  EXPECT_EQ(both.face_count(), box.face_count());
  EXPECT_NEAR(mesh::measure_quality(both).volume / 3.5e-4, 1, 1e-12);
  EXPECT_GT(mesh::measure_quality(both).min_radius_ratio, 0);
}

TEST(MirrorPlanes, SymmetricFamiliesHaveThem) {
  const std::vector<std::pair<mesh::GeneratedShape, std::size_t>> shapes = {
      {test::shape_of("block", {{"length", 0.1}, {"width", 0.07}, {"height", 0.05}}), 3},
      {test::shape_of("tile", {{"length", 0.1}, {"width", 0.07}, {"thickness", 0.003}}), 2},
      {test::shape_of("box", {{"length", 0.1}, {"width", 0.07}, {"height", 0.05}, {"wall", 0.003}}),
       3},
      {test::shape_of("bauble",
                      {{"length", 0.1}, {"width", 0.07}, {"height", 0.05}, {"wall", 0.003}}),
       3},
      {test::shape_of("wrench", {{"length", 0.2},
                                 {"handle_width", 0.017},
                                 {"head_radius", 0.024},
                                 {"jaw_width", 0.018},
                                 {"thickness", 0.005}}),
       1}};
  for (const auto& [shape, planes] : shapes) {
    for (int order = 2; order <= 4; ++order) {
      mesh::MeshOptions options;
      options.order = order;
      const auto made = families::mesh_family(shape, options);
      const auto part = mesh::mirrored_part(made.mesh, all_axes);
      ASSERT_TRUE(part) << shape.family;
      EXPECT_GE(part->planes.size(), planes) << shape.family << " of order " << order;
    }
  }
}

TEST(MirrorPlanes, RigidMotionsAreSharedOut) {
  const mesh::MirroredPart part =
      *mesh::mirrored_part(mirrored_box({0.1, 0.07, 0.05}, {1, 1, 1}, 1, {0, 1, 2}), all_axes);
  std::vector<int> all;
  for (const auto& one : assembly::mirror_classes(part)) {
    const auto motions = one.rigid_motions();
    EXPECT_LE(motions.size(), 1u);
    all.insert(all.end(), motions.begin(), motions.end());
  }
  std::sort(all.begin(), all.end());
  EXPECT_EQ(all, (std::vector{0, 1, 2, 3, 4, 5}));
}

TEST(MirrorPlanes, OfABlock) {
  const auto mesh = mirrored_box({0.1, 0.07, 0.05}, {3, 2, 2}, 3, {0, 1, 2});
  const modes::Band band{20, 60000, 300};
  const auto own = solve(mesh, {test::steel}, band, true);
  const auto whole = solve(mesh, {test::steel}, band, false);
  EXPECT_EQ(own.certificate.mirror_planes, 3);
  EXPECT_EQ(whole.certificate.mirror_planes, 0);
  EXPECT_TRUE(own.certificate.complete);
  EXPECT_EQ(own.certificate.complete_to_hz, 60000);
  expect_alike(own, whole);
  expect_same_errors(own, whole);
}

/// A cube's modes come in pairs and triples that its classes share.
TEST(MirrorPlanes, OfACube) {
  const auto mesh = mirrored_box({0.1, 0.1, 0.1}, {2, 2, 2}, 3, {0, 1, 2});
  const modes::Band band{20, 1e9, 40};
  expect_alike(solve(mesh, {test::aluminium}, band, true),
               solve(mesh, {test::aluminium}, band, false));
}

TEST(MirrorPlanes, OfAThinPlate) {
  const auto mesh = mirrored_box({0.2, 0.15, 0.0005}, {5, 4, 1}, 3, {0, 1});
  const modes::Band band{20, 1e9, 25};
  const auto own = solve(mesh, {test::glass}, band, true);
  const auto whole = solve(mesh, {test::glass}, band, false);
  EXPECT_EQ(own.certificate.mirror_planes, 2);
  ASSERT_EQ(own.size(), whole.size());
  for (std::size_t k = 0; k < own.size(); ++k)
    EXPECT_NEAR(own.eigenvalues[k] / whole.eigenvalues[k], 1, 1e-6) << k;
}

/// An annulus sector's half: curved, on its own nodes of the next order.
TEST(MirrorPlanes, OfABentBar) {
  const auto bend = [](const Vec3& x) -> Vec3 {
    const double radius = 0.05 + x.y(), angle = x.x() / 0.05;
    return {radius * std::sin(angle), radius * std::cos(angle), x.z()};
  };
  const auto at_order = [&](int order) {
    return test::moved(test::box_mesh({0.06, 0.012, 0.008}, {6, 2, 2}, order), bend);
  };
  const auto part = test::with_finer_nodes(at_order(2), at_order(3));
  const std::vector<MirrorPlane> planes = {{0, 0}};
  const auto mesh = mesh::unfold(part, planes);
  const modes::Band band{20, 20000, 300};
  const auto own = solve(mesh, {test::steel}, band, true);
  const auto whole = solve(mesh, {test::steel}, band, false);
  EXPECT_EQ(own.certificate.mirror_planes, 1);
  expect_alike(own, whole, 2e-6);
  expect_same_errors(own, whole, 0.2);
}

TEST(MirrorPlanes, OfTwoMaterials) {
  const auto mesh = mirrored_box({0.1, 0.07, 0.05}, {3, 2, 2}, 3, {0, 1, 2},
                                 [](const Vec3& x) { return x.x() > 0.02; });
  const modes::Band band{20, 50000, 300};
  const std::vector<Elastic> regions = {test::steel, test::glass};
  const auto own = solve(mesh, regions, band, true);
  EXPECT_EQ(own.certificate.mirror_planes, 3);
  expect_alike(own, solve(mesh, regions, band, false));
}

TEST(MirrorPlanes, OfWood) {
  const auto mesh = mirrored_box({0.1, 0.07, 0.05}, {3, 2, 2}, 3, {0, 1, 2});
  const modes::Band band{20, 1e9, 20};
  const auto grain_at = [](double degrees) {
    const double angle = degrees * std::numbers::pi / 180;
    const Eigen::Matrix3d axes = Eigen::AngleAxisd(angle, Vec3::UnitZ()).toRotationMatrix();
    return elements::anisotropic(
        elements::rotated(elements::orthotropic_stiffness(test::spruce), axes), 450);
  };
  for (const auto& [degrees, planes] : {std::pair{0.0, 3}, {30.0, 1}}) {
    const std::vector<Elastic> wood = {grain_at(degrees)};
    const auto own = solve(mesh, wood, band, true);
    EXPECT_EQ(own.certificate.mirror_planes, planes) << degrees;
    expect_alike(own, solve(mesh, wood, band, false));
  }
}

/// Whatever part of the modes is asked for.
TEST(MirrorPlanes, PropertyOfBands) {
  EXPECT_TRUE(rc::check([] {
    const Vec3 sides(0.1, *rc::gen::inRange(40, 100) * 1e-3, *rc::gen::inRange(5, 100) * 1e-3);
    const auto planes = *rc::gen::elementOf(
        std::vector<std::vector<int>>{{0}, {1}, {0, 1}, {0, 2}, {1, 2}, {0, 1, 2}});
    const auto mesh = mirrored_box(sides, {5, 5, 5}, 1, planes);
    modes::Band band{0, 1e9, *rc::gen::inRange(1, 60)};
    if (*rc::gen::arbitrary<bool>()) band.min_frequency = *rc::gen::inRange(1000, 40000);
    if (*rc::gen::arbitrary<bool>()) band.counted_from = *rc::gen::inRange(1000, 40000);
    if (*rc::gen::arbitrary<bool>()) band.max_frequency = *rc::gen::inRange(41000, 90000);
    const auto own = solve(mesh, {test::steel}, band, true);
    const auto whole = solve(mesh, {test::steel}, band, false);
    RC_ASSERT(own.certificate.mirror_planes == static_cast<int>(planes.size()));
    RC_ASSERT(own.size() == whole.size());
    for (std::size_t k = 0; k < own.size(); ++k)
      RC_ASSERT(std::abs(own.eigenvalues[k] / whole.eigenvalues[k] - 1) < 1e-8);
    RC_ASSERT(own.certificate.complete == whole.certificate.complete);
  }));
}

/// Poisson's bases of the classes serve the same materials.
TEST(MirrorPlanes, OfOneShapeInManyMaterials) {
  const auto mesh = mirrored_box({0.15, 0.1, 0.008}, {6, 4, 1}, 3, {0, 1});
  std::vector<basis::ModeRequest> requests;
  for (const double ratio : {0.16, 0.2, 0.23, 0.29, 0.33, 0.35, 0.38})
    requests.push_back({{{7e10, ratio, 2500}}, {20, 20000, 60}});
  const auto solve_all = [&](bool mirror_planes) {
    core::Trace trace;
    eigen::SolveOptions options;
    options.mirror_planes = mirror_planes;
    auto out = basis::solve_materials(mesh, requests, options, MPI_COMM_SELF, "", trace);
    EXPECT_EQ(trace.stages.count("solved apart"), 0u);
    return out;
  };
  const auto own = solve_all(true), whole = solve_all(false);
  for (std::size_t r = 0; r < requests.size(); ++r) {
    ASSERT_EQ(own[r].size(), whole[r].size());
    EXPECT_EQ(own[r].certificate.mirror_planes, 2);
    EXPECT_GT(own[r].certificate.snapshots, 0);
    EXPECT_TRUE(own[r].certificate.complete);
    for (std::size_t k = 0; k < own[r].size(); ++k) {
      // Each lies within its basis' bound of a solve of its own: 0.1 cents.
      EXPECT_NEAR(own[r].frequency(k) / whole[r].frequency(k), 1, 1e-4) << k;
      EXPECT_NEAR(own[r].pitch_errors[k], whole[r].pitch_errors[k],
                  0.1 + 0.05 * whole[r].pitch_errors[k])
          << k;
    }
  }
}

/// Where symmetry is lost by a little, the whole is solved, and nothing jumps.
TEST(MirrorPlanes, AnswersAreContinuousWhereSymmetryIsLost) {
  const auto at = [](double bulge) {
    return test::moved(mirrored_box({0.1, 0.07, 0.05}, {3, 2, 2}, 3, {0, 1, 2}),
                       [bulge](const Vec3& x) -> Vec3 {
                         return x + Vec3(bulge * std::max(0.0, x.y()) * x.x(), 0, 0);
                       });
  };
  const modes::Band band{20, 1e9, 30};
  const auto own = solve(at(0), {test::steel}, band, true);
  const auto near = solve(at(1e-4), {test::steel}, band, true);
  EXPECT_EQ(own.certificate.mirror_planes, 3);
  EXPECT_EQ(near.certificate.mirror_planes, 2);
  ASSERT_EQ(own.size(), near.size());
  for (std::size_t k = 0; k < own.size(); ++k)
    EXPECT_NEAR(own.frequency(k) / near.frequency(k), 1, 1e-5) << k;
}

/// A class that loses a mode at first finds it by its own count.
TEST(MirrorPlanes, AModeLostInAClassIsFound) {
  const auto mesh = mirrored_box({0.1, 0.07, 0.05}, {4, 3, 2}, 2, {0, 1});
  eigen::SolveOptions options;
  options.band = {20, 45000, 300};
  options.estimate_errors = false;
  int losses = 0;
  eigen::SearchMethods forgetful;
  forgetful.lowest = [&losses](const assembly::System& system, const eigen::EigenRequest& request,
                               const eigen::ShiftedSystem& shifted, MPI_Comm comm) {
    auto pairs = eigen::lowest_pairs(system, request, shifted, comm);
    if (request.seed > 1 || pairs.size() < 6) return pairs;
    ++losses;
    const auto last = static_cast<std::size_t>(pairs.size() - 1);
    const std::size_t lost = 4;
    for (auto* list : {&pairs.values, &pairs.residuals, &pairs.energy_residuals})
      list->erase(list->begin() + static_cast<std::ptrdiff_t>(lost));
    std::vector<std::size_t> kept;
    for (std::size_t k = 0; k <= last; ++k) {
      if (k != lost) kept.push_back(k);
    }
    pairs.vectors = pairs.vectors(Eigen::all, kept).eval();
    pairs.mass_vectors = pairs.mass_vectors(Eigen::all, kept).eval();
    return pairs;
  };
  core::Trace trace;
  const auto own =
      eigen::solve_modes(mesh, std::vector{test::steel}, options, MPI_COMM_SELF, trace, forgetful);
  EXPECT_EQ(losses, 4);
  expect_alike(own, solve(mesh, {test::steel}, options.band, false));
}

}  // namespace
}  // namespace carillon
