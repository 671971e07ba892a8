#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "render/shading_mesh.hpp"
#include "solvers/modes/modes.hpp"

namespace carillon::report {

/// Of each mode the page has its decay rates when its eigenvalue is multiplied by so many factors.
inline constexpr std::size_t damping_factors = 65;

/// So many of the lowest modes move on the page, with displacements at each vertex.
inline constexpr std::size_t moving_modes = 12;

/// A surface as the page draws it: vertices, and faces over them whose nodes are those of
/// solvers::elements::triangle_lattice(order).
struct GallerySkin {
  render::ShadingMesh mesh;
  int order = 1;
  std::vector<std::uint32_t> faces;  ///< n x nodes_per_face(order)
  std::vector<std::size_t> parts;    ///< faces of each look, one look after the other
  std::size_t modes = 0;             ///< the lowest ones, that fit beside it

  std::size_t moving() const { return std::min(modes, moving_modes); }
};

struct SkinRequest {
  std::size_t modes = 0;                 ///< wanted
  std::size_t bytes = 0;                 ///< of a page, in base64
  std::size_t looks = 1;                 ///< how many different ones the faces have
  std::vector<std::int32_t> of_faces{};  ///< look of each face; empty: all the first
  bool has_colours = false;              ///< of its own at the vertices
};

/// The curved surface, with as many modes as fit; or a coarser one of straight triangles where more
/// fit beside that (docs/report.md).
GallerySkin skin_that_fits(const solvers::modes::ModeSurface& surface, const SkinRequest& request);

}  // namespace carillon::report
