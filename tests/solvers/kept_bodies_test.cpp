// Bodies as CAD exports them, large plane faces in a few triangles, keep their volume, their faces
// and their edges in tetrahedra of every order and size; curved ones in many triangles keep their
// volume. Prints how well (RC_PARAMS=max_success=200 for more bodies).
#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <span>
#include <string>
#include <vector>

#include "mesh_checks.hpp"
#include "prisms.hpp"
#include "solvers/mesh/tetrahedra/mesher.hpp"
#include "test_surfaces.hpp"

namespace carillon::test {
namespace {

using namespace solvers;
using mesh::SurfaceMesh;

/// Millimetres as whole numbers, drawn for a case.
double drawn(int from, int to) {
  return 1e-3 * *rc::gen::inRange(from, to + 1);
}

SurfaceMesh box() {
  const double a = drawn(20, 120), b = drawn(10, 60);
  return prism({{0, 0}, {a, 0}, {a, b}, {0, b}}, drawn(2, 30));
}

SurfaceMesh l_section() {
  const double a = drawn(20, 60), b = drawn(20, 60), s = drawn(2, 10), t = drawn(2, 10);
  return prism({{0, 0}, {a, 0}, {a, t}, {s, t}, {s, b}, {0, b}}, drawn(10, 100));
}

SurfaceMesh u_section() {
  const double a = drawn(30, 60), b = drawn(20, 60), s = drawn(2, 10), t = drawn(2, 10);
  return prism({{0, 0}, {a, 0}, {a, b}, {a - s, b}, {a - s, t}, {s, t}, {s, b}, {0, b}},
               drawn(10, 100));
}

SurfaceMesh comb() {
  const int teeth = *rc::gen::inRange(2, 7);
  const double tooth = drawn(2, 6), gap = drawn(1, 5), back = drawn(4, 12), length = drawn(10, 60);
  std::vector<Vec2> outline{{0, 0}, {teeth * tooth + (teeth - 1) * gap, 0}};
  for (int i = teeth - 1; i >= 0; --i) {
    const double left = i * (tooth + gap);
    outline.emplace_back(left + tooth, back + length);
    outline.emplace_back(left, back + length);
    if (i == 0) break;
    outline.emplace_back(left, back);
    outline.emplace_back(left - gap, back);
  }
  return prism(outline, drawn(2, 10));
}

/// A dish with a rim of 1 mm: a box with a recess.
SurfaceMesh tray() {
  const Vec3 outer(drawn(40, 120), drawn(30, 80), drawn(5, 20));
  const double rim = 1e-3, floor = drawn(1, 4);
  mesh::readers::PolygonMesh body;
  for (const double z : {0.0, outer.z(), floor})
    for (int i = 0; i < 4; ++i) {
      const double in = z == floor ? rim : 0;
      body.vertices.emplace_back(i == 1 || i == 2 ? outer.x() - in : in,
                                 i >= 2 ? outer.y() - in : in, z);
    }
  for (int i = 0; i < 4; ++i)  // the rim's inner edge
    body.vertices.emplace_back(body.vertices[static_cast<std::size_t>(8 + i)].x(),
                               body.vertices[static_cast<std::size_t>(8 + i)].y(), outer.z());
  const auto polygon = [&](std::initializer_list<std::int32_t> corners) {
    body.corners.insert(body.corners.end(), corners);
    body.end_polygon();
  };
  polygon({3, 2, 1, 0});
  polygon({8, 9, 10, 11});
  for (std::int32_t i = 0; i < 4; ++i) {
    const std::int32_t next = (i + 1) % 4;
    polygon({i, next, 4 + next, 4 + i});            // outside
    polygon({4 + i, 4 + next, 12 + next, 12 + i});  // the rim
    polygon({12 + i, 12 + next, 8 + next, 8 + i});  // inside
  }
  return mesh::readers::triangulate(std::move(body));
}

SurfaceMesh ellipsoid() {
  SurfaceMesh surface = sphere_surface(1, 16);
  const Vec3 half(drawn(10, 60), drawn(10, 60), drawn(10, 60));
  for (Vec3& v : surface.vertices) v = v.cwiseProduct(half);
  return surface;
}

SurfaceMesh torus() {
  const double tube = drawn(3, 15);
  return torus_surface(2 * tube + drawn(0, 40), tube, 32);
}

SurfaceMesh tube() {
  const double radius = drawn(10, 40);
  return tube_surface(radius, std::min(drawn(2, 8), radius / 2), drawn(20, 150), 32);
}

SurfaceMesh bowl() {
  return bowl_surface(drawn(20, 80), drawn(2, 8), 32);
}

/// A solid of revolution whose outline goes in and out.
SurfaceMesh vase() {
  std::vector<std::array<double, 2>> outline{{0, 0}};
  double height = 0;
  for (int i = *rc::gen::inRange(3, 7); i > 0; --i, height += drawn(5, 30))
    outline.push_back({drawn(10, 40), height});
  outline.push_back({0, outline.back()[1]});
  return turned_surface(outline, 24);
}

/// What was seen of many meshes.
class Seen {
 public:
  ~Seen() {
    if (angles_.empty()) return;
    std::sort(angles_.begin(), angles_.end());
    std::printf(
        "%zu bodies: volume within %.2g, Hausdorff distance within %.2g of the longest "
        "side; smallest dihedral angle %.1f degrees, of half of them above %.1f\n",
        angles_.size(), volume_error_, distance_, angles_.front(), angles_[angles_.size() / 2]);
  }
  void add(const mesh::MeshQuality& quality, double longest) {
    volume_error_ = std::max(volume_error_, std::abs(quality.volume_error));
    distance_ = std::max(distance_, quality.hausdorff / longest);
    angles_.push_back(quality.min_dihedral_deg);
  }

 private:
  double volume_error_ = 0, distance_ = 0;
  std::vector<double> angles_;
};

/// Turned so that no face lies along an axis.
SurfaceMesh turned(SurfaceMesh surface) {
  const Eigen::AngleAxisd turn(0.7, Vec3(0.3, -0.5, 0.8).normalized());
  for (Vec3& v : surface.vertices) v = turn * v;
  return surface;
}

/// A body of one of some kinds, in elements of a drawn order and size: automatic, a quarter of the
/// longest side, or one in `finest`.
mesh::MeshResult filled(std::span<SurfaceMesh (*const)()> kinds, int finest, double& longest,
                        Seen& seen) {
  const SurfaceMesh surface = turned(kinds[*rc::gen::inRange<std::size_t>(0, kinds.size())]());
  longest = mesh::bounding_box(surface.vertices).longest_side();
  mesh::MeshOptions options;
  options.order = *rc::gen::inRange(1, 5);
  options.element_size = *rc::gen::element(0.0, longest / 4, longest / finest);
  mesh::MeshResult result = mesh::tetrahedra::tetrahedralise(surface, options);
  RC_LOG() << "order " << options.order << ", size " << options.element_size << ": "
           << result.quality.elements << " elements, volume " << result.quality.volume_error
           << ", area " << result.quality.area_error << ", distance " << result.quality.hausdorff
           << ", angle " << result.quality.min_dihedral_deg << '\n';
  RC_ASSERT(mesh::signed_volume(surface) > 0);
  RC_ASSERT(mesh_faults(result.mesh) == std::string());
  seen.add(result.quality, longest);
  return result;
}

TEST(KeptBodies, PlaneFacesAndTheirEdges) {
  Seen seen;
  EXPECT_TRUE(rc::check("volume, area, distance and angles", [&seen] {
    constexpr std::array<SurfaceMesh (*)(), 5> kinds{box, l_section, u_section, comb, tray};
    double longest = 0;
    const mesh::MeshResult result = filled(kinds, 12, longest, seen);
    RC_ASSERT(std::abs(result.quality.volume_error) < 1e-10);
    RC_ASSERT(std::abs(result.quality.area_error) < 1e-10);
    RC_ASSERT(result.quality.hausdorff < 1e-10 * longest);
    RC_ASSERT(result.quality.min_dihedral_deg > 3);
  }));
}

TEST(KeptBodies, CurvedSurfaces) {
  Seen seen;
  EXPECT_TRUE(rc::check("volume and angles", [&seen] {
    constexpr std::array<SurfaceMesh (*)(), 5> kinds{ellipsoid, torus, tube, bowl, vase};
    double longest = 0;
    const mesh::MeshResult result = filled(kinds, 7, longest, seen);
    RC_ASSERT(std::abs(result.quality.volume_error) < 1e-4);
    RC_ASSERT(result.quality.hausdorff < 0.02 * longest);
    RC_ASSERT(result.quality.min_dihedral_deg > 3);
  }));
}

}  // namespace
}  // namespace carillon::test
