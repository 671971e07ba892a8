#include <array>
#include <string_view>

#include "core/error.hpp"
#include "solvers/families/family.hpp"

namespace carillon::solvers::families {

mesh::MeshResult mesh_family(const mesh::GeneratedShape& shape, const mesh::MeshOptions& options) {
  const Family& family = find_family(shape.family);
  if (family.mesh != nullptr) return family.mesh(shape, options);
  struct ByGmsh {
    std::string_view name;
    decltype(Family::mesh) mesh;
  };
  constexpr std::array<ByGmsh, 5> by_gmsh = {{{"sphere", mesh_sphere},
                                              {"pebble", mesh_pebble},
                                              {"cone", mesh_cone},
                                              {"turned", mesh_turned},
                                              {"wrench", mesh_wrench}}};
  for (const ByGmsh& made : by_gmsh) {
    if (made.name == family.name) return made.mesh(shape, options);
  }
  throw core::Error("nothing makes meshes of the family " + family.name);
}

}  // namespace carillon::solvers::families
