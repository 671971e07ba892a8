#include "solvers/axisymmetric/detail/harmonic_surface.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

#include "solvers/elements/lobatto.hpp"

namespace carillon::solvers::axisymmetric {
namespace {

constexpr int face_order = 3;
constexpr double full_turn = 2 * std::numbers::pi;

std::size_t side_of(const mesh::MeridianMesh& mesh) {
  return static_cast<std::size_t>(mesh.order + 1);
}

const std::int32_t* edge_nodes(const mesh::MeridianMesh& mesh, std::int32_t edge) {
  return &mesh.boundary[static_cast<std::size_t>(edge) * side_of(mesh)];
}

double edge_length(const mesh::MeridianMesh& mesh, std::int32_t edge) {
  const auto* node = edge_nodes(mesh, edge);
  double length = 0;
  for (std::size_t k = 0; k + 1 < side_of(mesh); ++k) {
    length += (mesh.nodes[static_cast<std::size_t>(node[k + 1])] -
               mesh.nodes[static_cast<std::size_t>(node[k])])
                  .norm();
  }
  return length;
}

int sectors_for(int highest_harmonic) {
  return std::max(16, face_order * highest_harmonic);
}

/// Largest way along the outline that a face takes [m].
double longest_face(const mesh::MeridianMesh& mesh, double sectors) {
  double radius = 0;
  for (const auto& x : mesh.nodes) radius = std::max(radius, x.x());
  return 1.5 * full_turn * radius / sectors;
}

/// Faces that follow each other along an edge.
int parts_of(const mesh::MeridianMesh& mesh, std::int32_t edge, double longest) {
  const double wanted = std::ceil(edge_length(mesh, edge) / longest);
  return std::clamp(static_cast<int>(std::min(wanted, 1e3)), 1,
                    (mesh.order + face_order - 1) / face_order);
}

std::int32_t edge_count(const mesh::MeridianMesh& mesh) {
  return static_cast<std::int32_t>(mesh.boundary.size() / side_of(mesh));
}

}  // namespace

TurnedSize expected_surface(const mesh::MeridianMesh& mesh, double highest_harmonic) {
  const int sectors = sectors_for(static_cast<int>(std::lround(highest_harmonic)));
  const double longest = longest_face(mesh, sectors);
  TurnedSize size;
  for (std::int32_t edge = 0; edge < edge_count(mesh); ++edge)
    size.rings += face_order * parts_of(mesh, edge, longest);
  size.nodes = size.rings * face_order * sectors;
  size.faces = 2 * size.nodes / (face_order * face_order);
  return size;
}

TurnedSurface::TurnedSurface(const mesh::MeridianMesh& mesh, int highest_harmonic) : mesh_(mesh) {
  surface_.order = face_order;
  const int sectors = sectors_for(highest_harmonic);
  const double longest = longest_face(mesh, sectors);
  const int whole = face_order * sectors;

  // Rings at the ends of edges belong to the edges on both sides.
  std::map<std::int32_t, std::size_t> at_node;
  const auto end_ring = [&](std::int32_t edge, bool last) {
    const auto* nodes = edge_nodes(mesh_, edge);
    const auto node = nodes[last ? mesh_.order : 0];
    const auto known = at_node.find(node);
    if (known != at_node.end()) return known->second;
    const bool on_axis = mesh_.nodes[static_cast<std::size_t>(node)].x() == 0;
    return at_node[node] = add_ring(edge, last ? 1 : 0, on_axis ? 1 : whole);
  };
  for (std::int32_t edge = 0; edge < edge_count(mesh); ++edge) {
    const int parts = parts_of(mesh, edge, longest);
    const auto first = end_ring(edge, false), last = end_ring(edge, true);
    std::size_t before = first;
    for (int part = 0; part < parts; ++part) {
      // Rings inside of a fan have one node more in each sector than the ring nearer to the axis.
      const bool starts_on_axis = part == 0 && rings_[first].nodes.around == 1;
      const bool ends_on_axis = part == parts - 1 && rings_[last].nodes.around == 1;
      std::array<std::size_t, 4> rings{};
      rings[0] = before;
      for (int k = 1; k < face_order; ++k) {
        const double t = (part + static_cast<double>(k) / face_order) / parts;
        const int in_sector = starts_on_axis ? k : ends_on_axis ? face_order - k : face_order;
        rings[static_cast<std::size_t>(k)] = add_ring(edge, t, in_sector * sectors);
      }
      rings[3] =
          part == parts - 1 ? last : add_ring(edge, static_cast<double>(part + 1) / parts, whole);
      before = rings[3];
      if (starts_on_axis || ends_on_axis) {
        add_fan(rings, sectors, starts_on_axis);
      } else {
        add_band(rings, sectors);
      }
    }
  }
}

std::size_t TurnedSurface::add_ring(std::int32_t edge, double t, int around) {
  Ring ring{edge,
            elements::line_shapes(mesh_.order, t).values,
            {static_cast<std::int32_t>(surface_.nodes.size()), around}};
  const Vec2 place = at(ring);
  for (int k = 0; k < around; ++k) {
    const double angle = full_turn * k / around;
    surface_.nodes.emplace_back(place.x() * std::cos(angle), place.x() * std::sin(angle),
                                place.y());
  }
  rings_.push_back(std::move(ring));
  return rings_.size() - 1;
}

Vec2 TurnedSurface::at(const Ring& ring) const {
  Vec2 out = Vec2::Zero();
  const auto* node = edge_nodes(mesh_, ring.edge);
  for (Eigen::Index k = 0; k < ring.weights.size(); ++k) {
    out += ring.weights[k] * mesh_.nodes[static_cast<std::size_t>(node[k])];
  }
  return out;
}

void TurnedSurface::add_band(const std::array<std::size_t, 4>& rings, int sectors) {
  // Walking along the outline with the body to the left, "around, then along" is counter-clockwise
  // seen from outside.
  constexpr std::array<std::array<std::array<int, 2>, 3>, 2> halves = {
      {{{{0, 0}, {3, 0}, {3, 3}}}, {{{0, 0}, {3, 3}, {0, 3}}}}};
  for (int sector = 0; sector < sectors; ++sector) {
    for (const auto& corner : halves) {
      for (const auto& l : elements::triangle_lattice(face_order)) {
        const auto place = [&](std::size_t axis) {
          return (l[0] * corner[0][axis] + l[1] * corner[1][axis] + l[2] * corner[2][axis]) /
                 face_order;
        };
        const modes::NodeRing& ring = rings_[rings[static_cast<std::size_t>(place(1))]].nodes;
        surface_.faces.push_back(ring.first + (face_order * sector + place(0)) % ring.around);
      }
    }
  }
}

void TurnedSurface::add_fan(const std::array<std::size_t, 4>& rings, int sectors, bool apex_first) {
  for (int sector = 0; sector < sectors; ++sector) {
    for (const auto& l : elements::triangle_lattice(face_order)) {
      // Corner 0 is the apex; 1 and 2 follow each other around so that the face looks outward.
      const int away = face_order - l[0];
      const modes::NodeRing& ring =
          rings_[rings[static_cast<std::size_t>(apex_first ? away : l[0])]].nodes;
      const int along = apex_first ? l[1] : l[2];
      surface_.faces.push_back(ring.first + (away * sector + along) % ring.around);
    }
  }
}

std::vector<modes::NodeRing> TurnedSurface::rings() const {
  std::vector<modes::NodeRing> out;
  for (const Ring& ring : rings_) out.push_back(ring.nodes);
  return out;
}

Eigen::VectorXd TurnedSurface::amplitudes(const Eigen::Ref<const Eigen::VectorXd>& unknowns) const {
  const auto fields = cylinder_fields(unknowns);
  Eigen::VectorXd out = Eigen::VectorXd::Zero(3 * static_cast<Eigen::Index>(rings_.size()));
  for (std::size_t r = 0; r < rings_.size(); ++r) {
    const auto* node = edge_nodes(mesh_, rings_[r].edge);
    auto on_ring = out.segment<3>(3 * static_cast<Eigen::Index>(r));
    for (Eigen::Index k = 0; k < rings_[r].weights.size(); ++k) {
      on_ring += rings_[r].weights[k] *
                 Vec3(fields.radial[node[k]], fields.around[node[k]], fields.axial[node[k]]);
    }
  }
  return out;
}

}  // namespace carillon::solvers::axisymmetric
