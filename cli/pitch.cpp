#include "cli/pitch.hpp"

#include <fmt/format.h>

#include <cstdio>

#include "cli/body.hpp"
#include "mpi/comm.hpp"
#include "solvers/read_mesh.hpp"

namespace carillon::cli {

bool gives_tetrahedra(const solvers::MeshRequest& request) {
  return request.shape.family.empty() && solvers::mesh_extension(request.file.path) == ".msh";
}

solvers::PitchTarget pitch_target(const PitchSearch& search) {
  solvers::PitchTarget target;
  target.cents = search.cents;
  target.start = search.request.options;
  target.fixed_mesh = gives_tetrahedra(search.request);
  target.linear_solver = search.linear_solver;
  target.memory_limit = search.memory_limit;
  return target;
}

solvers::PitchResult refine_to_pitch(const PitchSearch& search, const SetSolver& solve,
                                     MPI_Comm comm, core::Trace& trace) {
  const auto make_mesh = [&](const solvers::MeshOptions& options) {
    solvers::MeshRequest request = search.request;
    request.options = options;
    const core::ScopedTimer timer(mesh_entry(trace, request, search.cache));
    return shared_mesh(request, search.limits, search.cache, comm);
  };
  auto result = solvers::reach_pitch(pitch_target(search), make_mesh, solve);
  for (auto& modes : result.sets) modes = solvers::without_margin(modes);
  return result;
}

void settle(const std::optional<solvers::PitchReport>& report, Context& context) {
  if (!report || report->met()) return;
  context.exit_code = exit_failures;
  if (!context.speaks()) return;
  fmt::print(stderr, "carillon: the pitch target of {:.3g} cents is not met: {:.3g} cents; {}\n",
             report->asked_cents, report->reached_cents, report->reason);
}

void print_report(const solvers::PitchReport& report) {
  fmt::print("\npitch target {:.3g} cents: ", report.asked_cents);
  if (report.met()) {
    fmt::print("met, the worst mode is within {:.3g}\n", report.reached_cents);
  } else {
    fmt::print("not met, the worst mode is within {:.3g}; {}\n", report.reached_cents,
               report.reason);
  }
  fmt::print("{:>6} {:>5} {:>12} {:>9} {:>9} {:>9} {:>14} {:>15}\n", "", "order", "size [mm]",
             "elements", "unknowns", "time [s]", "worst [cent]", "median [cent]");
  for (std::size_t i = 0; i < report.steps.size(); ++i) {
    const solvers::PitchStep& step = report.steps[i];
    fmt::print("{:>6} {:>5} {:>12} {:>9} {:>9} {:>9.2f} {:>14.3g} {:>15.3g}\n",
               i == report.chosen ? "chosen" : "", step.order,
               fmt::format("{}{:.3g}", step.automatic_size ? "auto " : "", 1e3 * step.element_size),
               step.elements, step.unknowns, step.seconds, step.worst_cents, step.median_cents);
  }
}

}  // namespace carillon::cli
