#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "render/shading_mesh.hpp"
#include "solvers/modes/modes.hpp"

namespace carillon::report {

/// Of each mode the page has its decay rates when its eigenvalue is multiplied by so many factors.
inline constexpr std::size_t damping_factors = 65;

/// A surface as the page draws it: vertices, and faces over them whose nodes are those of
/// solvers::elements::triangle_lattice(order).
struct GallerySkin {
  render::ShadingMesh mesh;
  int order = 1;
  std::vector<std::uint32_t> faces;  ///< n x nodes_per_face(order)
  std::size_t modes = 0;             ///< the lowest ones, that fit beside it
};

/// The curved surface, with as many modes as fit; or a coarser one of straight triangles where more
/// fit beside that (docs/report.md).
/// @param modes  wanted
/// @param bytes  of a page, in base64
GallerySkin skin_that_fits(const solvers::modes::ModeSurface& surface, std::size_t modes,
                           std::size_t bytes);

}  // namespace carillon::report
