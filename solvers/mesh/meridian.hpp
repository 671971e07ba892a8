#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "core/vectors.hpp"

namespace carillon::solvers::mesh {

/// A four-sided piece of a section: the image of the unit square. Blocks that share an edge name
/// the same two corners and run along it alike.
struct MeridianBlock {
  std::array<int, 4> corners;  ///< numbers of the corners at (u, v) = (0,0) (1,0) (1,1) (0,1)
  std::function<Vec2(double u, double v)> point;  ///< (radius, height) [m]
};

/// Section of a body of revolution about z: the half-plane (radius >= 0, height) cut into blocks
/// whose edges are smooth; corners of the outline are corners of blocks. Where the body is solid
/// along the axis, edges of blocks lie on it (radius exactly 0).
struct Meridian {
  std::vector<MeridianBlock> blocks;
  bool is_graded = false;  ///< towards corners that turn inward, grade_towards()
};

/// Rectangles between neighbouring radii and heights [m], ascending.
Meridian rectangular_meridian(const std::vector<double>& radii, const std::vector<double>& heights);

/// 0 and `length`, and between them the places that part a layer of 1.5 `wall` from each end: what
/// bending waves do at a free edge dies away within the wall's thickness, and wants cells of its
/// own.
std::vector<double> with_edge_layers(double length, double wall);

/// Half-disc about the origin.
Meridian ball_meridian(double radius);

/// Blocks around a corner graded towards it, each step `ratio` times smaller: for re-entrant
/// corners of the outline, where stresses are infinite and polynomials converge slowly.
void grade_towards(Meridian& meridian, int corner, int steps, double ratio = 0.15);

/// Quadrilaterals of one order on Gauss-Lobatto nodes, which lie on the true outline.
struct MeridianMesh {
  int order = 1;
  std::vector<Vec2> nodes;             ///< (radius, height) [m]; radius exactly 0 on the axis
  std::vector<std::int32_t> elements;  ///< n x (order+1)^2, u runs first; counter-clockwise
  /// Edges of the outline that make surface when turned, n x (order+1) nodes, the body to the left.
  std::vector<std::int32_t> boundary;

  std::size_t nodes_per_element() const {
    return static_cast<std::size_t>(order + 1) * static_cast<std::size_t>(order + 1);
  }
  std::size_t element_count() const { return elements.size() / nodes_per_element(); }
  std::span<const std::int32_t> element(std::size_t e) const {
    return std::span(elements).subspan(e * nodes_per_element(), nodes_per_element());
  }
};

/// Cuts the blocks into cells of at most `cell` [m] a side, alike on both sides of every shared
/// edge.
/// @param order  1 to 24
/// @throws core::SolverError  more than 200000 nodes
MeridianMesh mesh_meridian(const Meridian& meridian, int order, double cell);

/// Longest side of any block [m]; larger cells make no coarser mesh.
double longest_side(const Meridian& meridian);

/// Size of a section, from a coarse mesh of its own.
struct MeridianSize {
  double section = 0;         ///< area [m^2]
  double surface = 0;         ///< of the body [m^2]
  double volume = 0;          ///< of the body [m^3]
  double wall = 0;            ///< 2 section / length of the outline off the axis [m]
  double largest_radius = 0;  ///< [m]
  double low = 0, high = 0;   ///< heights [m]

  /// Of the body's bounding box [m].
  double longest_side() const { return std::max(2 * largest_radius, high - low); }
};
MeridianSize measure(const Meridian& meridian);

}  // namespace carillon::solvers::mesh
