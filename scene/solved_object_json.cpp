#include "scene/solved_object_json.hpp"

#include <fmt/format.h>

#include "solvers/eigen/search.hpp"

namespace carillon::scene {

std::string why_no_mode(const SolvedObject& object) {
  const solvers::modes::Certificate& certificate = object.modes.certificate;
  std::string text =
      fmt::format("no mode lies between {:.6g} and {:.6g} Hz{}", certificate.min_frequency,
                  certificate.max_frequency, certificate.count_verified ? ", by count" : "");
  // Harmonics of a turned object come without a mesh to guess from.
  if (object.mesh.mesh.faces.empty()) return text;
  const double guess =
      solvers::eigen::estimate_first_frequency(object.mesh.mesh, elastic_of(object.materials));
  text += fmt::format("; the object's first is expected near {:.2g} Hz", guess);
  if (guess > certificate.max_frequency) text += ": raise max_frequency";
  if (guess < certificate.min_frequency) text += ": lower min_frequency";
  return text;
}

nlohmann::json to_json(const SolvedObject& object, const synth::damping::DecayRates& damping) {
  nlohmann::json modes = nlohmann::json::array();
  const std::vector<int> harmonics = object.modes.shapes.harmonics();
  for (std::size_t i = 0; i < object.modes.size(); ++i) {
    modes.push_back({{"frequency_hz", object.modes.frequency(i)},
                     {"decay_rate_per_s", damping.values[i]},
                     {"residual", object.modes.residuals[i]}});
    if (!object.modes.pitch_errors.empty()) {
      modes.back()["pitch_error_cents"] = object.modes.pitch_errors[i];
    }
    if (!harmonics.empty()) modes.back()["harmonic"] = harmonics[i];
  }
  const solvers::modes::Certificate& certificate = object.modes.certificate;
  nlohmann::json timing = nlohmann::json::object();
  for (const auto& [stage, entry] : object.trace.stages) timing[stage + "_s"] = entry.seconds;
  nlohmann::json materials = nlohmann::json::array();
  for (const synth::material::Material& material : object.materials)
    materials.push_back(material.name);
  nlohmann::json out = {
      {"modes", modes},
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
        {"mirror_planes", certificate.mirror_planes},
        {"count_verified", certificate.count_verified},
        {"eigen_solver", solvers::modes::name_of(certificate.eigen_solver)},
        {"linear_solver", solvers::modes::name_of(certificate.linear_solver)}}},
      {"solver", {{"name", name_of(object.solver.solver)}, {"reason", object.solver.reason}}},
      {"mesh", nullptr},
      {"repair", nullptr},
      {"warnings", object.warnings},
      {"materials", materials},
      {"mass_kg", object.modes.mass},
      {"timing", timing}};
  if (!object.modes.given_decay_rates.empty()) out["certificate"] = nullptr;  // nothing was solved
  if (object.solver.solver == ObjectSolver::tetrahedra) {
    out["mesh"] = solvers::mesh::to_json(object.mesh.quality);
    out["repair"] = solvers::mesh::to_json(object.mesh.repair);
  }
  if (object.size != 1) out["size"] = object.size;
  if (object.modes.size() == 0) out["explanation"] = why_no_mode(object);
  if (!damping.negative.empty()) {
    out["negative_damping"] = {{"modes", damping.negative.size()},
                               {"low_hz", object.modes.frequency(damping.negative.front())},
                               {"high_hz", object.modes.frequency(damping.negative.back())}};
  }
  if (object.pitch_target)
    out["pitch_target"] = solvers::pitch::to_json(*object.pitch_target, true);
  return out;
}

}  // namespace carillon::scene
