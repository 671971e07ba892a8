#include "dataset/plan/identities.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "core/files.hpp"
#include "core/hash.hpp"
#include "solvers/eigen/extract.hpp"
#include "solvers/mesh/readers/read_mesh.hpp"

namespace carillon::dataset::plan {

namespace {

/// Family and proportions to six digits: equal for a shape at two sizes.
std::string proportions(const solvers::mesh::GeneratedShape& shape) {
  double largest = 0;
  for (const auto& [name, value] : shape.parameters) largest = std::max(largest, std::abs(value));
  for (const auto& point : shape.profile) largest = std::max({largest, point[0], point[1]});
  std::string text = shape.family;
  const auto add = [&](double value) {
    // Adding zero turns a negative zero into zero.
    text += fmt::format(" {:.6f}", std::round(value / largest * 1e6) / 1e6 + 0.0);
  };
  for (const auto& [name, value] : shape.parameters) add(value);
  for (const auto& point : shape.profile) {
    add(point[0]);
    add(point[1]);
  }
  return text;
}

}  // namespace

FoundMesh find_mesh(const std::string& path) {
  FoundMesh found{path, core::sha256_file(path), {}, {}};
  try {
    if (solvers::mesh::readers::mesh_extension(path) == ".msh") {
      std::vector<std::int32_t> nodes;
      found.signature = solvers::mesh::shape_signature(solvers::modes::flatten(
          solvers::eigen::surface_of(solvers::mesh::readers::read_msh(path), nodes)));
    } else {
      const solvers::mesh::SurfaceMesh surface = solvers::mesh::readers::read_surface(path);
      found.signature = solvers::mesh::shape_signature(surface);
      found.surface = {solvers::mesh::bounding_box(surface.vertices), solvers::mesh::area(surface),
                       std::abs(solvers::mesh::signed_volume(surface))};
    }
  } catch (const std::exception&) {
    // No mesh: its task will say why.
  }
  return found;
}

std::vector<FoundMesh> find_meshes(const scene::Object& object) {
  std::vector<FoundMesh> found;
  for (const std::string& path : configuration::object_files(object))
    found.push_back(find_mesh(path));
  return found;
}

void decide_identities(std::span<Shape> shapes) {
  solvers::mesh::SignatureIndex signatures;
  std::vector<std::string> names;  ///< by the order of adding to `signatures`
  std::map<std::string, std::string> generated;
  for (Shape& shape : shapes) {
    if (shape.path.empty()) {
      shape.identity = generated.emplace(proportions(shape.request.shape), shape.id).first->second;
      continue;
    }
    const std::size_t first = signatures.add(shape.signature);
    names.push_back(shape.signature.empty() ? shape.sha256
                                            : solvers::mesh::signature_name(shape.signature));
    shape.identity = names[first];
  }
}

}  // namespace carillon::dataset::plan
