#include "report/detail/gallery_skin.hpp"

#include <algorithm>
#include <numeric>

#include "core/error.hpp"
#include "solvers/elements/lagrange.hpp"
#include "solvers/mesh/simplify/coarser_surface.hpp"

namespace carillon::report {

namespace {

/// Vertices of a coarser surface for each of its modes, whose waves are the shorter the more there
/// are: levels at its points are then mostly right within 1 dB.
constexpr std::size_t vertices_per_mode = 70;

constexpr double base64_size = 4.0 / 3;
constexpr double vertex_bytes = base64_size * (3 * sizeof(float) + 3);
constexpr double index_bytes = base64_size * sizeof(std::uint32_t);
constexpr double gain_bytes = base64_size * sizeof(std::int16_t);
constexpr double mode_bytes = base64_size * (2 * sizeof(double) + damping_factors * sizeof(float));
constexpr double shape_bytes = base64_size * 3;  ///< of a mode that moves, at a vertex
constexpr double colour_bytes = base64_size * 3;
constexpr double object_bytes = 2000;

double bytes_of(std::size_t vertices, std::size_t indices, std::size_t modes, bool has_colours) {
  const auto v = static_cast<double>(vertices), m = static_cast<double>(modes);
  const auto moving = static_cast<double>(std::min(modes, moving_modes));
  return object_bytes +
         v * (vertex_bytes + m * gain_bytes + moving * shape_bytes +
              (has_colours ? colour_bytes : 0)) +
         static_cast<double>(indices) * index_bytes + m * mode_bytes;
}

/// The largest number up to `maximum` that takes no more than `bytes`.
template <class BytesOf>
std::size_t that_fit(std::size_t maximum, std::size_t bytes, const BytesOf& bytes_of_so_many) {
  while (maximum > 0 && bytes_of_so_many(maximum) > static_cast<double>(bytes)) --maximum;
  return maximum;
}

/// A surface whose faces of one look come one after the other.
struct PartedSurface {
  solvers::modes::ModeSurface surface;
  std::vector<std::int32_t> of_faces;
  std::vector<std::size_t> parts;
};

PartedSurface parted(const solvers::modes::ModeSurface& surface,
                     const std::vector<std::int32_t>& of_faces, std::size_t looks) {
  const auto nodes = static_cast<std::size_t>(solvers::elements::nodes_per_face(surface.order));
  const std::size_t count = surface.faces.size() / nodes;
  std::vector<std::size_t> order(count);
  std::iota(order.begin(), order.end(), 0);
  const auto look_of = [&](std::size_t face) { return of_faces.empty() ? 0 : of_faces[face]; };
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return look_of(a) < look_of(b); });
  PartedSurface result{{surface.order, surface.nodes, {}}, {}, std::vector<std::size_t>(looks)};
  for (const std::size_t face : order) {
    const auto first = surface.faces.begin() + static_cast<std::ptrdiff_t>(face * nodes);
    result.surface.faces.insert(result.surface.faces.end(), first,
                                first + static_cast<std::ptrdiff_t>(nodes));
    result.of_faces.push_back(look_of(face));
    ++result.parts[static_cast<std::size_t>(look_of(face))];
  }
  return result;
}

/// What a coarser surface's triangles look like: as most of their corners, which are nodes of the
/// finer one; where two looks meet these have both.
std::vector<std::int32_t> looks_of_coarser(const solvers::mesh::SurfaceMesh& coarser,
                                           const PartedSurface& fine) {
  const std::size_t looks = fine.parts.size();
  const std::size_t nodes = fine.surface.faces.size() / fine.of_faces.size();
  std::vector<char> has(fine.surface.nodes.size() * looks);
  for (std::size_t n = 0; n < fine.surface.faces.size(); ++n) {
    has[static_cast<std::size_t>(fine.surface.faces[n]) * looks +
        static_cast<std::size_t>(fine.of_faces[n / nodes])] = 1;
  }
  std::vector<std::int32_t> chosen;
  for (const solvers::mesh::Triangle& triangle : coarser.triangles) {
    std::vector<int> votes(looks);
    for (const std::int32_t node : triangle) {
      for (std::size_t look = 0; look < looks; ++look) {
        votes[look] += has[static_cast<std::size_t>(node) * looks + look];
      }
    }
    chosen.push_back(
        static_cast<std::int32_t>(std::max_element(votes.begin(), votes.end()) - votes.begin()));
  }
  return chosen;
}

GallerySkin skin_of(const PartedSurface& from, std::size_t modes) {
  const solvers::modes::ModeSurface& surface = from.surface;
  const solvers::mesh::SurfaceMesh flat = solvers::modes::flatten(surface);
  GallerySkin skin{
      render::shading_mesh(flat, render::bounding_ball(flat), render::default_crease_angle),
      surface.order,
      {},
      from.parts,
      modes};
  const auto nodes = static_cast<std::size_t>(solvers::elements::nodes_per_face(surface.order));
  const auto pieces = static_cast<std::size_t>(surface.order * surface.order);
  for (std::size_t n = 0; n < surface.faces.size(); ++n) {
    // Where one of the face's triangles has the node, there is its vertex.
    std::size_t corner = n / nodes * pieces * 3;
    while (flat.triangles[corner / 3][corner % 3] != surface.faces[n]) ++corner;
    skin.faces.push_back(skin.mesh.indices[corner]);
  }
  return skin;
}

}  // namespace

GallerySkin skin_that_fits(const solvers::modes::ModeSurface& surface, const SkinRequest& request) {
  const auto [modes, bytes] = std::pair(request.modes, request.bytes);
  const auto bytes_of_so_many = [&](std::size_t vertices, std::size_t indices, std::size_t m) {
    return bytes_of(vertices, indices, m, request.has_colours);
  };
  const PartedSurface fine = parted(surface, request.of_faces, request.looks);
  GallerySkin skin = skin_of(fine, modes);
  const std::size_t vertices = skin.mesh.sources.size();
  skin.modes = that_fit(modes, bytes, [&](std::size_t m) {
    return bytes_of_so_many(vertices, skin.faces.size(), m);
  });
  // A vertex has two triangles.
  const std::size_t beside_coarser = that_fit(modes, bytes, [&](std::size_t m) {
    return bytes_of_so_many(vertices_per_mode * m, 6 * vertices_per_mode * m, m);
  });
  if (skin.modes >= beside_coarser) return skin;
  // So many vertices in all; they are split where the surface has an edge, on a coarser one more.
  const std::size_t fit = that_fit(
      vertices, bytes, [&](std::size_t v) { return bytes_of_so_many(v, 6 * v, beside_coarser); });
  const std::size_t wanted = fit * 95 / 100 * surface.nodes.size() / vertices;
  try {
    const solvers::mesh::SurfaceMesh coarser = solvers::mesh::simplify::coarser_surface(
        solvers::modes::flatten(fine.surface), wanted, render::default_crease_angle);
    solvers::modes::ModeSurface straight{1, surface.nodes, {}};
    for (const solvers::mesh::Triangle& t : coarser.triangles) {
      straight.faces.insert(straight.faces.end(), t.begin(), t.end());
    }
    return skin_of(parted(straight, looks_of_coarser(coarser, fine), request.looks),
                   beside_coarser);
  } catch (const core::InputError&) {
    return skin;  // parts that touch one another
  }
}

}  // namespace carillon::report
