#include "dataset/run/expected_shapes.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "core/error.hpp"
#include "dataset/samples/modes_task.hpp"
#include "solvers/axisymmetric/solve_axisymmetric.hpp"
#include "solvers/families/families.hpp"
#include "solvers/pitch/expected_costs.hpp"
#include "solvers/pitch/pitch_target.hpp"

namespace carillon::dataset::run {

namespace {

using solvers::basis::ModeRequest;
using solvers::elements::Elastic;
using solvers::mesh::ShapeExtent;

/// Size that a pitch should lead to, within a factor of about two: a body's first modes bend it
/// along its longest side.
double size_of_pitch(const plan::Variant& variant, const ShapeExtent& extent,
                     const Elastic& elastic) {
  const double speed = std::sqrt(elastic.youngs_modulus / elastic.density);
  const double lowest = speed * extent.thickness / std::pow(extent.longest_side, 2);
  return variant.tune_mode * lowest / variant.tune;
}

/// Physical groups of a file are not known before it is read: one region stands for them.
std::vector<ModeRequest> requests_of(const configuration::BuildConfig& config,
                                     const plan::Shape& shape, const ShapeExtent& extent) {
  const configuration::ObjectSource& source = config.objects[shape.source];
  std::vector<std::vector<synth::material::Material>> materials;
  std::vector<plan::Variant> variants = shape.variants;
  for (plan::Variant& variant : variants) {
    const std::string name =
        source.object.groups.empty() ? variant.material : source.object.groups.begin()->second;
    materials.push_back({synth::material::parse_material(name, config.own_materials)});
    if (variant.tune > 0)
      variant.size = size_of_pitch(variant, extent, materials.back().front().elastic);
  }
  return samples::group_variants(materials, variants, config.band).requests;
}

double modes_below(const ShapeExtent& extent, const Elastic& elastic, double frequency) {
  return solvers::basis::expected_modes(extent.volume, extent.thickness, elastic, frequency);
}

/// Frequency of the last mode that is kept of so many [Hz].
double last_frequency(const ShapeExtent& extent, const ModeRequest& request, double modes) {
  double low = 0, high = request.band.max_frequency;
  for (int i = 0; i < 50; ++i) {
    const double middle = (low + high) / 2;
    (modes_below(extent, request.regions[0], middle) < modes ? low : high) = middle;
  }
  return high;
}

/// Wave number [rad/m] of bending waves in the wall, or of shear waves.
double wave_number(const ShapeExtent& extent, const Elastic& elastic, double frequency) {
  const double omega = 2 * std::numbers::pi * frequency, nu = elastic.poisson_ratio;
  const double bar = std::sqrt(elastic.youngs_modulus / elastic.density);
  const double bending =
      std::sqrt(omega * std::sqrt(12 * (1 - nu * nu)) / (bar * extent.thickness));
  return std::max(bending, omega / (bar / std::sqrt(2 * (1 + nu))));
}

void expect_tetrahedra(const configuration::BuildConfig& config,
                       const std::vector<ModeRequest>& requests, ExpectedShape& shape) {
  solvers::pitch::MeshSize& mesh = shape.object.mesh;
  const ShapeExtent& extent = shape.object.extent;
  if (!config.solver.mirror_planes) mesh.images = 1;
  double shortest = 0;
  for (const ModeRequest& request : requests) {
    const double below = modes_below(extent, request.regions[0], request.band.max_frequency);
    // Slender bodies have more than asymptotic counts say.
    constexpr double slender = 5;
    const double kept =
        std::min({below + slender, double(request.band.max_modes), mesh.unknowns() / 4});
    shape.modes.push_back(kept);
    shortest = std::max(
        shortest, wave_number(extent, request.regions[0], last_frequency(extent, request, kept)));
  }
  const double error = solvers::pitch::expected_error(mesh, shortest);
  shape.last =
      solvers::pitch::expected_refinement(mesh, error, config.pitch_cents, config.max_unknowns);
  shape.probes = shape.last.unknowns() == mesh.unknowns() ? 0 : 1;
  // Edges have curves: each corner of a face has a node, each edge order - 1, and so on.
  const double order = shape.last.order;
  ExpectedSurface& surface = shape.surface;
  surface.order = shape.last.order;
  surface.faces = 2 * shape.last.faces - 4 * shape.last.elements;
  surface.nodes = surface.rows = surface.faces * order * order / 2;
  // Images of one part hold its values again, which zlib finds while they are near.
  constexpr double by_planes[] = {0.93, 0.83, 0.72, 0.25};
  const double planes = std::clamp(std::log2(mesh.images), 0.0, 3.0);
  surface.compressed = by_planes[static_cast<std::size_t>(planes)];
}

void expect_section(const configuration::BuildConfig& config, const plan::Shape& of,
                    const std::vector<ModeRequest>& requests, ExpectedShape& shape) {
  std::vector<solvers::axisymmetric::MaterialBand> wanted;
  for (const ModeRequest& request : requests) wanted.push_back({request.regions[0], request.band});
  solvers::axisymmetric::AxisymmetricOptions options;
  options.pitch_target = config.pitch_cents;
  const solvers::mesh::GeneratedShape& turned = of.request.shape;
  const auto section = solvers::axisymmetric::expected_section(
      solvers::families::find_family(turned.family).meridian(turned), wanted, options);
  shape.modes = section.modes;
  shape.about_axis = true;
  shape.surface = {section.surface_nodes, section.surface_faces, 3, section.rings, 0.96};
}

}  // namespace

double ExpectedShape::max_modes() const {
  return modes.empty() ? 0 : *std::max_element(modes.begin(), modes.end());
}

double ExpectedShape::mean_modes() const {
  return modes.empty()
             ? 0
             : std::accumulate(modes.begin(), modes.end(), 0.0) / static_cast<double>(modes.size());
}

std::vector<ExpectedShape> expected_shapes(const configuration::BuildConfig& config,
                                           const plan::BuildPlan& plan) {
  std::vector<ExpectedShape> out;
  for (const plan::Shape& shape : plan.shapes) {
    ExpectedShape& expected = out.emplace_back();
    expected.object = plan::expected_object(shape);
    expected.last = expected.object.mesh;
    const std::vector<ModeRequest> requests = requests_of(config, shape, expected.object.extent);
    if (shape.solver.solver == scene::ObjectSolver::axisymmetric) {
      try {
        expect_section(config, shape, requests, expected);
        continue;
      } catch (const core::Error&) {
        // What is wrong is for the task to say.
      }
    }
    expect_tetrahedra(config, requests, expected);
  }
  return out;
}

double modes_seconds(const ExpectedShape& shape) {
  // Of a section's harmonics, within a factor of two.
  constexpr double seconds_per_set = 0.025, seconds_per_mode = 0.0035;
  if (shape.about_axis)
    return static_cast<double>(shape.modes.size()) *
           (seconds_per_set + seconds_per_mode * shape.mean_modes());
  using solvers::pitch::ExpectedSets;
  using solvers::pitch::mesh_seconds;
  using solvers::pitch::solve_seconds;
  const double max = shape.max_modes();
  double seconds = mesh_seconds(shape.last);
  seconds += shape.probes *
             (mesh_seconds(shape.object.mesh) + solve_seconds(shape.object.mesh, {1, max, 1}));
  // Sets of far fewer modes than the largest are solved apart from it. Up to three are solved one
  // by one, more from a basis of three (solve_materials.hpp).
  ExpectedSets large{0, max, 0}, small{0, 0, 0};
  for (const double modes : shape.modes) {
    ExpectedSets& group = modes > max / 2 ? large : small;
    group.modes = std::max(group.modes, modes);
    ++group.sets;
  }
  for (ExpectedSets* group : {&large, &small}) {
    if (group->sets == 0) continue;
    group->solves = std::min(group->sets, 3.0);
    seconds += solve_seconds(shape.last, *group);
  }
  return seconds;
}

}  // namespace carillon::dataset::run
