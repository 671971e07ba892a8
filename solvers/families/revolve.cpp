#include "solvers/families/revolve.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

#include "solvers/families/extrude.hpp"
#include "solvers/mesh/sizing.hpp"

namespace carillon::solvers::families {
namespace {

constexpr double full_turn = 2 * std::numbers::pi;
/// A profile that turns by more keeps a ring of vertices there.
constexpr double corner_angle = 20 * std::numbers::pi / 180;
/// So does a smaller corner between edges of a cell or so: elements over it would miss what lies
/// about it at every order. Those of shorter edges are points of a curve.
constexpr double small_corner_angle = std::numbers::pi / 180;
constexpr double long_edge = 0.4;  // of a cell

Vec2 at(const ProfilePolygon& profile, std::size_t i) {
  const auto& p = profile[i % profile.size()];
  return {p[0], p[1]};
}

double cross(const Vec2& a, const Vec2& b) {
  return a.x() * b.y() - a.y() * b.x();
}

/// Pieces of the outline that make surface: from axis to axis, or the whole outline (first point
/// repeated at the end).
std::vector<std::vector<Vec2>> surface_chains(const ProfilePolygon& profile) {
  const std::size_t n = profile.size();
  const auto on_axis = [&](std::size_t i) {
    return profile[i % n][0] == 0 && profile[(i + 1) % n][0] == 0;
  };
  std::vector<std::vector<Vec2>> chains;
  for (std::size_t i = 0; i < n; ++i) {
    if (on_axis(i) || !on_axis(i + n - 1)) continue;
    chains.emplace_back();
    std::size_t k = i;
    for (; !on_axis(k); ++k) chains.back().push_back(at(profile, k));
    chains.back().push_back(at(profile, k));
  }
  if (chains.empty()) {
    chains.emplace_back();
    for (std::size_t i = 0; i <= n; ++i) chains.back().push_back(at(profile, i));
  }
  return chains;
}

/// Thickness of the section under the middle of an edge, straight in.
double thickness_below(const ProfilePolygon& profile, const Vec2& a, const Vec2& b) {
  const Vec2 origin = 0.5 * (a + b), inward = Vec2(a.y() - b.y(), b.x() - a.x()).normalized();
  double nearest = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < profile.size(); ++i) {
    const Vec2 p = at(profile, i), along = at(profile, i + 1) - p;
    const double determinant = cross(inward, along);
    if (std::abs(determinant) < 1e-15 * along.norm()) continue;
    const double reach = cross(p - origin, along) / determinant;
    const double within = cross(p - origin, inward) / determinant;
    if (reach <= 1e-9 * along.norm() || within < 0 || within > 1) continue;
    const bool axis = p.x() == 0 && at(profile, i + 1).x() == 0;
    nearest = std::min(nearest, axis ? 2 * reach : reach);
  }
  return nearest;
}

/// A ring of vertices: where on the half-plane, how many around.
struct Ring {
  Vec2 at;
  int around;  ///< 1 on the axis
  std::int32_t first = 0;
};

/// What the walk along a chain needs of each of its edges.
struct ChainEdge {
  double length, thickness;
  Vec2 tangent;
};

std::vector<ChainEdge> measure(const ProfilePolygon& profile, const std::vector<Vec2>& chain) {
  std::vector<ChainEdge> edges;
  for (std::size_t i = 0; i + 1 < chain.size(); ++i) {
    const Vec2 d = chain[i + 1] - chain[i];
    edges.push_back({d.norm(), thickness_below(profile, chain[i], chain[i + 1]), d.normalized()});
  }
  return edges;
}

int count_around(double radius, double cell, const ChainEdge& before, const ChainEdge& after) {
  if (radius == 0) return 1;
  // Only the part of the normal that turns with the angle asks for more vertices.
  const double turning = std::max(std::abs(before.tangent.y()), std::abs(after.tangent.y()));
  const double thin = std::min(before.thickness, after.thickness);
  const double chord = std::min(cell, mesh::max_chord(radius / std::max(turning, 1e-3), thin));
  return std::max(6, static_cast<int>(std::ceil(full_turn * radius / chord)));
}

/// Rings along a chain: at its ends and corners, and between them by size and bending.
std::vector<Ring> place_rings(const ProfilePolygon& profile, const std::vector<Vec2>& chain,
                              double cell) {
  const auto edges = measure(profile, chain);
  const bool closed = chain.front() == chain.back();
  const auto before = [&](std::size_t vertex) -> const ChainEdge& {
    return edges[(vertex + edges.size() - 1) % edges.size()];
  };
  const auto after = [&](std::size_t vertex) -> const ChainEdge& {
    return edges[vertex % edges.size()];
  };
  const auto bend = [&](std::size_t vertex) {
    if (!closed && (vertex == 0 || vertex == edges.size())) return std::numbers::pi;
    const Vec2 &in = before(vertex).tangent, &out = after(vertex).tangent;
    return std::abs(std::atan2(cross(in, out), in.dot(out)));
  };
  const auto is_corner = [&](std::size_t vertex) {
    const double angle = bend(vertex);
    if (angle >= corner_angle) return true;
    return angle > small_corner_angle &&
           std::min(before(vertex).length, after(vertex).length) > long_edge * cell;
  };
  // Cumulated number of rings wanted up to each vertex.
  std::vector<double> wanted{0};
  for (std::size_t i = 0; i < edges.size(); ++i) {
    double turning = 0;  // half of a gentle bend belongs to each of its edges
    for (std::size_t vertex : {i, i + 1})
      if (!is_corner(vertex)) turning += 0.5 * bend(vertex);
    double longest = cell;
    if (turning > 1e-9)
      longest = std::min(longest, mesh::max_chord(edges[i].length / turning, edges[i].thickness));
    wanted.push_back(wanted.back() + edges[i].length / longest);
  }
  std::vector<Ring> rings;
  const auto add = [&](std::size_t edge, double fraction) {
    const Vec2 p = fraction <= 0 ? chain[edge]
                                 : Vec2((1 - fraction) * chain[edge] + fraction * chain[edge + 1]);
    const bool at_vertex = fraction <= 0 && (edge > 0 || closed);
    rings.push_back(
        {p, count_around(p.x(), cell, at_vertex ? before(edge) : edges[edge], edges[edge])});
  };
  std::size_t start = 0;
  while (start < edges.size()) {
    std::size_t end = start + 1;
    while (end < edges.size() && !is_corner(end)) ++end;
    const double span = wanted[end] - wanted[start];
    const bool whole_loop = closed && start == 0 && end == edges.size() && !is_corner(0);
    const int parts = std::max(whole_loop ? 6 : 1, static_cast<int>(std::ceil(span * (1 - 1e-9))));
    add(start, 0);
    std::size_t edge = start;
    for (int k = 1; k < parts; ++k) {
      const double goal = wanted[start] + span * k / parts;
      while (wanted[edge + 1] < goal) ++edge;
      add(edge, (goal - wanted[edge]) / (wanted[edge + 1] - wanted[edge]));
    }
    start = end;
  }
  if (closed)
    rings.push_back(rings.front());
  else
    rings.push_back(
        {chain.back(), count_around(chain.back().x(), cell, edges.back(), edges.back())});
  return rings;
}

/// Triangles between two rings with different numbers of vertices: always the shorter step on.
void stitch(mesh::SurfaceMesh& mesh, const Ring& lower, const Ring& upper) {
  const int m = lower.around, n = upper.around;
  const auto on = [](const Ring& ring, int k) { return ring.first + k % ring.around; };
  int i = 0, j = 0;
  const int steps_lower = m == 1 ? 0 : m, steps_upper = n == 1 ? 0 : n;
  while (i < steps_lower || j < steps_upper) {
    const bool step_lower =
        j == steps_upper || (i < steps_lower && (2 * i + 1) * static_cast<std::int64_t>(n) <=
                                                    (2 * j + 1) * static_cast<std::int64_t>(m));
    if (step_lower) {
      mesh.triangles.push_back({on(lower, i), on(lower, i + 1), on(upper, j)});
      ++i;
    } else {
      mesh.triangles.push_back({on(lower, i), on(upper, j + 1), on(upper, j)});
      ++j;
    }
  }
}

}  // namespace

mesh::SurfaceMesh revolve(const ProfilePolygon& profile, double cell) {
  mesh::SurfaceMesh mesh;
  for (const auto& chain : surface_chains(profile)) {
    auto rings = place_rings(profile, chain, cell);
    const bool closed = chain.front() == chain.back();
    for (std::size_t i = 0; i < rings.size(); ++i) {
      auto& ring = rings[i];
      if (closed && i + 1 == rings.size()) {
        ring.first = rings.front().first;
        break;
      }
      ring.first = static_cast<std::int32_t>(mesh.vertices.size());
      for (int k = 0; k < ring.around; ++k) {
        const double angle = full_turn * k / ring.around;
        mesh.vertices.emplace_back(ring.at.x() * std::cos(angle), ring.at.x() * std::sin(angle),
                                   ring.at.y());
      }
    }
    for (std::size_t i = 0; i + 1 < rings.size(); ++i) stitch(mesh, rings[i], rings[i + 1]);
  }
  return mesh;
}

mesh::SurfaceProjection project_to_turned(const ProfilePolygon& profile) {
  struct Segment {
    Vec2 from, along, outward;
    double squared;
  };
  std::vector<Segment> segments;
  for (const auto& chain : surface_chains(profile))
    for (std::size_t i = 0; i + 1 < chain.size(); ++i) {
      const Vec2 d = chain[i + 1] - chain[i];
      segments.push_back({chain[i], d, Vec2(d.y(), -d.x()).normalized(), d.squaredNorm()});
    }
  const auto to_surface = [segments](const Vec3& point, const Vec3& normal) -> Vec3 {
    const double radius = point.head<2>().norm();
    const Vec2 spoke = radius > 0 ? Vec2(point.head<2>() / radius) : Vec2(1, 0);
    const Vec2 p(radius, point.z());
    const Vec2 facing(normal.head<2>().dot(spoke), normal.z());
    double nearest = std::numeric_limits<double>::infinity();
    Vec2 best = p;
    for (const auto& segment : segments) {
      if (segment.outward.dot(facing) <= 0) continue;
      const double u =
          std::clamp((p - segment.from).dot(segment.along) / segment.squared, 0.0, 1.0);
      const Vec2 q = segment.from + u * segment.along;
      if ((q - p).squaredNorm() < nearest) {
        nearest = (q - p).squaredNorm();
        best = q;
      }
    }
    return {best.x() * spoke.x(), best.x() * spoke.y(), best.y()};
  };
  // Lines are the circles of the profile's corners.
  const auto to_line = [profile](const Vec3& from, const Vec3& to,
                                 const Vec3& between) -> std::optional<Vec3> {
    const double radius = between.head<2>().norm();
    for (const auto& corner : profile) {
      const double r = corner[0], z = corner[1];
      const auto on_circle = [&, tolerance = 1e-9 * (to - from).norm()](const Vec3& p) {
        return std::hypot(p.head<2>().norm() - r, p.z() - z) < tolerance;
      };
      if (radius > 0 && on_circle(from) && on_circle(to))
        return Vec3(r / radius * between.x(), r / radius * between.y(), z);
    }
    return std::nullopt;
  };
  // All but what is flat, such as a side between vertices of one circle that crosses an end's face.
  constexpr double any_angle = 1e-3;
  return {to_surface, to_line, any_angle};
}

double turned_volume(const ProfilePolygon& profile) {
  double sum = 0;
  for (std::size_t i = 0; i < profile.size(); ++i) {
    const Vec2 a = at(profile, i), b = at(profile, i + 1);
    sum += std::numbers::pi / 3 * (b.y() - a.y()) * (a.x() * a.x() + a.x() * b.x() + b.x() * b.x());
  }
  return sum;
}

double turned_area(const ProfilePolygon& profile) {
  double sum = 0;
  for (std::size_t i = 0; i < profile.size(); ++i) {
    const Vec2 a = at(profile, i), b = at(profile, i + 1);
    sum += std::numbers::pi * (a.x() + b.x()) * (b - a).norm();
  }
  return sum;
}

}  // namespace carillon::solvers::families
