#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "cli/command_line.hpp"
#include "cli/commands.hpp"
#include "cli/option_values.hpp"
#include "core/error.hpp"
#include "core/units.hpp"
#include "mpi/comm.hpp"
#include "solvers/mesh/mesh_warnings.hpp"
#include "solvers/mesh/readers/read_mesh.hpp"
#include "solvers/mesher/file_contents.hpp"
#include "solvers/mesher/mesh_child.hpp"

namespace carillon::cli {

namespace {

void print_diagnosis(const std::string& path, const solvers::mesh::Diagnosis& d) {
  fmt::print("{}\n", path);
  fmt::print("  {:<26} {} vertices, {} triangles\n", "size", d.vertices, d.triangles);
  fmt::print("  {:<26} {:.4g} x {:.4g} x {:.4g} m\n", "extent", d.extent[0], d.extent[1],
             d.extent[2]);
  if (d.closed)
    fmt::print("  {:<26} {:.4g} m^3, {:.4g} m^2\n", "volume, area", d.volume, d.area);
  else
    fmt::print("  {:<26} {:.4g} m^2; open, so that it bounds no volume\n", "area", d.area);
  const std::pair<const char*, std::int64_t> findings[] = {
      {"components", d.components},
      {"nested components", d.nested_components},
      {"touching components", d.touching_components},
      {"boundary edges", d.boundary_edges},
      {"non-manifold edges", d.nonmanifold_edges},
      {"non-manifold vertices", d.nonmanifold_vertices},
      {"misoriented edges", d.misoriented_edges},
      {"self-intersections", d.self_intersections},
      {"degenerate triangles", d.degenerate_triangles},
      {"duplicate triangles", d.duplicate_triangles},
      {"duplicate vertices", d.duplicate_vertices},
      {"unreferenced vertices", d.unreferenced_vertices}};
  for (const auto& [name, count] : findings) {
    if (count != 0) fmt::print("  {:<26} {}\n", name, count);
  }
  fmt::print("  {}\n", d.clean    ? "clean: used as it is"
                       : d.closed ? "not clean: repaired, wrapped or refused (carillon modes tells)"
                                  : "open: holes are filled, sheets ask for a thickness "
                                    "(carillon modes tells)");
}

/// Nodes of a scene or a CAD file; none of others.
solvers::mesher::FileContents named_nodes(const std::string& path) {
  if (!solvers::mesh::readers::has_nodes(path)) return {};
  return solvers::mesher::read_contents({path}, {}).front();
}

void print_nodes(const solvers::mesher::FileContents& contents) {
  if (contents.nodes.empty()) return;
  fmt::print("  {:<26} {:g} m\n  nodes, each with triangles and extent:\n", "unit", contents.unit);
  for (const auto& node : contents.nodes) {
    const Vec3 extent = node.bounds.extent() * contents.unit;
    fmt::print("    {:<24} {:>8}  {:.4g} x {:.4g} x {:.4g} m\n", node.name, node.triangles,
               extent.x(), extent.y(), extent.z());
  }
}

nlohmann::json to_json(const solvers::mesher::FileContents& contents) {
  nlohmann::json nodes = nlohmann::json::array();
  for (const auto& node : contents.nodes) {
    const Vec3 extent = node.bounds.extent() * contents.unit;
    nodes.push_back({{"name", node.name},
                     {"triangles", node.triangles},
                     {"extent_m", {extent.x(), extent.y(), extent.z()}}});
  }
  return nodes;
}

}  // namespace

void add_inspect(Program& program, Context& context) {
  struct Options {
    std::vector<std::string> meshes;
    std::string length, unit, node;
    bool any_size = false;
  };
  Command& command = program.add("inspect", "diagnosis of surface meshes", Needs::nothing);
  auto options = std::make_shared<Options>();
  command.option("mesh", options->meshes, "mesh files of any kind (carillon modes --help)")
      .required();
  command.option("--length", options->length, "longest side the object is scaled to, e.g. 12 cm");
  command.option("--unit", options->unit, "of the file's coordinates: mm, cm, m or inch")
      .show_default("what the file says, or m");
  command.option("--node", options->node, "of a file that has several: this one alone");
  command.flag("--any-size", options->any_size, "ask no question about sizes above 2 m");
  command.footer("Example:\n  carillon inspect *.obj");
  command.does([&context, options] {
    if (!context.speaks()) return;
    nlohmann::json all = nlohmann::json::array();
    for (const std::string& path : options->meshes) {
      solvers::mesh::MeshFile file;
      file.path = path;
      file.any_size = true;
      file.node = options->node;
      if (!options->length.empty()) {
        file.length = option_quantity(options->length, core::Dimension::length, "--length");
      }
      if (!options->unit.empty()) file.unit = core::parse_unit_of_length(options->unit);
      try {
        const solvers::mesh::Diagnosis diagnosis = solvers::mesher::diagnose_in_child(file, {});
        file.any_size = options->any_size;
        const std::string question = solvers::mesh::unit_question(
            file, *std::max_element(diagnosis.extent.begin(), diagnosis.extent.end()), 0);
        const solvers::mesher::FileContents contents = named_nodes(path);
        if (context.json) {
          nlohmann::json one = solvers::mesh::to_json(diagnosis);
          if (!contents.nodes.empty()) one["nodes"] = to_json(contents);
          one["file"] = path;
          if (!diagnosis.closed) one["volume"] = nullptr;
          one["unit_question"] = question;
          all.push_back(one);
        } else {
          print_diagnosis(path, diagnosis);
          print_nodes(contents);
          if (!question.empty()) fmt::print("  {}\n", context.chosen->in_options(question));
        }
      } catch (const core::Error& error) {
        context.exit_code = mpi::exit_input;
        all.push_back({{"file", path}, {"error", error.message()}});
        fmt::print(stderr, "carillon: {}\n", context.chosen->in_options(error.what()));
      }
    }
    if (context.json) fmt::print("{}\n", all.dump(2));
  });
}

}  // namespace carillon::cli
