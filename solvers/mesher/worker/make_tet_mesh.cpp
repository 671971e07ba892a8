#include "solvers/mesher/worker/make_tet_mesh.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <string>
#include <utility>

#include "core/error.hpp"
#include "solvers/families/families.hpp"
#include "solvers/mesh/grade_to_edges.hpp"
#include "solvers/mesh/raise_order.hpp"
#include "solvers/mesh/readers/read_mesh.hpp"
#include "solvers/mesh/repair/repair.hpp"
#include "solvers/mesh/tetrahedra/mesher.hpp"
#include "solvers/mesher/cached_cbor.hpp"
#include "solvers/mesher/mesh_child.hpp"
#include "solvers/mesher/worker/read_file.hpp"

namespace carillon::solvers::mesher {
namespace {

namespace fs = std::filesystem;

mesh::MeshResult mesh_of_tetrahedra(const mesh::MeshRequest& request) {
  mesh::MeshResult result;
  result.mesh = scaled_tetrahedra(request.file);
  const auto count = static_cast<std::int64_t>(result.mesh.element_count());
  if (count > request.options.max_elements) {
    throw core::LimitError(fmt::format("{}: {} tetrahedra are more than the {} allowed",
                                       request.file.path, count, request.options.max_elements),
                           "raise max_elements, or mesh the object coarser");
  }
  if (result.mesh.order < request.options.order) {
    result.mesh = mesh::raise_order(result.mesh, request.options.order);
  }
  result.diagnosis = mesh::repair::diagnose(boundary_surface(result.mesh));
  result.quality = mesh::measure_quality(result.mesh);
  return result;
}

mesh::RepairedBody repaired_body(const mesh::MeshFile& file, const fs::path& cache) {
  const auto repair = [&file] {
    const FileSurface read = scaled_surface(file);
    mesh::RepairedBody body;
    body.surface = mesh::repair::repair(read.surface, file, body.diagnosis, body.repair);
    body.repair.joined = read.joined;
    return body;
  };
  if (cache.empty()) return repair();
  return cached_cbor<mesh::RepairedBody>(cache, body_key(file) + ".body.cbor",
                                         mesh::repaired_body_from_json, repair);
}

mesh::MeshResult mesh_of_surface(const mesh::MeshRequest& request, const fs::path& cache) {
  const mesh::RepairedBody body = repaired_body(request.file, cache);
  mesh::MeshResult result = mesh::tetrahedra::tetrahedralise(body.surface, request.options);
  result.diagnosis = body.diagnosis;
  result.repair = body.repair;
  return result;
}

/// Where layers multiply the elements by more than this, most of them are at edges, and smaller
/// elements serve as well.
constexpr double max_layer_growth = 2.5;
/// Of a mesh that is fine already, as of a scan, layers may add so many elements, or this share.
constexpr double max_added_elements = 6000, max_added_share = 0.3;

/// Puts thin layers at inward edges, as many as are asked for and have room. The elements' shapes
/// are judged without: layers are thin on purpose.
void add_edge_layers(mesh::MeshResult& result, const mesh::MeshOptions& options) {
  const auto before = static_cast<double>(result.mesh.element_count());
  const double maximum =
      std::min({static_cast<double>(options.max_elements), max_layer_growth * before,
                before + std::max(max_added_elements, max_added_share * before)});
  for (int layers = options.edge_layers; layers > 0; --layers) {
    mesh::TetMesh graded = mesh::grade_to_edges(result.mesh, layers);
    const auto count = static_cast<std::int64_t>(graded.element_count());
    if (static_cast<double>(count) > maximum) continue;
    result.mesh = std::move(graded);
    result.quality.elements = count;
    result.quality.nodes = static_cast<std::int64_t>(result.mesh.nodes.size());
    return;
  }
}

}  // namespace

mesh::MeshResult make_tet_mesh(const mesh::MeshRequest& request, const fs::path& cache) {
  if (request.options.order < 1 || request.options.order > 4) {
    throw core::InputError(
        fmt::format("order {}: elements have order 1 to 4", request.options.order));
  }
  mesh::MeshResult result;
  if (!request.shape.family.empty()) {
    families::find_family(request.shape.family).check(request.shape);
    result = families::mesh_family(request.shape, request.options);
  } else if (mesh::readers::gives_tetrahedra(request.file)) {
    return mesh_of_tetrahedra(request);
  } else {
    result = mesh_of_surface(request, cache);
  }
  add_edge_layers(result, request.options);
  return result;
}

mesh::Diagnosis diagnose_file(const mesh::MeshFile& file) {
  mesh::MeshFile any = file;
  any.any_size = true;  // a wrong unit shows in the extent
  return mesh::repair::diagnose(mesh::readers::gives_tetrahedra(file)
                                    ? boundary_surface(scaled_tetrahedra(any))
                                    : scaled_surface(any).surface);
}

}  // namespace carillon::solvers::mesher
