#include "dataset/plan/identities.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>

#include "core/error.hpp"
#include "core/hash.hpp"
#include "core/units.hpp"
#include "solvers/eigen/extract.hpp"
#include "solvers/mesh/readers/read_mesh.hpp"
#include "solvers/mesher/file_contents.hpp"

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

std::string mesh_sha256(const std::string& path) {
  const std::vector<std::string> files = solvers::mesh::readers::files_of(path, true);
  if (files.size() == 1) return core::sha256_file(path);
  core::Sha256 hash;
  for (const std::string& file : files) hash.add(core::sha256_file(file));
  return hash.hex();
}

namespace {

namespace readers = solvers::mesh::readers;

FoundMesh found_of(const std::string& path, const std::string& sha256,
                   const solvers::mesher::SurfaceContents& contents, double unit) {
  return {path, sha256, contents.signature,
          FileSurface{unit, contents.bounds, contents.area, contents.volume}, contents.name};
}

/// Those that need no process of their own.
void read_here(FoundMesh& found) {
  if (readers::mesh_extension(found.path) == ".msh") {
    std::vector<std::int32_t> nodes;
    found.signature = solvers::mesh::shape_signature(
        solvers::modes::flatten(solvers::eigen::surface_of(readers::read_msh(found.path), nodes)));
  } else {
    const solvers::mesh::SurfaceMesh surface = readers::read_surface(found.path);
    found.signature = solvers::mesh::shape_signature(surface);
    found.surface = {1, solvers::mesh::bounding_box(surface.vertices), solvers::mesh::area(surface),
                     std::abs(solvers::mesh::signed_volume(surface))};
  }
}

}  // namespace

std::vector<FoundFile> find_files(const std::vector<std::string>& paths) {
  std::vector<FoundFile> files;
  std::vector<std::string> elsewhere;
  std::vector<std::size_t> whose;
  for (const std::string& path : paths) {
    files.push_back({{path, "", {}, {}, ""}, {}});
    FoundMesh& found = files.back().whole;
    // What is not there costs its own task, of a manifest's row; what is there is read, or said at
    // once.
    std::error_code missing;
    if (!std::filesystem::exists(path, missing)) continue;
    found.sha256 = mesh_sha256(path);
    try {
      const bool here = readers::mesh_extension(path) == ".msh" ? !readers::is_old_msh(path)
                                                                : !readers::has_nodes(path);
      if (here) {
        read_here(found);
      } else {
        elsewhere.push_back(path);
        whose.push_back(files.size() - 1);
      }
    } catch (const std::exception&) {
      // No mesh: its task will say why.
    }
  }
  const auto contents = solvers::mesher::read_contents(elsewhere, {});
  for (std::size_t i = 0; i < contents.size(); ++i) {
    if (!contents[i].error.empty()) continue;
    FoundFile& file = files[whose[i]];
    const std::string path = file.whole.path, sha256 = file.whole.sha256;
    file.whole = found_of(path, sha256, contents[i].whole, contents[i].unit);
    for (const auto& node : contents[i].nodes)
      file.nodes.push_back(found_of(path, sha256, node, contents[i].unit));
  }
  return files;
}

std::vector<FoundMesh> chosen_nodes(const scene::NodeChoice& choice, const FoundFile& file) {
  // One that cannot be read, or is one body anyway, is one object.
  if (choice.each) return file.nodes.empty() ? std::vector{file.whole} : file.nodes;
  if (choice.names.empty()) return {file.whole};
  std::vector<FoundMesh> chosen;
  for (const std::string& name : choice.names) {
    const auto found = std::find_if(file.nodes.begin(), file.nodes.end(),
                                    [&](const FoundMesh& node) { return node.node == name; });
    if (found != file.nodes.end()) {
      chosen.push_back(*found);
    } else if (!file.whole.surface) {
      // It cannot be read; its task will say why.
      chosen.push_back(file.whole);
      chosen.back().node = name;
    } else {
      std::vector<std::string> names;
      for (const FoundMesh& node : file.nodes) names.push_back(node.node);
      const std::string near = core::nearest_name(name, names);
      throw core::InputError(fmt::format("{}: no node \"{}\"", file.whole.path, name),
                             !near.empty() ? fmt::format("did you mean \"{}\"?", near)
                             : names.empty()
                                 ? "the file has no nodes with names"
                                 : fmt::format("its nodes are {}", fmt::join(names, ", ")));
    }
  }
  return chosen;
}

std::vector<FoundMesh> find_meshes(const scene::Object& object) {
  std::vector<FoundMesh> found;
  for (const FoundFile& file : find_files(configuration::object_files(object))) {
    const auto chosen = chosen_nodes(object.nodes, file);
    found.insert(found.end(), chosen.begin(), chosen.end());
  }
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
