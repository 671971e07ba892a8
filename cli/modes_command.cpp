#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "cli/body_options.hpp"
#include "cli/command_line.hpp"
#include "cli/pitch_report.hpp"
#include "core/files.hpp"
#include "core/numbers.hpp"
#include "solvers/eigen/search.hpp"
#include "solvers/modes/modes_file.hpp"
#include "synth/modal/ring_down.hpp"

namespace carillon::cli {

namespace {

/// Why a set is empty, and which way the band would have to be widened.
std::string why_no_mode(const scene::Body& body) {
  const solvers::modes::Certificate& certificate = body.modes.certificate;
  std::string text =
      fmt::format("no mode lies between {:.6g} and {:.6g} Hz{}", certificate.min_frequency,
                  certificate.max_frequency, certificate.count_verified ? ", by count" : "");
  // Harmonics of a turned body come without a mesh to guess from.
  if (body.mesh.mesh.faces.empty()) return text;
  const double guess =
      solvers::eigen::estimate_first_frequency(body.mesh.mesh, scene::elastic_of(body.materials));
  text += fmt::format("; the body's first is expected near {:.2g} Hz", guess);
  if (guess > certificate.max_frequency) text += ": raise --max-frequency";
  if (guess < certificate.min_frequency) text += ": lower --min-frequency";
  return text;
}

nlohmann::json to_json(const scene::Body& body, const synth::damping::DecayRates& damping) {
  nlohmann::json modes = nlohmann::json::array();
  for (std::size_t i = 0; i < body.modes.size(); ++i) {
    modes.push_back({{"frequency_hz", body.modes.frequency(i)},
                     {"decay_rate_per_s", damping.values[i]},
                     {"residual", body.modes.residuals[i]}});
    if (!body.modes.pitch_errors.empty()) {
      modes.back()["pitch_error_cents"] = body.modes.pitch_errors[i];
    }
    if (!body.modes.harmonics.empty()) modes.back()["harmonic"] = body.modes.harmonics[i];
  }
  const solvers::modes::Certificate& certificate = body.modes.certificate;
  nlohmann::json timing = nlohmann::json::object();
  for (const auto& [stage, entry] : body.trace.stages) timing[stage + "_s"] = entry.seconds;
  nlohmann::json materials = nlohmann::json::array();
  for (const synth::material::Material& material : body.materials)
    materials.push_back(material.name);
  nlohmann::json out = {{"modes", modes},
                        {"certificate",
                         {{"modes_in_band", certificate.modes_in_band},
                          {"modes_found", certificate.modes_found},
                          {"complete", certificate.complete},
                          {"complete_to_hz", certificate.complete_to_hz},
                          {"rigid_modes", certificate.rigid_modes},
                          {"components", certificate.components},
                          {"max_residual", certificate.max_residual},
                          {"orthonormality", certificate.orthonormality},
                          {"unknowns", certificate.unknowns},
                          {"count_verified", certificate.count_verified},
                          {"eigen_solver", solvers::modes::name_of(certificate.eigen_solver)},
                          {"linear_solver", solvers::modes::name_of(certificate.linear_solver)}}},
                        {"mesh", solvers::mesh::to_json(body.mesh.quality)},
                        {"repair", solvers::mesh::to_json(body.mesh.repair)},
                        {"materials", materials},
                        {"mass_kg", body.modes.mass},
                        {"timing", timing}};
  if (body.modes.size() == 0) out["explanation"] = why_no_mode(body);
  if (!damping.negative.empty()) {
    out["negative_damping"] = {{"modes", damping.negative.size()},
                               {"low_hz", body.modes.frequency(damping.negative.front())},
                               {"high_hz", body.modes.frequency(damping.negative.back())}};
  }
  if (body.pitch_target) out["pitch_target"] = solvers::pitch::to_json(*body.pitch_target, true);
  return out;
}

/// Worst and median of the estimated errors.
void print_pitch_errors(const std::vector<double>& errors) {
  const auto worst = std::max_element(errors.begin(), errors.end());
  fmt::print("estimated pitch error: worst {:.3g} cents (mode {}), median {:.3g}\n", *worst,
             worst - errors.begin() + 1, core::median(errors));
}

void print_table(const scene::Body& body, const synth::damping::DecayRates& damping) {
  const bool turned = !body.modes.harmonics.empty();
  const bool estimated = !body.modes.pitch_errors.empty();
  fmt::print("{:>5} {:>14} {}{:>14} {:>10} {:>10}{}\n", "mode", "frequency [Hz]",
             estimated ? "error [cent] " : "", "decay [1/s]", "T60 [s]", "residual",
             turned ? " harmonic" : "");
  for (std::size_t i = 0; i < body.modes.size(); ++i) {
    fmt::print("{:>5} {:>14.4f} {}{:>14.4f} {:>10.3g} {:>10.1e}{}\n", i + 1,
               body.modes.frequency(i),
               estimated ? fmt::format("{:>12.2g} ", body.modes.pitch_errors[i]) : "",
               damping.values[i], synth::modal::t60(damping.values[i]), body.modes.residuals[i],
               turned ? fmt::format(" {:>8}", body.modes.harmonics[i]) : "");
  }
  if (body.modes.size() == 0) fmt::print("{}\n", why_no_mode(body));
  if (!damping.negative.empty()) {
    fmt::print("{}; shown as 0\n",
               synth::damping::describe_negative(body.modes, scene::damping_of(body.materials),
                                                 damping.negative));
  }
  const solvers::modes::Certificate& certificate = body.modes.certificate;
  fmt::print("\n{} of the {} modes in the band{}; complete to {:.1f} Hz\n", certificate.modes_found,
             certificate.modes_in_band,
             certificate.count_verified ? "" : " that were seen (not counted by inertia)",
             certificate.complete_to_hz);
  fmt::print("{} rigid modes of {} component{}; worst residual {:.1e}\n", certificate.rigid_modes,
             certificate.components, certificate.components == 1 ? "" : "s",
             certificate.max_residual);
  if (estimated) print_pitch_errors(body.modes.pitch_errors);
  const std::string size = turned ? fmt::format("{} unknowns to a harmonic", certificate.unknowns)
                                  : fmt::format("{} elements, {} unknowns",
                                                body.mesh.quality.elements, certificate.unknowns);
  fmt::print("{}, mass {:.4g} kg\n", size, body.modes.mass);
  for (const std::string& action : body.mesh.repair.actions) fmt::print("repair: {}\n", action);
  if (body.pitch_target) print_report(*body.pitch_target);
  for (const auto& [stage, entry] : body.trace.stages) {
    fmt::print("{:<18} {:8.3f} s\n", stage, entry.seconds);
  }
}

}  // namespace

void add_modes(Program& program, Context& context) {
  Command& command =
      program.add("modes", "modes of one shape, with their certificate", Needs::solver);
  auto options = std::make_shared<BodyOptions>();
  auto output = std::make_shared<std::string>();
  add_body_options(command, *options);
  command.option("-o,--output", *output, "HDF5 file for frequencies, shapes and certificate");
  command.footer(
      "Examples:\n"
      "  carillon modes cup.obj --length 0.1 m --material ceramic\n"
      "  carillon modes block:length=50mm,width=30mm,height=20mm -m steel --max-frequency 150kHz\n"
      "  carillon modes bowl -m glass --pitch-cents 5\n"
      "  mpirun -n 2 carillon modes bowl -m glass --json");
  command.does([&context, options, output] {
    const scene::Body body = solve_body(*options, context);
    settle(body.pitch_target, context);
    const auto damping =
        synth::damping::clamped_decay_rates(body.modes, scene::damping_of(body.materials));
    if (!context.speaks()) return;
    if (!output->empty()) {
      core::write_durably(*output, [&](const std::filesystem::path& path) {
        solvers::modes::write_modes(core::Hdf5Group::create_file(path), body.modes);
      });
    }
    if (context.json) {
      fmt::print("{}\n", to_json(body, damping).dump(2));
    } else {
      print_table(body, damping);
    }
  });
}

}  // namespace carillon::cli
