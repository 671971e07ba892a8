#include "dataset/samples/detail/tuned_sets.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "core/error.hpp"
#include "scene/tuned_object.hpp"

namespace carillon::dataset::samples {

namespace {

using synth::material::Material;

/// What scene::untuned_frequency() is asked for a material.
scene::ObjectRequest first_request(const configuration::BuildConfig& config,
                                   const plan::Shape& shape, const plan::Variant& variant) {
  scene::ObjectRequest request;
  request.mesh = shape.request;
  request.materials = plan::region_materials(config, shape, variant);
  request.solver.solver = shape.solver.solver;
  request.solve = config.solver;
  request.solve.time = configuration::solve_clock(config.limits);
  request.limits = config.limits.mesh;
  return request;
}

/// Gives every variant the size that a first solve of its set tells.
void estimate_sizes(const configuration::BuildConfig& config, const BuildFolders& folders,
                    MPI_Comm comm, core::Trace& trace, plan::Shape& shape) {
  std::vector<std::vector<Material>> materials;
  for (plan::Variant& variant : shape.variants) {
    variant.size = 1;
    materials.push_back(scene::listed(plan::region_materials(config, shape, variant)));
  }
  const ModeSets sets = group_variants(materials, shape.variants, config.band);
  std::vector<double> lowest(sets.requests.size(), 0);  // of the set's own material
  for (std::size_t v = 0; v < shape.variants.size(); ++v) {
    plan::Variant& variant = shape.variants[v];
    double& of_set = lowest[sets.variants[v].set];
    const double factor = frequency_factor(sets.variants[v]);
    if (of_set == 0) {
      trace.enter("mesh");
      configuration::within_memory(config.limits.solve_memory, [&] {
        of_set = scene::untuned_frequency(first_request(config, shape, variant), variant.tune_mode,
                                          comm, folders.cache, trace) /
                 factor;
      });
    }
    variant.size = of_set * factor / variant.tune;
  }
}

/// Every variant's materials, in the order of the regions of a mesh.
std::vector<std::vector<Material>> materials_in(const configuration::BuildConfig& config,
                                                const plan::Shape& shape,
                                                const std::vector<std::string>& regions) {
  std::vector<std::vector<Material>> materials;
  for (const plan::Variant& variant : shape.variants)
    materials.push_back(plan::variant_materials(config, shape, variant, regions));
  return materials;
}

}  // namespace

bool is_tuned(const plan::Shape& shape) {
  return shape.variants.front().tune > 0;
}

solvers::pitch::PitchResult make_tuned_sets(const configuration::BuildConfig& config,
                                            const BuildFolders& folders, MPI_Comm comm,
                                            core::Trace& trace, const SetsAtSizes& solve,
                                            plan::Shape& shape) {
  estimate_sizes(config, folders, comm, trace, shape);
  constexpr int tries = 4;
  const int mode = shape.variants.front().tune_mode;
  // Modes below the band lie below the one that is tuned.
  solvers::modes::Band band = config.band;
  band.min_frequency = 0;
  band.max_modes += mode - 1;
  band.max_frequency *= scene::tuning_margin;
  for (int attempt = 1;; ++attempt) {
    solvers::pitch::PitchResult made = solve(shape, band);
    const ModeSets sets = group_variants(materials_in(config, shape, made.mesh.mesh.region_names),
                                         shape.variants, config.band);
    double farthest = 0;
    for (std::size_t v = 0; v < shape.variants.size(); ++v) {
      const solvers::modes::Modes& modes = made.sets[sets.variants[v].set];
      if (modes.size() < static_cast<std::size_t>(mode)) {
        throw core::SolverError(
            fmt::format("mode {}, to tune {} by, was found by a first solve and not by the second",
                        mode, shape.id));
      }
      plan::Variant& variant = shape.variants[v];
      const double larger = modes.frequency(static_cast<std::size_t>(mode - 1)) *
                            frequency_factor(sets.variants[v]) / variant.tune;
      variant.size *= larger;
      farthest = std::max(farthest, larger);
    }
    // A larger body has more modes in the band.
    if (farthest > scene::tuning_margin && attempt < tries) continue;
    const double longest =
        solvers::mesh::bounding_box(made.sets.front().surface.nodes).longest_side();
    for (const plan::Variant& variant : shape.variants) {
      scene::check_size(longest * variant.size, config.objects[shape.source].object.file.any_size);
    }
    return made;
  }
}

void write_tuned_sizes(const core::Hdf5Group& file, const plan::Shape& shape) {
  std::vector<double> sizes;
  for (const plan::Variant& variant : shape.variants) sizes.push_back(variant.size);
  file.write<double>("tuned_sizes", sizes, {sizes.size()});
  file.write_attribute("unit", "1", "tuned_sizes");
}

std::vector<plan::Variant> sized_variants(const plan::Shape& shape, const core::Hdf5Group& file) {
  std::vector<plan::Variant> variants = shape.variants;
  if (!is_tuned(shape)) return variants;
  const auto sizes = file.read<double>("tuned_sizes");
  if (sizes.size() != variants.size()) {
    throw core::FileError(fmt::format("{} has sizes of {} variants, not of {}", shape.id,
                                      sizes.size(), variants.size()));
  }
  for (std::size_t v = 0; v < variants.size(); ++v) variants[v].size = sizes[v];
  return variants;
}

}  // namespace carillon::dataset::samples
