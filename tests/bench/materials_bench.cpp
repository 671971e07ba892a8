// Processor time of one shape in every preset material: together by a Poisson basis, against each
// material solved on its own. (a) for equal numbers of modes, (b) for each material's own band from
// 20 Hz to 20 kHz. Prints the tables of docs/performance.md.
#include <fmt/core.h>
#include <mpi.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <ctime>
#include <functional>
#include <map>

#include "solvers/basis/solve_materials.hpp"
#include "solvers/families/families.hpp"
#include "solvers/libraries/environment.hpp"
#include "synth/material/material.hpp"

namespace carillon::bench {
namespace {

using namespace solvers;

struct Body {
  std::string name;
  solvers::mesh::GeneratedShape shape;
  double element_size;  ///< [m]
};

std::vector<Body> bodies() {
  return {
      {"bowl",
       {"bowl", {{"radius", 0.08}, {"base_radius", 0.03}, {"height", 0.06}, {"wall", 0.004}}, {}},
       0.014},
      {"tile", {"tile", {{"length", 0.2}, {"width", 0.2}, {"thickness", 0.008}}, {}}, 0.014},
      {"block", {"block", {{"length", 0.1}, {"width", 0.08}, {"height", 0.06}}, {}}, 0.016}};
}

/// Processor time of this process [s]: other programs do not count.
double seconds_of(const std::function<void()>& work) {
  const auto start = std::clock();
  work();
  return static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
}

double slowness(const solvers::elements::Elastic& elastic) {
  return std::sqrt(elastic.density / elastic.youngs_modulus);
}

struct Outcome {
  double together = 0, apart = 0;  ///< [s]
  double slowest = 0;              ///< of the materials apart [s]
  double ratios_apart = 0;         ///< [s], one solve for each Poisson's ratio
  core::Trace trace;
  double worst_error = 0, worst_bound = 0;  ///< [cents]
  std::size_t fewest = 1000000, maximum = 0;
};

/// Materials of equal Poisson's ratio are one request, in the band of the slowest: what a build
/// does.
std::vector<solvers::basis::ModeRequest> merged(
    const std::vector<solvers::basis::ModeRequest>& all) {
  std::map<double, solvers::basis::ModeRequest> slowest;
  const auto top = [](const solvers::basis::ModeRequest& r) {
    return r.band.max_frequency * slowness(r.regions[0]);
  };
  for (const auto& request : all) {
    auto& kept = slowest[request.regions[0].poisson_ratio];
    if (kept.regions.empty() || top(request) > top(kept)) kept = request;
  }
  std::vector<solvers::basis::ModeRequest> out;
  for (const auto& [ratio, request] : slowest) out.push_back(request);
  return out;
}

Outcome compare(const solvers::mesh::TetMesh& mesh,
                const std::vector<solvers::basis::ModeRequest>& all) {
  Outcome out;
  solvers::eigen::SolveOptions options;
  options.estimate_errors = false;
  const auto alone = [&](const solvers::basis::ModeRequest& request) {
    core::Trace trace;
    auto own = options;
    own.band = request.band;
    return solvers::eigen::solve_modes(mesh, request.regions, own, MPI_COMM_SELF, trace);
  };
  const auto requests = merged(all);
  std::vector<solvers::modes::Modes> sets, own;
  out.together = seconds_of([&] {
    sets = solvers::basis::solve_materials(mesh, requests, options, MPI_COMM_SELF, {}, out.trace);
  });
  out.ratios_apart = seconds_of([&] {
    for (const auto& request : requests) own.push_back(alone(request));
  });
  for (const auto& request : all) {
    const double seconds = seconds_of([&] { alone(request); });
    out.apart += seconds;
    out.slowest = std::max(out.slowest, seconds);
  }
  for (std::size_t i = 0; i < sets.size(); ++i) {
    out.worst_bound = std::max(out.worst_bound, sets[i].certificate.basis_error);
    out.fewest = std::min(out.fewest, sets[i].size());
    out.maximum = std::max(out.maximum, sets[i].size());
    if (sets[i].size() != own[i].size()) {
      fmt::print("nu {}: {} modes instead of {}\n", requests[i].regions[0].poisson_ratio,
                 sets[i].size(), own[i].size());
    }
    for (std::size_t k = 0; k < std::min(sets[i].size(), own[i].size()); ++k) {
      out.worst_error =
          std::max(out.worst_error,
                   std::abs(600 * std::log2(sets[i].eigenvalues[k] / own[i].eigenvalues[k])));
    }
  }
  return out;
}

void print_row(const std::string& name, std::int64_t unknowns, const char* task, std::size_t count,
               Outcome& out) {
  fmt::print(
      "| {} | {} | {} | {} to {} | {} | {:.1f} | {:.1f} | {:.1f} | {:.1f} | {:.1f} | {:.1f} | "
      "{:.1f} | {:.4f} | "
      "{:.4f} |\n",
      name, unknowns, task, out.fewest, out.maximum, out.trace.stages["solve"].calls, out.together,
      out.apart, out.apart / out.together, out.slowest, out.together / out.slowest,
      out.ratios_apart, out.ratios_apart / out.together, out.worst_error, out.worst_bound);
  fmt::print("|   | | | | | of these basis {:.1f}, ritz {:.1f}; {} materials |\n",
             out.trace.stages["basis"].seconds, out.trace.stages["ritz"].seconds, count);
  std::fflush(stdout);
}

void run(const std::vector<std::string>& names, double finer, int modes) {
  // One for each object of the papers' tables of Rayleigh damping, and three woods: rows of other
  // damping have the same elastic constants.
  std::vector<synth::material::Material> materials = synth::material::preset_materials();
  std::erase_if(materials, [](const synth::material::Material& m) {
    const bool is_sterlings = m.name.starts_with("sterling_") && !m.name.ends_with("_hybrid");
    return !is_sterlings && m.source.find("Hiner 2024") == std::string::npos;
  });
  fmt::print(
      "| object | unknowns | task | modes | solves | together s | each s | ratio | slowest s | "
      "together / "
      "slowest | each nu s | ratio | error cents | bound cents |\n"
      "|---|---|---|---|---|---|---|---|---|---|---|---|---|---|\n");
  for (const auto& body : bodies()) {
    if (!names.empty() && std::find(names.begin(), names.end(), body.name) == names.end()) continue;
    solvers::mesh::MeshOptions options;
    options.order = 3;
    options.element_size = body.element_size / finer;
    const auto mesh = solvers::families::mesh_family(body.shape, options).mesh;
    const auto unknowns = 3 * static_cast<std::int64_t>(mesh.nodes.size());

    // (a) As many modes for all: bands of equal top over the speed of sound.
    core::Trace trace;
    solvers::eigen::SolveOptions first;
    first.band = {0, 1e9, modes};
    first.estimate_errors = false;
    const solvers::elements::Elastic reference{1e11, 0.27, 2700};
    const auto found =
        solvers::eigen::solve_modes(mesh, std::span(&reference, 1), first, MPI_COMM_SELF, trace);
    const double top = found.frequency(found.size() - 1) * 1.001 * slowness(reference);
    std::vector<solvers::basis::ModeRequest> equal, audible;
    for (const auto& material : materials) {
      equal.push_back({{material.elastic}, {0, top / slowness(material.elastic), 100000}});
      audible.push_back({{material.elastic}, {20, 20000, 100000}});
    }
    auto outcome = compare(mesh, equal);
    print_row(body.name, unknowns, "equal counts", materials.size(), outcome);
    outcome = compare(mesh, audible);
    print_row(body.name, unknowns, "20 Hz-20 kHz", materials.size(), outcome);
  }
}

}  // namespace
}  // namespace carillon::bench

int main(int argc, char** argv) {
  CLI::App app{"One shape in every preset material, together and apart"};
  std::vector<std::string> names;
  double finer = 1;
  int modes = 60;
  app.add_option("--object", names, "bowl, tile, block; all without");
  app.add_option("--finer", finer, "factor on the meshes' fineness")->capture_default_str();
  app.add_option("--modes", modes, "modes of the comparison by equal counts")
      ->capture_default_str();
  CLI11_PARSE(app, argc, argv);
  MPI_Init(&argc, &argv);
  {
    const carillon::solvers::libraries::SolverEnvironment environment;
    carillon::bench::run(names, finer, modes);
  }
  MPI_Finalize();
  return 0;
}
