// Error estimates where edges turn inward: there the next order gains less than it misses.
#include "solvers/mesh/inward_edges.hpp"

#include <fmt/core.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "prisms.hpp"
#include "reference_bodies.hpp"
#include "solve.hpp"
#include "solvers/mesh/tetrahedra/mesher.hpp"
#include "test_meshes.hpp"

namespace carillon {
namespace {

using namespace solvers;
using test::lowest_modes;
constexpr double pi = std::numbers::pi;

TEST(InwardEdges, ExponentsAreThoseOfWilliams) {
  // Tabled in e.g. Seweryn and Molski (1996), symmetric field: 0.5445 at 270 degrees.
  EXPECT_NEAR(mesh::edge_exponent(1.5 * pi), 0.5444837, 1e-6);
  EXPECT_NEAR(mesh::edge_exponent(1.25 * pi), 0.6735834, 1e-6);
  EXPECT_NEAR(mesh::edge_exponent(2 * pi), 0.5, 1e-9);
  EXPECT_EQ(mesh::edge_exponent(pi), 1);
  EXPECT_EQ(mesh::edge_exponent(0.5 * pi), 1);
}

TEST(InwardEdges, AreFoundAtTheCornersOfElements) {
  const auto surface = test::prism({{0, 0}, {3, 0}, {3, 1}, {1, 1}, {1, 3}, {0, 3}}, 1);
  for (const int order : {1, 2, 3}) {
    mesh::MeshOptions options;
    options.order = order;
    options.element_size = 0.6;
    const auto body = mesh::tetrahedra::tetrahedralise(surface, options).mesh;
    const auto exponents = mesh::edge_exponents(body);
    std::size_t at_edge = 0;
    for (std::size_t e = 0; e < body.element_count(); ++e) {
      const auto corners = body.element(e).first(4);
      const bool touches = std::any_of(corners.begin(), corners.end(), [&](std::int32_t n) {
        return (body.nodes[static_cast<std::size_t>(n)].head<2>() - Vec2(1, 1)).norm() < 1e-9;
      });
      at_edge += touches ? 1 : 0;
      EXPECT_NEAR(exponents[e], touches ? 0.5444837 : 1, 1e-6);
    }
    EXPECT_GT(at_edge, 10u);
  }
  // Chords of a hollow are no edges.
  const auto hollow = test::shell_mesh(0.05, 0.04, 3, 1, 2);
  for (const double exponent : mesh::edge_exponents(hollow)) EXPECT_EQ(exponent, 1);
}

/// Places from one end to the other, at most `step` apart, that crowd towards marked breaks.
std::vector<double> graded_lines(const std::vector<double>& breaks,
                                 const std::vector<double>& inward, double step) {
  constexpr int levels = 4;
  constexpr double factor = 0.2;
  std::vector<double> lines;
  for (std::size_t i = 0; i + 1 < breaks.size(); ++i) {
    const double from = breaks[i], to = breaks[i + 1], length = to - from;
    const auto crowds = [&](double at) {
      return std::find(inward.begin(), inward.end(), at) != inward.end();
    };
    std::vector<double> inside;
    const double reach = crowds(from) && crowds(to) ? length / 2 : std::min(length, step);
    for (int level = 1; level <= levels; ++level) {
      if (crowds(from)) inside.push_back(from + reach * std::pow(factor, level));
      if (crowds(to)) inside.push_back(to - reach * std::pow(factor, level));
    }
    const int parts = std::max(1, static_cast<int>(std::ceil(length / step)));
    for (int k = 1; k < parts; ++k) inside.push_back(from + length * k / parts);
    std::sort(inside.begin(), inside.end());
    lines.push_back(from);
    for (const double at : inside)
      if (at - lines.back() > 1e-3 * length * std::pow(factor, levels - 1)) lines.push_back(at);
  }
  lines.push_back(breaks.back());
  return lines;
}

/// A right-angled outline and the lines of its grid, x and y.
struct Section {
  std::string name;
  std::vector<Vec2> outline;  ///< [mm], counter-clockwise
  std::vector<double> x, y, inward_x, inward_y;
  double height;  ///< [mm]
};

const std::vector<Section>& sections() {
  static const std::vector<Section> all{
      {"L",
       {{0, 0}, {60, 0}, {60, 10}, {10, 10}, {10, 50}, {0, 50}},
       {0, 10, 60},
       {0, 10, 50},
       {10},
       {10},
       20},
      {"U",
       {{0, 0}, {50, 0}, {50, 60}, {42, 60}, {42, 10}, {8, 10}, {8, 60}, {0, 60}},
       {0, 8, 42, 50},
       {0, 10, 60},
       {8, 42},
       {10},
       12},
      {"T",
       {{0, 40}, {0, 30}, {24, 30}, {24, 0}, {36, 0}, {36, 30}, {60, 30}, {60, 40}},
       {0, 24, 36, 60},
       {0, 30, 40},
       {24, 36},
       {30},
       15},
      {"step",
       {{0, 0}, {80, 0}, {80, 6}, {40, 6}, {40, 20}, {0, 20}},
       {0, 40, 80},
       {0, 6, 20},
       {40},
       {6},
       20}};
  return all;
}

bool is_inside(const std::vector<Vec2>& outline, const Vec2& p) {
  bool inside = false;
  for (std::size_t i = 0; i < outline.size(); ++i) {
    const Vec2& a = outline[i];
    const Vec2& b = outline[(i + 1) % outline.size()];
    if ((a.y() > p.y()) != (b.y() > p.y()) &&
        p.x() < a.x() + (p.y() - a.y()) / (b.y() - a.y()) * (b.x() - a.x()))
      inside = !inside;
  }
  return inside;
}

/// Elements of order 4 on a grid that crowds geometrically at inward edges, where their errors fall
/// exponentially (Babuska and Guo 1988).
std::vector<double> truth_of(const Section& section, std::size_t count) {
  constexpr double step = 7;
  const auto x = graded_lines(section.x, section.inward_x, step);
  const auto y = graded_lines(section.y, section.inward_y, step);
  const auto nx = static_cast<int>(x.size()) - 1, ny = static_cast<int>(y.size()) - 1;
  const int nz = std::max(2, static_cast<int>(std::ceil(section.height / step)));
  const auto place = [](const std::vector<double>& lines, double at) {
    const auto cell = std::min(static_cast<std::size_t>(at), lines.size() - 2);
    return lines[cell] + (at - static_cast<double>(cell)) * (lines[cell + 1] - lines[cell]);
  };
  mesh::TetMesh grid = test::box_mesh(Vec3(nx, ny, nz), {nx, ny, nz}, 1, [&](const Vec3& middle) {
    return is_inside(section.outline, {place(x, middle.x()), place(y, middle.y())}) ? 0 : 1;
  });
  mesh::TetMesh body;
  body.nodes = grid.nodes;
  body.region_names = {"body"};
  for (std::size_t e = 0; e < grid.element_count(); ++e) {
    if (grid.regions[e] != 0) continue;
    body.elements.insert(body.elements.end(), grid.element(e).begin(), grid.element(e).end());
    body.regions.push_back(0);
  }
  mesh::drop_unused_nodes(body);
  for (Vec3& n : body.nodes)
    n = 1e-3 * Vec3(place(x, n.x()), place(y, n.y()), n.z() * section.height / nz);
  const auto modes =
      lowest_modes(test::with_order(body, 4), {test::steel}, static_cast<int>(count));
  return test::frequencies(modes);
}

/// The lowest modes of a section in the mesher's own elements against the truth.
void expect_true_estimates(const Section& section, std::initializer_list<int> orders) {
  constexpr std::size_t count = 12;
  const auto truth = truth_of(section, count);
  std::vector<Vec2> outline;
  for (const Vec2& p : section.outline) outline.push_back(1e-3 * p);
  const auto surface = test::prism(outline, 1e-3 * section.height);
  for (const int order : orders) {
    mesh::MeshOptions options;
    options.order = order;
    const auto body = mesh::tetrahedra::tetrahedralise(surface, options).mesh;
    const auto modes = lowest_modes(body, {test::steel}, static_cast<int>(3 * count / 2));
    const auto found = test::measure_effectivity(modes, truth);
    fmt::print("{:5} order {}: worst {:6.2f} cents, effectivity {:.2f} {:.2f} {:.2f} of {} modes\n",
               section.name, order, found.worst_error, found.least, found.median, found.most,
               found.compared);
    EXPECT_GT(found.compared, count / 2);
    EXPECT_GT(found.worst_error, 3);
    EXPECT_EQ(found.complaint, "") << section.name;
  }
}

TEST(InwardEdges, EstimatesOfAnAngleAreTrue) {
  expect_true_estimates(sections().front(), {3});
}

TEST(InwardEdges, EstimatesOfAllSectionsAreTrue) {
  for (const Section& section : sections()) expect_true_estimates(section, {2, 3, 4});
}

}  // namespace
}  // namespace carillon
