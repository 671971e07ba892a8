#include "cli/pitch_report.hpp"

#include <fmt/format.h>

#include <cmath>
#include <cstdio>

namespace carillon::cli {

void settle(const ObjectOptions& options, const std::optional<solvers::pitch::PitchReport>& report,
            Context& context) {
  if (!report || report->met()) return;
  if (options.pitch_cents) context.exit_code = mpi::exit_failures;
  if (!context.speaks()) return;
  fmt::print(stderr, "carillon: the pitch target of {:.3g} cents is not met: {:.3g} cents; {}\n",
             report->asked_cents, report->reached_cents, report->reason);
}

void print_report(const solvers::pitch::PitchReport& report) {
  fmt::print("\npitch target {:.3g} cents: ", report.asked_cents);
  if (report.met()) {
    fmt::print("met, the worst mode is within {:.3g}\n", report.reached_cents);
  } else {
    fmt::print("not met, the worst mode is within {:.3g}; {}\n", report.reached_cents,
               report.reason);
  }
  if (report.steps.empty()) return;
  fmt::print("{:>6} {:>5} {:>12} {:>9} {:>9} {:>9} {:>14} {:>15}\n", "", "order", "size [mm]",
             "elements", "unknowns", "time [s]", "worst [cent]", "median [cent]");
  for (std::size_t i = 0; i < report.steps.size(); ++i) {
    const solvers::pitch::PitchStep& step = report.steps[i];
    fmt::print("{:>6} {:>5} {:>12} {:>9} {:>9} {:>9.2f} {:>14.3g} {:>15}\n",
               i == report.chosen ? "chosen" : "", step.order,
               fmt::format("{}{:.3g}", step.automatic_size ? "auto " : "", 1e3 * step.element_size),
               step.elements, step.unknowns, step.seconds, step.worst_cents,
               std::isnan(step.median_cents) ? "-" : fmt::format("{:.3g}", step.median_cents));
  }
}

}  // namespace carillon::cli
