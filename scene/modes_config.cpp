#include "scene/modes_config.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "core/text.hpp"

namespace carillon::scene {

using core::at_key;
using core::ConfigNode;
using core::Dimension;

namespace {

/// A limit of memory [byte].
std::int64_t memory_limit(ConfigNode& node, const std::string& key, std::int64_t fallback) {
  const double bytes = node.quantity(key, Dimension::memory, static_cast<double>(fallback));
  std::int64_t limit = 0;
  at_key(node, key, [&] { limit = core::whole_bytes(bytes); });
  return limit;
}

}  // namespace

void read_modes(ConfigNode node, double sample_rate, ModesConfig& config) {
  // Modes at or above half the sample rate would not sound.
  config.band = read_band(node, {.max_frequency = std::min(20000.0, sample_rate / 2)});
  config.mesh.order = static_cast<int>(node.integer("order", 1, 4, 3));
  config.mesh.element_size = node.not_negative("element_size", Dimension::length, 0);
  config.mesh.max_elements = node.integer("max_elements", 1, 100000000, 200000);
  config.mesh.edge_layers = static_cast<int>(node.integer("edge_layers", 0, 4, 1));
  // Who fixes the elements wants these.
  if (node.has("order") || config.mesh.element_size > 0) config.pitch_cents = 0;
  for (const char* key : {"order", "element_size", "edge_layers"})
    if (node.has(key)) config.object_solver.solver = ObjectSolver::tetrahedra;
}

void read_solver(ConfigNode node, ModesConfig& config) {
  SolverRequest& solver = config.object_solver;
  for (const char* key : {"linear_solver", "eigen_solver"})
    if (node.has(key)) solver.solver = ObjectSolver::tetrahedra;
  solver.solver = parse_object_solver(node.choice(
      "kind", {"automatic", "tetrahedra", "axisymmetric"}, std::string(name_of(solver.solver))));
  solver.reason = "solver.kind, or a key of tetrahedra, asks for it";
  const std::string cents = node.text(
      "pitch_cents", config.pitch_cents > 0 ? fmt::format("{}", config.pitch_cents) : "off");
  at_key(node, "pitch_cents",
         [&] { config.pitch_cents = solvers::pitch::parse_pitch_target(cents); });
  config.max_unknowns =
      node.integer("max_unknowns", 1, 1000000000, solvers::pitch::usual_max_unknowns);
  config.solver.linear_solver = solvers::modes::parse_linear_solver(
      node.choice("linear_solver", {"automatic", "direct", "iterative"}, "automatic"));
  config.solver.solver = solvers::modes::parse_eigen_solver(
      node.choice("eigen_solver", {"block_lanczos", "krylov_schur"}, "block_lanczos"));
  config.solver.mirror_planes =
      node.choice("mirror_planes", {"automatic", "off"}, "automatic") == "automatic";
  config.solver.memory_limit = memory_limit(node, "memory_limit", config.solver.memory_limit);
}

ObjectRequest object_request(const ModesConfig& config, solvers::mesh::MeshRequest mesh,
                             RegionMaterials materials) {
  ObjectRequest request;
  request.mesh = std::move(mesh);
  request.mesh.options = config.mesh;
  request.materials = std::move(materials);
  request.any_size = request.mesh.file.any_size;
  request.solver = config.object_solver;
  request.solve = config.solver;
  request.solve.band = config.band;
  request.pitch_cents = config.pitch_cents;
  request.max_unknowns = config.max_unknowns;
  return request;
}

}  // namespace carillon::scene
