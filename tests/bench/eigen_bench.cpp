// Seconds and memory of 60 modes by Carillon, by stock SLEPc with MUMPS and by Eigen with Spectra,
// from the same matrices in one run; then what the modes with their count and error bars cost
// whole, by classes of mirror planes and about the axis. Prints the tables of docs/performance.md.
#include <fmt/core.h>
#include <mpi.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>

#include "ball_mesh.hpp"
#include "core/trace.hpp"
#include "routes.hpp"
#include "solvers/axisymmetric/solve_axisymmetric.hpp"
#include "solvers/eigen/extract.hpp"
#include "solvers/eigen/search.hpp"
#include "solvers/eigen/solve_modes.hpp"
#include "solvers/families/families.hpp"
#include "solvers/libraries/environment.hpp"
#include "solvers/mesh/tetrahedra/mesher.hpp"
#include "solvers/mesh/weld.hpp"

namespace carillon::bench {
namespace {

using namespace solvers;

const solvers::elements::Elastic steel{2.0e11, 0.29, 7850};

struct Body {
  std::string name;
  solvers::mesh::GeneratedShape shape;
  int order = 3;
};

std::vector<Body> bodies() {
  return {
      {"bowl",
       {"bowl", {{"radius", 0.08}, {"base_radius", 0.03}, {"height", 0.06}, {"wall", 0.004}}, {}}},
      {"tile", {"tile", {{"length", 0.2}, {"width", 0.2}, {"thickness", 0.008}}, {}}},
      {"block", {"block", {{"length", 0.1}, {"width", 0.08}, {"height", 0.06}}, {}}},
      {"scan", {}, 2}};
}

/// A lumpy body without any symmetry, as from a scanner, of ten-node tetrahedra.
solvers::mesh::MeshResult scan(const solvers::mesh::MeshOptions& options) {
  solvers::mesh::SurfaceMesh surface = ball(0.05, 60);
  solvers::mesh::weld(surface);  // the poles
  for (Vec3& v : surface.vertices) {
    const Vec3 x = v / 0.05;
    v *= 1 + 0.12 * std::sin(3 * x.x() + 1) * std::cos(4 * x.y()) +
         0.08 * std::sin(5 * x.z() + 2 * x.x());
    v.z() *= 0.7;
  }
  return solvers::mesh::tetrahedra::tetrahedralise(surface, options);
}

solvers::mesh::TetMesh made(const Body& body, const solvers::mesh::MeshOptions& options) {
  return body.name == "scan" ? scan(options).mesh
                             : solvers::families::mesh_family(body.shape, options).mesh;
}

/// A mesh of nearly so many unknowns; the last making is timed.
solvers::mesh::TetMesh mesh_of(const Body& body, double unknowns, std::vector<Stage>& stages) {
  solvers::mesh::MeshOptions options;
  options.order = body.order;
  options.max_elements = 10000000;
  options.element_size = 0.03;
  solvers::mesh::TetMesh mesh;
  // Element counts come in steps, so the nearest of a few tries has to do.
  double best = 0, best_size = options.element_size;
  for (int tries = 0; tries < 8; ++tries) {
    mesh = made(body, options);
    const double count = 3.0 * static_cast<double>(mesh.nodes.size());
    if (std::abs(std::log(count / unknowns)) < std::abs(std::log(std::max(1.0, best) / unknowns))) {
      best = count;
      best_size = options.element_size;
    }
    if (std::abs(count / unknowns - 1) < 0.1) break;
    options.element_size *=
        std::pow(count / unknowns, body.name == "block" || body.name == "scan" ? 1.0 / 3 : 0.45);
  }
  options.element_size = best_size;
  measure_stage(stages, "mesh", [&] { mesh = made(body, options); });
  return mesh;
}

double worst_difference(const Answer& a, const Answer& b, int pairs) {
  double worst = 0;
  for (std::size_t k = 6; k < static_cast<std::size_t>(pairs); ++k) {
    worst = std::max(worst, std::abs(a.values.at(k) / b.values.at(k) - 1));
  }
  return worst;
}

void print_row(const std::string& body, std::int64_t unknowns, const std::string& route,
               const std::vector<Stage>& stages) {
  for (const auto& stage : stages) {
    fmt::print("| {} | {} | {} | {} | {:.2f} | {:.0f} |\n", body, unknowns, route, stage.name,
               stage.seconds, 1e-6 * static_cast<double>(stage.bytes));
  }
  std::fflush(stdout);
}

/// Certified modes: solved, counted and with error bars.
struct Certified {
  solvers::modes::Modes modes;
  double seconds = 0;
  double estimate = 0;  ///< of the rest, both by the wall clock
};

/// @param solve  into modes, with a trace
template <typename Solve>
Certified certified(const Solve& solve) {
  Certified result;
  core::Trace trace;
  const double start = core::thread_cpu_seconds(), wall_start = core::monotonic_seconds();
  result.modes = solve(trace);
  result.seconds = core::thread_cpu_seconds() - start;
  const double wall = core::monotonic_seconds() - wall_start;
  const double estimate = trace.stages["estimate"].seconds;
  result.estimate = estimate / (wall - estimate);
  return result;
}

/// What the shape asks for beside what any body would cost: the row of a table.
std::string run_certified(const Body& body, const solvers::mesh::TetMesh& mesh, int modes) {
  const std::vector<solvers::elements::Elastic> regions(mesh.region_names.size(), steel);
  solvers::eigen::SolveOptions options;
  options.band = {0, 1e9, modes};
  const auto tetrahedra = [&](bool mirror_planes) {
    options.mirror_planes = mirror_planes;
    return certified([&](core::Trace& trace) {
      return solvers::eigen::solve_modes(mesh, regions, options, MPI_COMM_SELF, trace);
    });
  };
  const Certified whole = tetrahedra(false);
  auto row = fmt::format("| {} | {} | {:.1f} | {:.0f} % |", body.name,
                         whole.modes.certificate.unknowns, whole.seconds, 100 * whole.estimate);
  const Certified classes = tetrahedra(true);
  const int planes = classes.modes.certificate.mirror_planes;
  row += planes > 0 ? fmt::format(" {} | {:.1f} | {:.1f} |", planes, classes.seconds,
                                  whole.seconds / classes.seconds)
                    : std::string(" 0 | - | - |");
  const auto worst = [](const solvers::modes::Modes& of) {
    return *std::max_element(of.pitch_errors.begin(), of.pitch_errors.end());
  };
  if (body.name != "bowl") return row + fmt::format(" - | - | {:.2g} | - |", worst(whole.modes));
  const Certified turned = certified([&](core::Trace& trace) {
    const auto count = whole.modes.size();
    solvers::eigen::SolveOptions own;
    own.band = {0, 1.001 * whole.modes.frequency(count - 1), modes};
    return solvers::axisymmetric::solve_axisymmetric(
        solvers::families::find_family(body.shape.family).meridian(body.shape), steel, own,
        {.pitch_target = 5}, trace);
  });
  return row + fmt::format(" {:.1f} | {:.0f} | {:.2g} | {:.2g} |", turned.seconds,
                           whole.seconds / turned.seconds, worst(whole.modes), worst(turned.modes));
}

/// Rows of both tables.
struct Rows {
  std::string routes, certified;
};

Rows run(const Body& body, double unknowns, int modes, double max_flops) {
  std::vector<Stage> stages;
  const auto mesh = mesh_of(body, unknowns, stages);
  const std::vector<solvers::elements::Elastic> regions(mesh.region_names.size(), steel);
  solvers::assembly::System system;
  measure_stage(stages, "assemble", [&] {
    system = solvers::assembly::assemble(mesh, regions, solvers::assembly::partition(mesh, 1),
                                         MPI_COMM_SELF);
  });
  const double shift =
      -0.01 * system.scales.from_frequency(solvers::eigen::estimate_first_frequency(mesh, regions));
  const int pairs = modes + 6;
  const auto own = carillon_route(system, shift, pairs);
  auto all = stages;
  all.insert(all.end(), own.stages.begin(), own.stages.end());
  print_row(body.name, system.unknowns(), "Carillon", all);
  const auto slepc = slepc_route(system, shift, pairs);
  print_row(body.name, system.unknowns(), "Krylov-Schur, MUMPS", slepc.stages);
  const auto spectra = spectra_route(system, shift, pairs, max_flops);
  if (spectra.refused.empty()) {
    print_row(body.name, system.unknowns(), "Spectra, SimplicialLDLT", spectra.stages);
  }
  // The count is left out where routes are compared: the others make none.
  const auto solve_stages = std::vector<Stage>(own.stages.begin(), own.stages.end() - 1);
  const double solve = total_seconds(solve_stages);
  auto row = fmt::format("| {} | {} | {:.1f} % | {:.2f} | {:.2f} | {:.2f} | {:.1f} | {:.0e} |",
                         body.name, system.unknowns(), 100 * stages.back().seconds / solve, solve,
                         own.stages.back().seconds, total_seconds(slepc.stages),
                         total_seconds(slepc.stages) / solve, worst_difference(own, slepc, pairs));
  row += spectra.refused.empty()
             ? fmt::format(" {:.2f} | {:.1f} | {:.0e} |", total_seconds(spectra.stages),
                           total_seconds(spectra.stages) / solve,
                           worst_difference(own, spectra, pairs))
             : fmt::format(" {} | - | - |", spectra.refused);
  return {row, run_certified(body, mesh, modes)};
}

}  // namespace
}  // namespace carillon::bench

int main(int argc, char** argv) {
  using namespace carillon;
  std::vector<double> sizes = {1e4, 5e4, 2e5};
  std::vector<std::string> names = {"bowl", "tile", "block", "scan"};
  int modes = 60;
  double max_flops = 1e12;
  CLI::App app("Seconds and memory of modes by three routes, in one run");
  app.add_option("--unknowns", sizes, "sizes of the bodies");
  app.add_option("--objects", names, "bowl, tile, block, scan (ten-node tetrahedra)");
  app.add_option("--modes", modes, "flexible modes asked for");
  app.add_option("--spectra-flops", max_flops,
                 "largest factorisation that the Spectra route is given [flop]");
  CLI11_PARSE(app, argc, argv);
  MPI_Init(&argc, &argv);
  int status = 0;
  try {
    const solvers::libraries::SolverEnvironment environment;
    fmt::print("{}; {} modes; processor seconds, one thread\n\n", bench::machine(), modes);
    fmt::print("| object | unknowns | route | stage | s | peak MB |\n|---|---|---|---|---|---|\n");
    std::vector<bench::Rows> summary;
    for (const double size : sizes) {
      for (const auto& body : bench::bodies()) {
        if (std::find(names.begin(), names.end(), body.name) == names.end()) continue;
        summary.push_back(bench::run(body, size, modes, max_flops));
      }
    }
    fmt::print(
        "\n| object | unknowns | assembly / solve | solve (order, factor, iterate) | count | "
        "Krylov-Schur, MUMPS | ratio | difference | Spectra, SimplicialLDLT | ratio | difference "
        "|\n|---|---|---|---|---|---|---|---|---|---|---|\n");
    for (const auto& row : summary) fmt::print("{}\n", row.routes);
    fmt::print(
        "\n| object | unknowns | solve, count, estimate | estimate / rest | mirror planes | by "
        "classes | ratio | "
        "about the axis | ratio | worst error bar [cents] | about the axis |\n"
        "|---|---|---|---|---|---|---|---|---|---|---|\n");
    for (const auto& row : summary) fmt::print("{}\n", row.certified);
  } catch (const std::exception& e) {
    fmt::print(stderr, "carillon-bench: {}\n", e.what());
    status = 1;
  }
  MPI_Finalize();
  return status;
}
