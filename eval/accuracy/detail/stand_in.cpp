#include "eval/accuracy/detail/stand_in.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>

#include "core/files.hpp"
#include "core/random.hpp"
#include "solvers/mesher/mesh_child.hpp"

namespace carillon::eval::accuracy {

void write_stand_in(const StandIn& stand_in, const std::filesystem::path& file,
                    const std::filesystem::path& cache) {
  solvers::mesh::MeshRequest request;
  request.shape = stand_in.shape;
  request.options.order = 1;
  const solvers::mesh::TetMesh mesh = solvers::mesher::mesh_in_child(request, {}, cache).mesh;

  std::vector<Vec3> normals(mesh.nodes.size(), Vec3::Zero());
  std::vector<bool> used(mesh.nodes.size(), false);
  for (std::size_t f = 0; f < mesh.faces.size(); f += 3) {
    const auto at = [&](std::size_t i) { return static_cast<std::size_t>(mesh.faces[f + i]); };
    const Vec3 a = mesh.nodes[at(0)], b = mesh.nodes[at(1)], c = mesh.nodes[at(2)];
    for (std::size_t i = 0; i < 3; ++i) {
      normals[at(i)] += (b - a).cross(c - a);
      used[at(i)] = true;
    }
  }
  core::RandomStream random(0, core::stable_hash(stand_in.shape.family), "accuracy.noise");
  std::vector<std::size_t> number(mesh.nodes.size(), 0);
  std::string vertices;
  std::size_t count = 0;
  for (std::size_t n = 0; n < mesh.nodes.size(); ++n) {
    if (!used[n]) continue;
    number[n] = count++;
    const Vec3 p = mesh.nodes[n] + stand_in.deviation * random.normal() * normals[n].normalized();
    vertices += fmt::format("{:.9g} {:.9g} {:.9g}\n", p.x(), p.y(), p.z());
  }
  std::string text = fmt::format("OFF\n{} {} 0\n{}", count, mesh.faces.size() / 3, vertices);
  for (std::size_t f = 0; f < mesh.faces.size(); f += 3) {
    const auto at = [&](std::size_t i) {
      return number[static_cast<std::size_t>(mesh.faces[f + i])];
    };
    text += fmt::format("3 {} {} {}\n", at(0), at(1), at(2));
  }
  core::write_text_durably(file, text);
}

}  // namespace carillon::eval::accuracy
