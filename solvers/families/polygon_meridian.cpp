#include "solvers/families/polygon_meridian.hpp"

#include <CGAL/Constrained_Delaunay_triangulation_2.h>
#include <CGAL/Delaunay_mesh_face_base_2.h>
#include <CGAL/Delaunay_mesh_size_criteria_2.h>
#include <CGAL/Delaunay_mesher_2.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Triangulation_vertex_base_with_info_2.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <utility>

namespace carillon::solvers::families {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using VertexBase = CGAL::Triangulation_vertex_base_with_info_2<int, Kernel>;
using FaceBase = CGAL::Delaunay_mesh_face_base_2<Kernel>;
using Triangulation = CGAL::Constrained_Delaunay_triangulation_2<
    Kernel, CGAL::Triangulation_data_structure_2<VertexBase, FaceBase>>;
using Criteria = CGAL::Delaunay_mesh_size_criteria_2<Triangulation>;

/// Square of the sine of the smallest angle.
constexpr double angle_bound = 0.01;
/// Corners that turn further into the body have stresses worth grading for.
constexpr double min_reentrant = 15 * std::numbers::pi / 180;
constexpr int grading_steps = 4;
/// Smaller ones need less of it, and only between long sides: others are points of a curve.
constexpr double min_slight_reentrant = std::numbers::pi / 180;
constexpr int slight_grading_steps = 2;
constexpr double long_side = 0.1;  // of the outline's extent

Vec2 at(const ProfilePolygon& profile, std::size_t i) {
  const auto& p = profile[i % profile.size()];
  return {p[0], p[1]};
}

/// Angle by which the outline (counter-clockwise) turns to the right at a point.
double right_turn(const ProfilePolygon& profile, std::size_t i) {
  const Vec2 in = at(profile, i) - at(profile, i + profile.size() - 1);
  const Vec2 out = at(profile, i + 1) - at(profile, i);
  return -std::atan2(in.x() * out.y() - in.y() * out.x(), in.dot(out));
}

/// How often the blocks around a corner are graded.
int grading_steps_at(const ProfilePolygon& profile, std::size_t i, double extent) {
  const double turn = right_turn(profile, i);
  if (turn > min_reentrant) return grading_steps;
  if (turn < min_slight_reentrant) return 0;
  const double before = (at(profile, i) - at(profile, i + profile.size() - 1)).norm();
  const double after = (at(profile, i + 1) - at(profile, i)).norm();
  return std::min(before, after) > long_side * extent ? slight_grading_steps : 0;
}

/// Diagonal of the box around an outline [m].
double extent_of(const ProfilePolygon& profile) {
  Eigen::AlignedBox2d box;
  for (std::size_t i = 0; i < profile.size(); ++i) box.extend(at(profile, i));
  return box.diagonal().norm();
}

/// Numbers corners and middles of sides, and makes blocks.
class Blocks {
 public:
  explicit Blocks(int vertices) : next_(vertices) {}

  void add(const std::array<int, 3>& number, const std::array<Vec2, 3>& corner) {
    const Vec2 centre = (corner[0] + corner[1] + corner[2]) / 3;
    const int middle = next_++;
    for (std::size_t k = 0; k < 3; ++k) {
      const std::size_t after = (k + 1) % 3, before = (k + 2) % 3;
      const Vec2 a = corner[k], b = 0.5 * (corner[k] + corner[after]), c = centre,
                 d = 0.5 * (corner[k] + corner[before]);
      meridian_.blocks.push_back(
          {{number[k], side(number[k], number[after]), middle, side(number[k], number[before])},
           [=](double u, double v) -> Vec2 {
             return (1 - v) * ((1 - u) * a + u * b) + v * ((1 - u) * d + u * c);
           }});
    }
  }

  mesh::Meridian take() { return std::move(meridian_); }

 private:
  int side(int a, int b) {
    const auto [entry, is_new] = sides_.try_emplace({std::min(a, b), std::max(a, b)}, next_);
    if (is_new) ++next_;
    return entry->second;
  }

  int next_;
  std::map<std::pair<int, int>, int> sides_;
  mesh::Meridian meridian_;
};

}  // namespace

mesh::Meridian polygon_meridian(const ProfilePolygon& profile) {
  Triangulation triangulation;
  std::vector<Triangulation::Vertex_handle> vertices;
  for (const auto& p : profile) {
    vertices.push_back(triangulation.insert(Kernel::Point_2(p[0], p[1])));
  }
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    triangulation.insert_constraint(vertices[i], vertices[(i + 1) % vertices.size()]);
  }
  CGAL::Delaunay_mesher_2<Triangulation, Criteria> refinement(triangulation,
                                                              Criteria(angle_bound, 0));
  refinement.refine_mesh();

  int count = 0;
  for (const auto vertex : triangulation.finite_vertex_handles()) vertex->info() = count++;
  Blocks blocks(count);
  for (const auto face : triangulation.finite_face_handles()) {
    if (!face->is_in_domain()) continue;
    std::array<int, 3> number{};
    std::array<Vec2, 3> corner;
    for (int k = 0; k < 3; ++k) {
      const auto i = static_cast<std::size_t>(k);
      number[i] = face->vertex(k)->info();
      corner[i] = {face->vertex(k)->point().x(), face->vertex(k)->point().y()};
    }
    blocks.add(number, corner);
  }
  mesh::Meridian out = blocks.take();
  const double extent = extent_of(profile);
  for (std::size_t i = 0; i < profile.size(); ++i)
    mesh::grade_towards(out, vertices[i]->info(), grading_steps_at(profile, i, extent));
  return out;
}

}  // namespace carillon::solvers::families
