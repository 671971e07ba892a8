#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "cli/command_line.hpp"
#include "cli/object_options.hpp"
#include "cli/pitch_report.hpp"
#include "core/files.hpp"
#include "core/numbers.hpp"
#include "scene/solved_object_json.hpp"
#include "solvers/modes/modes_file.hpp"
#include "synth/modal/ring_down.hpp"

namespace carillon::cli {

namespace {

std::string planes_text(int mirror_planes) {
  if (mirror_planes == 0) return "";
  return fmt::format(" in {} classes of {} mirror plane{}", 1 << mirror_planes, mirror_planes,
                     mirror_planes == 1 ? "" : "s");
}

/// Worst and median of the estimated errors.
void print_pitch_errors(const std::vector<double>& errors) {
  const auto worst = std::max_element(errors.begin(), errors.end());
  fmt::print("estimated pitch error: worst {:.3g} cents (mode {}), median {:.3g}\n", *worst,
             worst - errors.begin() + 1, core::median(errors));
}

/// How the modes were found, and how well.
void print_solve(const scene::SolvedObject& object) {
  const solvers::modes::Certificate& certificate = object.modes.certificate;
  const bool about_axis = !object.modes.shapes.harmonics().empty();
  fmt::print("\n{} of the {} modes in the band{}; complete to {:.1f} Hz\n", certificate.modes_found,
             certificate.modes_in_band,
             certificate.count_verified ? "" : " that were seen (not counted by inertia)",
             certificate.complete_to_hz);
  fmt::print("{} rigid modes of {} component{}; worst residual {:.1e}\n", certificate.rigid_modes,
             certificate.components, certificate.components == 1 ? "" : "s",
             certificate.max_residual);
  if (!object.modes.pitch_errors.empty()) print_pitch_errors(object.modes.pitch_errors);
  const std::string size =
      about_axis ? fmt::format("{} unknowns to a harmonic", certificate.unknowns)
                 : fmt::format("{} elements, {} unknowns{}", object.mesh.quality.elements,
                               certificate.unknowns, planes_text(certificate.mirror_planes));
  fmt::print("{} solver ({}): {}, mass {:.4g} kg\n", scene::name_of(object.solver.solver),
             object.solver.reason, size, object.modes.mass);
}

void print_table(const scene::SolvedObject& object, const synth::damping::DecayRates& damping,
                 const Command& command) {
  const std::vector<int> harmonics = object.modes.shapes.harmonics();
  const bool estimated = !object.modes.pitch_errors.empty();
  const bool is_solved = object.modes.given_decay_rates.empty();
  fmt::print("{:>5} {:>14} {}{:>14} {:>10} {:>10}{}\n", "mode", "frequency [Hz]",
             estimated ? "error [cent] " : "", "decay [1/s]", "T60 [s]", "residual",
             harmonics.empty() ? "" : " harmonic");
  for (std::size_t i = 0; i < object.modes.size(); ++i) {
    fmt::print("{:>5} {:>14.4f} {}{:>14.4f} {:>10.3g} {:>10}{}\n", i + 1, object.modes.frequency(i),
               estimated ? fmt::format("{:>12.2g} ", object.modes.pitch_errors[i]) : "",
               damping.values[i], synth::modal::t60(damping.values[i]),
               is_solved ? fmt::format("{:.1e}", object.modes.residuals[i]) : "-",
               harmonics.empty() ? "" : fmt::format(" {:>8}", harmonics[i]));
  }
  if (object.modes.size() == 0) fmt::print("{}\n", command.in_options(scene::why_no_mode(object)));
  if (!damping.negative.empty()) {
    fmt::print("{}; shown as 0\n",
               synth::damping::describe_negative(object.modes, scene::damping_of(object.materials),
                                                 damping.negative));
  }
  if (is_solved) {
    print_solve(object);
  } else {
    fmt::print("\n{} modes that the file brought along, mass {:.4g} kg; nothing was solved\n",
               object.modes.size(), object.modes.mass);
  }
  if (const auto& quality = object.mesh.quality; std::isfinite(quality.hausdorff)) {
    fmt::print(
        "surface kept within {:.4f} mm, area {:+.4f} %, volume {:+.4f} % after "
        "{:+.4f} % were added at the boundary; dihedral angles from {:.0f} to {:.0f} degrees\n",
        1e3 * quality.hausdorff, 100 * quality.area_error, 100 * quality.volume_error,
        100 * quality.volume_added, quality.min_dihedral_deg, quality.max_dihedral_deg);
  }
  for (const std::string& action : object.mesh.repair.actions) fmt::print("repair: {}\n", action);
  if (object.pitch_target) print_report(*object.pitch_target);
  for (const auto& [stage, entry] : object.trace.stages) {
    fmt::print("{:<18} {:8.3f} s\n", stage, entry.seconds);
  }
}

}  // namespace

void add_modes(Program& program, Context& context) {
  Command& command =
      program.add("modes", "modes of one shape, with their certificate", Needs::solver);
  auto options = std::make_shared<ObjectOptions>();
  auto output = std::make_shared<std::string>();
  add_object_options(command, *options);
  add_tuning_options(command, *options);
  command.option("-o,--output", *output, "HDF5 file for frequencies, shapes and certificate");
  command.footer(
      "Examples:\n"
      "  carillon modes cup.obj --length 0.1 m --material ceramic\n"
      "  carillon modes block:length=50mm,width=30mm,height=20mm -m steel --max-frequency 150kHz\n"
      "  carillon modes bowl -m glass --pitch-cents 5\n"
      "  mpirun -n 2 carillon modes bowl -m glass --json");
  command.does([&context, options, output] {
    name_material(*options, context);
    require_output_file(context, *output);
    const scene::SolvedObject object = solve_object(*options, context);
    settle(*options, object.pitch_target, context);
    const auto damping =
        synth::damping::clamped_decay_rates(object.modes, scene::damping_of(object.materials));
    if (!context.speaks()) return;
    if (!output->empty()) {
      core::write_durably(*output, [&](const std::filesystem::path& path) {
        solvers::modes::write_modes(core::Hdf5Group::create_file(path), object.modes);
      });
    }
    if (context.json) {
      nlohmann::json document = scene::to_json(object, damping);
      if (document.contains("explanation")) {
        document["explanation"] = context.chosen->in_options(document["explanation"]);
      }
      fmt::print("{}\n", document.dump(2));
    } else {
      print_table(object, damping, *context.chosen);
    }
  });
}

}  // namespace carillon::cli
