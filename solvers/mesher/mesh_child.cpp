#include "solvers/mesher/mesh_child.hpp"

#include <fmt/core.h>

#include <string>
#include <utility>

#include "core/error.hpp"
#include "core/hash.hpp"
#include "solvers/mesh/readers/read_mesh.hpp"
#include "solvers/mesher/cached_cbor.hpp"
#include "solvers/mesher/detail/ask_child.hpp"

namespace carillon::solvers::mesher {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

/// Raised whenever the mesher or the repair would give another result for the same request.
constexpr int mesher_version = 18;

std::string subject(const mesh::MeshRequest& request) {
  return request.shape.family.empty() ? request.file.path
                                      : "generated shape \"" + request.shape.family + "\"";
}

/// Has one task done about a request.
json ask_about(const char* task, const mesh::MeshRequest& request, const ChildLimits& limits,
               const fs::path& cache = {}) {
  return ask_child({{"task", task}, {"request", mesh::to_json(request)}, {"cache", cache.string()}},
                   subject(request), limits);
}

/// SHA-256 of what is made of a request, as far as it is described.
std::string key_of(const char* what, const mesh::MeshRequest& request, json described) {
  core::Sha256 hash;
  hash.add(fmt::format("carillon {} {}; " CARILLON_MESH_LIBRARIES "; ", what, mesher_version));
  if (request.shape.family.empty()) {
    // The file counts by its contents and by its ending, which decides how it is read.
    described.erase("shape");
    described["file"].erase("path");
    if (request.file.surface.triangles.empty()) {
      hash.add(fs::path(request.file.path).extension().string() + ";");
      for (const std::string& file : mesh::readers::files_of(request.file.path, false))
        hash.add(core::sha256_file(file));
    }
  } else {
    described.erase("file");
  }
  return hash.add(described.dump()).hex();
}

std::string file_name(const mesh::MeshRequest& request) {
  return mesh_key(request) + ".mesh.cbor";
}

}  // namespace

std::string mesh_key(const mesh::MeshRequest& request) {
  return key_of("mesh", request, mesh::to_json(request));
}

std::string body_key(const mesh::MeshFile& file) {
  mesh::MeshRequest request;
  request.file = file;
  json described = mesh::to_json(request);
  described.erase("options");
  return key_of("body", request, std::move(described));
}

mesh::MeshResult mesh_in_child(const mesh::MeshRequest& request, const ChildLimits& limits,
                               const fs::path& cache) {
  const auto make = [&] {
    return mesh::mesh_result_from_json(ask_about("mesh", request, limits, cache));
  };
  if (cache.empty()) return make();
  return cached_cbor<mesh::MeshResult>(cache, file_name(request), mesh::mesh_result_from_json,
                                       make);
}

bool mesh_is_cached(const mesh::MeshRequest& request, const fs::path& cache) {
  try {
    return !cache.empty() && fs::exists(cache / file_name(request));
  } catch (const std::exception&) {
    return false;
  }
}

mesh::Diagnosis diagnose_in_child(const mesh::MeshFile& file, const ChildLimits& limits) {
  mesh::MeshRequest request;
  request.file = file;
  return mesh::diagnosis_from_json(ask_about("diagnose", request, limits));
}

}  // namespace carillon::solvers::mesher
