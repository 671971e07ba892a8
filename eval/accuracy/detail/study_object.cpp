#include "eval/accuracy/detail/study_object.hpp"

#include "solvers/families/families.hpp"

namespace carillon::eval::accuracy {

solvers::mesh::MeshRequest only_mesh(const core::ConfigNode& node, const scene::Object& object) {
  if (object.modelnet) {
    node.fail("modelnet", "a study takes single objects", "name one of its files: `mesh:`");
  }
  solvers::mesh::MeshRequest request =
      core::at_key(node, "parameters", [&] { return scene::mesh_request(object); });
  if (object.family.empty()) return request;
  if (object.file.length > 0) solvers::families::scale_to(request.shape, object.file.length);
  core::at_key(node, "shape", [&] {
    scene::check_size(solvers::families::extent_of(request.shape).longest_side,
                      object.file.any_size);
  });
  return request;
}

std::string only_material(const core::ConfigNode& node, const scene::Object& object) {
  if (object.materials.size() != 1) {
    node.fail("materials", "a study takes each object in one material");
  }
  return object.materials.front();
}

}  // namespace carillon::eval::accuracy
