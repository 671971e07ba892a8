#include "dataset/run/shared_meshes.hpp"

#include <fmt/format.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <set>

#include "core/files.hpp"
#include "core/hash.hpp"
#include "mpi/comm.hpp"

namespace carillon::dataset::run {

using nlohmann::json;

namespace {

// Between ranks as CBOR, which keeps every number to the last bit, infinite ones too.

std::string to_message(const json& value) {
  std::string message;
  json::to_cbor(value, message);
  return message;
}

json to_json(const plan::FoundMesh& mesh) {
  json found = {{"path", mesh.path},
                {"sha256", mesh.sha256},
                {"signature", mesh.signature},
                {"node", mesh.node}};
  if (mesh.surface) {
    const solvers::mesh::Box& box = mesh.surface->bounds;
    found["surface"] = {box.low.x(),        box.low.y(),          box.low.z(),
                        box.high.x(),       box.high.y(),         box.high.z(),
                        mesh.surface->area, mesh.surface->volume, mesh.surface->unit};
  }
  return found;
}

plan::FoundMesh mesh_from_json(const json& found) {
  plan::FoundMesh mesh{found.at("path"),
                       found.at("sha256"),
                       found.at("signature").get<solvers::mesh::ShapeSignature>(),
                       {},
                       found.at("node")};
  if (found.contains("surface")) {
    const auto v = found.at("surface").get<std::vector<double>>();
    mesh.surface = {v[8], {{v[0], v[1], v[2]}, {v[3], v[4], v[5]}}, v[6], v[7]};
  }
  return mesh;
}

json to_json(const plan::FoundFile& file) {
  json nodes = json::array();
  for (const plan::FoundMesh& node : file.nodes) nodes.push_back(to_json(node));
  return {{"whole", to_json(file.whole)}, {"nodes", nodes}};
}

plan::FoundFile from_json(const json& in) {
  plan::FoundFile file{mesh_from_json(in.at("whole")), {}};
  for (const json& node : in.at("nodes")) file.nodes.push_back(mesh_from_json(node));
  return file;
}

/// Paths by files_key(), as rank 0 sees them.
std::map<std::string, std::vector<std::string>> look_up(std::span<const LoadedBuild> builds,
                                                        MPI_Comm world) {
  std::map<std::string, std::vector<std::string>> paths;
  mpi::agreed(world, [&] {
    if (mpi::rank(world) != 0) return;
    for (const LoadedBuild& build : builds) {
      for (const configuration::ObjectSource& source : build.config.objects) {
        const scene::Object& object = source.object;
        if (!object.family.empty() || paths.contains(configuration::files_key(object))) continue;
        paths[configuration::files_key(object)] = configuration::object_files(object);
      }
    }
  });
  return json::from_cbor(mpi::broadcast(to_message(paths), 0, world));
}

/// Every rank reads its share of the files; all have what was found.
std::map<std::string, plan::FoundFile> read_together(const std::set<std::string>& paths,
                                                     MPI_Comm world) {
  json own = json::array();
  mpi::agreed(world, [&] {
    std::vector<std::string> share;
    int turn = 0;
    for (const std::string& path : paths) {
      if (turn++ % mpi::size(world) == mpi::rank(world)) share.push_back(path);
    }
    for (const plan::FoundFile& file : plan::find_files(share)) own.push_back(to_json(file));
  });
  std::map<std::string, plan::FoundFile> files;
  for (const std::string& message : mpi::all_gather(to_message(own), world)) {
    for (const json& found : json::from_cbor(message)) {
      plan::FoundFile file = from_json(found);
      files.emplace(file.whole.path, std::move(file));
    }
  }
  return files;
}

/// The files that a rank did not read are there for it too.
void check_sizes(const std::set<std::string>& paths, MPI_Comm world) {
  core::Sha256 seen;
  for (const std::string& path : paths) {
    std::error_code error;
    seen.add(fmt::format("{};", std::filesystem::file_size(path, error)));
  }
  check_alike(seen.hex(), world);
}

}  // namespace

SharedMeshes::SharedMeshes(std::span<const LoadedBuild> builds, MPI_Comm world) {
  const auto by_key = look_up(builds, world);
  std::set<std::string> paths;
  for (const auto& [key, found] : by_key) paths.insert(found.begin(), found.end());
  const std::map<std::string, plan::FoundFile> files = read_together(paths, world);
  check_sizes(paths, world);
  for (const auto& [key, found] : by_key) {
    std::vector<plan::FoundFile>& list = by_key_[key];
    for (const std::string& path : found) list.push_back(files.at(path));
  }
}

plan::FindMeshes SharedMeshes::of(const configuration::BuildConfig& config) const {
  return [this, &config](std::size_t index) {
    const scene::Object& object = config.objects[index].object;
    std::vector<plan::FoundMesh> found;
    for (const plan::FoundFile& file : by_key_.at(configuration::files_key(object))) {
      const auto chosen = plan::chosen_nodes(object.nodes, file);
      found.insert(found.end(), chosen.begin(), chosen.end());
    }
    return found;
  };
}

}  // namespace carillon::dataset::run
