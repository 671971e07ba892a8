#include "eval/scoring/object_truth.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "core/error.hpp"
#include "dataset/samples/shape_modes.hpp"
#include "dataset/stored/stored_dataset.hpp"
#include "synth/damping/damping.hpp"

namespace carillon::eval::scoring {

namespace {

TrueObject true_object(const std::string& name, const dataset::samples::ShapeModes& solved,
                       std::size_t variant) {
  const solvers::modes::Modes modes = solved.of(variant);
  std::vector<synth::damping::DampingModel> regions;
  for (const synth::material::Material& material : solved.materials(variant)) {
    regions.push_back(material.damping);
  }
  TrueObject object{name,
                    modes.eigenvalues,
                    modes.pitch_errors,
                    synth::damping::clamped_decay_rates(modes, regions).values,
                    {}};
  if (regions.size() == 1 && regions.front().kind == synth::damping::DampingKind::rayleigh) {
    object.alphas = regions.front().parameters;
  }
  return object;
}

}  // namespace

TrueObjects open_true_objects(const std::filesystem::path& folder,
                              const std::optional<dataset::exporters::Seal>& seal) {
  const dataset::stored::StoredDataset dataset = dataset::stored::open_dataset(folder, "");
  const dataset::samples::BuildFolders folders{folder, {}};
  const dataset::plan::BuildPlan& plan = dataset.build.plan;
  TrueObjects truth{folder.string(), {}, {}};
  std::map<std::pair<std::size_t, std::size_t>, std::size_t> place;
  for (std::size_t s = 0; s < plan.shapes.size(); ++s) {
    const dataset::plan::Shape& shape = plan.shapes[s];
    if (shape.split_shape != "test") continue;
    // What failed has no samples either.
    if (!std::filesystem::is_regular_file(folders.modes_file(shape))) continue;
    const dataset::samples::ShapeModes solved(dataset.build.config, shape, folders);
    for (std::size_t v = 0; v < shape.variants.size(); ++v) {
      const dataset::plan::Variant& variant = shape.variants[v];
      if (!variant.sounds) continue;
      place[{s, v}] = truth.objects.size();
      truth.objects.push_back(
          true_object(dataset::plan::object_name(shape.id, variant), solved, v));
    }
  }
  for (const dataset::plan::Sample& sample : plan.samples) {
    const auto at = place.find({sample.shape, sample.variant});
    if (at == place.end()) continue;
    truth.sample[sample.key] = at->second;
    if (seal) truth.sample[seal->id_of(sample.key)] = at->second;
  }
  if (truth.objects.empty()) {
    throw core::InputError(fmt::format("{}: no object is held out by split_shape", folder.string()),
                           "more objects, or a larger split.test in the dataset's configuration");
  }
  return truth;
}

}  // namespace carillon::eval::scoring
