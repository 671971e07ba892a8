#include "solvers/mesher/file_contents.hpp"

#include <fmt/core.h>

#include "core/error.hpp"
#include "core/storage_error.hpp"
#include "solvers/mesh/readers/file_kind.hpp"
#include "solvers/mesher/detail/ask_child.hpp"

namespace carillon::solvers::mesher {
namespace {

using nlohmann::json;

Vec3 vector_from(const json& values) {
  return {values.at(0).get<double>(), values.at(1).get<double>(), values.at(2).get<double>()};
}

SurfaceContents surface_from_json(const json& in) {
  return {in.at("name"),
          in.at("signature").get<mesh::ShapeSignature>(),
          {vector_from(in.at("low")), vector_from(in.at("high"))},
          in.at("area"),
          in.at("volume"),
          in.at("triangles")};
}

FileContents contents_from_json(const json& in) {
  FileContents contents;
  contents.error = in.value("error", "");
  if (!contents.error.empty()) return contents;
  contents.unit = in.at("unit");
  contents.whole = surface_from_json(in.at("whole"));
  for (const json& node : in.value("nodes", json::array()))
    contents.nodes.push_back(surface_from_json(node));
  return contents;
}

}  // namespace

std::vector<FileContents> read_contents(const std::vector<std::string>& paths,
                                        const ChildLimits& limits) {
  std::vector<FileContents> all;
  if (paths.empty()) return all;
  try {
    for (const json& one :
         ask_child({{"task", "contents"}, {"paths", paths}}, paths.front(), limits))
      all.push_back(contents_from_json(one));
    return all;
  } catch (const core::StorageError&) {
    throw;
  } catch (const core::Error& error) {
    if (paths.size() == 1) {
      FileContents contents;
      contents.error = error.message();
      return {contents};
    }
  }
  // One of them brings the process down: each half by itself.
  const auto middle = paths.begin() + static_cast<std::ptrdiff_t>(paths.size() / 2);
  all = read_contents({paths.begin(), middle}, limits);
  const auto rest = read_contents({middle, paths.end()}, limits);
  all.insert(all.end(), rest.begin(), rest.end());
  return all;
}

std::vector<Vec3> colours_in_child(const mesh::MeshFile& file, const std::vector<Vec3>& points,
                                   const ChildLimits& limits) {
  if (mesh::readers::kind_of(file.path) != mesh::readers::FileKind::scene) return {};
  mesh::MeshRequest request;
  request.file = file;
  std::vector<double> coordinates;
  for (const Vec3& p : points) coordinates.insert(coordinates.end(), p.data(), p.data() + 3);
  const json colours =
      ask_child({{"task", "colours"}, {"request", mesh::to_json(request)}, {"points", coordinates}},
                file.path, limits);
  std::vector<Vec3> read;
  for (std::size_t i = 0; i + 2 < colours.size(); i += 3)
    read.emplace_back(colours[i].get<double>(), colours[i + 1].get<double>(),
                      colours[i + 2].get<double>());
  return read;
}

}  // namespace carillon::solvers::mesher
