#include <fmt/format.h>

#include "core/error.hpp"
#include "eval/recorded_objects/impact_report.hpp"

namespace carillon::eval::recorded_objects {

namespace {

/// Further off its vertex, the strike is on another part of the object [fraction of the longest
/// side].
constexpr double off_the_mesh = 0.02;

/// Strikes on the surface that was solved, where the folder has them.
std::vector<ModelStrike> model_strikes(const ImpactFolder& folder,
                                       const std::vector<RecordedStrike>& strikes,
                                       const solvers::modes::ModeSurface& surface,
                                       std::vector<std::string>& remarks) {
  const synth::modal::SurfaceSampler sampler(surface);
  const double size = solvers::mesh::bounding_box(surface.nodes).longest_side();
  std::vector<ModelStrike> model;
  for (const RecordedStrike& strike : strikes) {
    ModelStrike one;
    one.point = sampler.nearest(folder.struck[strike.row]);
    const synth::modal::PointFrame frame = synth::modal::frame_at(surface, one.point);
    one.direction = -frame.normal;
    one.listener.position = folder.listeners[strike.row];
    const double off = (frame.position - folder.struck[strike.row]).norm();
    if (off > off_the_mesh * size) {
      remarks.push_back(fmt::format("vertex {} lies {:.2g} mm off the object that was solved",
                                    strike.vertex, 1000 * off));
    }
    model.push_back(one);
  }
  return model;
}

double specific_modulus(const scene::SolvedObject& object, const std::string& mesh) {
  if (object.materials.size() != 1) {
    throw core::InputError(fmt::format("{} has {} regions", mesh, object.materials.size()),
                           "an object is compared as one of one material");
  }
  if (object.modes.size() == 0) {
    throw core::InputError(fmt::format("{} has no mode in its band", mesh),
                           "raise --max-frequency, or check that the mesh is in metres");
  }
  const solvers::elements::Elastic& elastic = object.materials.front().elastic;
  return elastic.youngs_modulus / elastic.density;
}

}  // namespace

ImpactReport study_object(const ImpactFolder& folder, const std::vector<RecordedStrike>& rows,
                          const scene::SolvedObject& object, const StudyOptions& options, bool fit,
                          const std::filesystem::path& cache) {
  const double modulus = specific_modulus(object, folder.mesh.string());
  ImpactReport report{.folder = folder,
                      .options = options,
                      .material = object.materials.front(),
                      .strikes = {},
                      .model = {},
                      .given = {},
                      .fitted = {},
                      .fit = {},
                      .variants = {},
                      .remarks = {},
                      .trace = object.trace};
  report.model = model_strikes(folder, rows, object.modes.surface, report.remarks);
  {
    const core::ScopedTimer timer(report.trace.stages["radiation"]);
    report.given =
        hear_object(object.modes, modulus, modulus, report.model, options.radiation, cache);
  }
  {
    const core::ScopedTimer timer(report.trace.stages["features"]);
    report.strikes =
        study_strikes(folder, rows, options, report.model, report.given, report.remarks);
  }
  if (fit) {
    const core::ScopedTimer timer(report.trace.stages["fit"]);
    report.fit = fit_material(report.strikes, report.model, report.given, report.material,
                              report.fitted, options, cache);
  }
  report.variants = compare_variants(
      report.strikes, report.model, report.given, report.material.damping,
      report.fitted ? &*report.fitted : nullptr, report.fitted ? &*report.fit : nullptr, options);
  return report;
}

}  // namespace carillon::eval::recorded_objects
