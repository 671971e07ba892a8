#include "synth/surface/outer_surface.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <span>

#include "core/error.hpp"
#include "solvers/elements/lagrange.hpp"
#include "solvers/elements/quadrature.hpp"

namespace carillon::synth::surface {

namespace {

std::size_t face_count(const solvers::modes::ModeSurface& surface) {
  const auto per_face = static_cast<std::size_t>(solvers::elements::nodes_per_face(surface.order));
  if (surface.faces.size() % per_face != 0) {
    throw core::InputError(
        fmt::format("surface of order {}: {} face nodes are not a multiple of {}", surface.order,
                    surface.faces.size(), per_face));
  }
  return surface.faces.size() / per_face;
}

Vec3 node(const solvers::modes::ModeSurface& surface, std::int32_t index) {
  return surface.nodes[static_cast<std::size_t>(index)];
}

}  // namespace

std::vector<FacePiece> face_pieces(int order) {
  const auto& lattice = solvers::elements::triangle_lattice(order);
  const auto corner = [&](int first, int second) {
    const std::array<int, 3> place = {order - first - second, first, second};
    const auto found = std::find(lattice.begin(), lattice.end(), place);
    return static_cast<int>(found - lattice.begin());
  };
  std::vector<FacePiece> pieces;
  const auto add = [&](int a, int b, int c) {
    FacePiece piece{{a, b, c}, {}};
    for (std::size_t k = 0; k < 3; ++k) {
      const auto& place = lattice[static_cast<std::size_t>(piece.nodes[k])];
      piece.corners[k] = Eigen::Vector3d(place[0], place[1], place[2]) / order;
    }
    pieces.push_back(piece);
  };
  for (int i = 0; i < order; ++i) {
    for (int j = 0; i + j < order; ++j) {
      add(corner(i, j), corner(i + 1, j), corner(i, j + 1));
      if (i + j + 2 <= order) add(corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1));
    }
  }
  return pieces;
}

std::span<const std::int32_t> face_nodes(const solvers::modes::ModeSurface& surface,
                                         std::int32_t face) {
  const auto per_face = static_cast<std::size_t>(solvers::elements::nodes_per_face(surface.order));
  const std::size_t count = surface.faces.size() / per_face;
  if (face < 0 || static_cast<std::size_t>(face) >= count) {
    throw core::InputError(
        fmt::format("surface point: face {} does not exist (there are {})", face, count));
  }
  return std::span(surface.faces).subspan(static_cast<std::size_t>(face) * per_face, per_face);
}

std::vector<bool> outer_faces(const solvers::modes::ModeSurface& surface) {
  const std::size_t faces = face_count(surface);
  if (faces == 0) return {};
  std::vector<solvers::mesh::Triangle> corners(faces);
  for (std::size_t face = 0; face < faces; ++face) {
    const auto nodes = face_nodes(surface, static_cast<std::int32_t>(face));
    corners[face] = {nodes[0], nodes[1], nodes[2]};
  }
  const std::vector<std::int32_t> component = solvers::mesh::edge_components(corners);
  const auto components =
      static_cast<std::size_t>(*std::max_element(component.begin(), component.end())) + 1;
  // Relative to a point of each component: far from the origin the volumes would cancel.
  std::vector<double> volume(components, 0.0);
  std::vector<Vec3> origin(components, Vec3::Constant(0));
  std::vector<bool> has_origin(components, false);
  const std::vector<FacePiece> pieces = face_pieces(surface.order);
  for (std::size_t face = 0; face < faces; ++face) {
    const auto nodes = face_nodes(surface, static_cast<std::int32_t>(face));
    const auto c = static_cast<std::size_t>(component[face]);
    if (!has_origin[c]) origin[c] = node(surface, nodes[0]);
    has_origin[c] = true;
    for (const FacePiece& piece : pieces) {
      std::array<Vec3, 3> p;
      for (std::size_t k = 0; k < 3; ++k) {
        p[k] = node(surface, nodes[static_cast<std::size_t>(piece.nodes[k])]) - origin[c];
      }
      volume[c] += p[0].dot(p[1].cross(p[2])) / 6;
    }
  }
  std::vector<bool> outer(faces);
  for (std::size_t face = 0; face < faces; ++face) {
    outer[face] = volume[static_cast<std::size_t>(component[face])] > 0;
  }
  return outer;
}

std::vector<SurfaceTriangle> outer_pieces(const solvers::modes::ModeSurface& surface) {
  const std::vector<FacePiece> cut = face_pieces(surface.order);
  const std::vector<bool> outer = outer_faces(surface);
  std::vector<SurfaceTriangle> triangles;
  for (std::size_t f = 0; f < outer.size(); ++f) {
    if (!outer[f]) continue;
    const auto face = static_cast<std::int32_t>(f);
    const auto nodes = face_nodes(surface, face);
    for (const FacePiece& piece : cut) {
      SurfaceTriangle triangle{face, piece.corners, {}};
      for (std::size_t k = 0; k < 3; ++k) {
        triangle.positions[k] = node(surface, nodes[static_cast<std::size_t>(piece.nodes[k])]);
      }
      triangles.push_back(triangle);
    }
  }
  return triangles;
}

Vec3 area_vector(const SurfaceTriangle& triangle) {
  const auto& [a, b, c] = triangle.positions;
  return (b - a).cross(c - a) / 2;
}

OuterHull outer_hull(const solvers::modes::ModeSurface& surface) {
  const std::vector<bool> outer = outer_faces(surface);
  if (std::find(outer.begin(), outer.end(), true) == outer.end()) {
    throw core::InputError("the object has no outer surface: no faces, or all of them look inward");
  }
  const int order = surface.order;
  const auto per_face = static_cast<Eigen::Index>(solvers::elements::nodes_per_face(order));

  // Products of Gauss rules on the triangle (u, (1 - u) v). Positions have degree p, normals
  // 2 p - 2, so that x (x . n) has 4 p - 2.
  const int points = 2 * order;
  const auto& rule = solvers::elements::triangle_rule(points);
  const auto samples = static_cast<Eigen::Index>(rule.size());
  Eigen::MatrixXd values(samples, per_face);
  Eigen::MatrixXd along_first(samples, per_face);
  Eigen::MatrixXd along_second(samples, per_face);
  for (Eigen::Index sample = 0; sample < samples; ++sample) {
    Eigen::Matrix<double, Eigen::Dynamic, 3> gradient;
    values.row(sample) = solvers::elements::triangle_shape_functions(
                             order, rule.barycentric[static_cast<std::size_t>(sample)], &gradient)
                             .transpose();
    along_first.row(sample) = (gradient.col(1) - gradient.col(0)).transpose();
    along_second.row(sample) = (gradient.col(2) - gradient.col(0)).transpose();
  }

  OuterHull hull;
  hull.volume_weights = Eigen::VectorXd::Zero(3 * static_cast<Eigen::Index>(surface.nodes.size()));
  Vec3 origin = Vec3::Constant(0);
  bool has_origin = false;
  double volume = 0;
  Vec3 moment = Vec3::Constant(0);
  Eigen::MatrixX3d local(per_face, 3);
  for (std::size_t face = 0; face < outer.size(); ++face) {
    if (!outer[face]) continue;
    const auto nodes = face_nodes(surface, static_cast<std::int32_t>(face));
    if (!has_origin) origin = node(surface, nodes[0]);
    has_origin = true;
    for (Eigen::Index a = 0; a < per_face; ++a) {
      local.row(a) = (node(surface, nodes[static_cast<std::size_t>(a)]) - origin).transpose();
    }
    for (Eigen::Index sample = 0; sample < samples; ++sample) {
      const Vec3 position = local.transpose() * values.row(sample).transpose();
      const Vec3 first = local.transpose() * along_first.row(sample).transpose();
      const Vec3 second = local.transpose() * along_second.row(sample).transpose();
      const Vec3 area = rule.weights[static_cast<std::size_t>(sample)] * first.cross(second);
      for (Eigen::Index a = 0; a < per_face; ++a) {
        hull.volume_weights.segment<3>(3 * nodes[static_cast<std::size_t>(a)]) +=
            values(sample, a) * area;
      }
      // Gauss' theorem with fields x / 3 and x_k x / 4.
      const double flux = position.dot(area);
      volume += flux / 3;
      moment += position * (flux / 4);
    }
  }
  hull.centroid = origin + moment / volume;
  for (std::size_t face = 0; face < outer.size(); ++face) {
    if (!outer[face]) continue;
    for (const std::int32_t index : face_nodes(surface, static_cast<std::int32_t>(face))) {
      hull.radius = std::max(hull.radius, (node(surface, index) - hull.centroid).norm());
    }
  }
  return hull;
}

}  // namespace carillon::synth::surface
