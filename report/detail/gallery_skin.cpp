#include "report/detail/gallery_skin.hpp"

#include <algorithm>

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
constexpr double object_bytes = 2000;

double bytes_of(std::size_t vertices, std::size_t indices, std::size_t modes) {
  const auto v = static_cast<double>(vertices), m = static_cast<double>(modes);
  return object_bytes + v * (vertex_bytes + m * gain_bytes) +
         static_cast<double>(indices) * index_bytes + m * mode_bytes;
}

/// The largest number up to `maximum` that takes no more than `bytes`.
template <class BytesOf>
std::size_t that_fit(std::size_t maximum, std::size_t bytes, const BytesOf& bytes_of_so_many) {
  while (maximum > 0 && bytes_of_so_many(maximum) > static_cast<double>(bytes)) --maximum;
  return maximum;
}

GallerySkin skin_of(const solvers::mesh::SurfaceMesh& flat,
                    const solvers::modes::ModeSurface& surface, std::size_t modes) {
  GallerySkin skin{
      render::shading_mesh(flat, render::bounding_ball(flat), render::default_crease_angle),
      surface.order,
      {},
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

GallerySkin skin_that_fits(const solvers::modes::ModeSurface& surface, std::size_t modes,
                           std::size_t bytes) {
  const solvers::mesh::SurfaceMesh fine = solvers::modes::flatten(surface);
  GallerySkin skin = skin_of(fine, surface, modes);
  const std::size_t vertices = skin.mesh.sources.size();
  skin.modes = that_fit(modes, bytes,
                        [&](std::size_t m) { return bytes_of(vertices, skin.faces.size(), m); });
  // A vertex has two triangles.
  const std::size_t beside_coarser = that_fit(modes, bytes, [](std::size_t m) {
    return bytes_of(vertices_per_mode * m, 6 * vertices_per_mode * m, m);
  });
  if (skin.modes >= beside_coarser) return skin;
  // So many vertices in all; they are split where the surface has an edge, on a coarser one more.
  const std::size_t fit =
      that_fit(vertices, bytes, [&](std::size_t v) { return bytes_of(v, 6 * v, beside_coarser); });
  const std::size_t wanted = fit * 95 / 100 * surface.nodes.size() / vertices;
  try {
    const solvers::mesh::SurfaceMesh coarser =
        solvers::mesh::simplify::coarser_surface(fine, wanted, render::default_crease_angle);
    solvers::modes::ModeSurface straight{1, {}, {}};
    for (const solvers::mesh::Triangle& t : coarser.triangles) {
      straight.faces.insert(straight.faces.end(), t.begin(), t.end());
    }
    return skin_of(coarser, straight, beside_coarser);
  } catch (const core::InputError&) {
    return skin;  // parts that touch one another
  }
}

}  // namespace carillon::report
