#include "dataset/samples/shape_modes.hpp"

#include <fmt/format.h>

#include "core/error.hpp"
#include "core/hdf5.hpp"
#include "core/random.hpp"
#include "dataset/samples/detail/tuned_sets.hpp"
#include "solvers/elements/lagrange.hpp"
#include "solvers/modes/modes_file.hpp"

namespace carillon::dataset::samples {

namespace {

std::vector<std::vector<Vec3>> read_hulls(const core::Hdf5Group& file) {
  std::vector<std::vector<Vec3>> hulls;
  if (!file.has("hulls")) return hulls;
  const auto values = file.read<double>("hulls/points");
  const auto first = file.read<std::int64_t>("hulls/first");
  for (std::size_t h = 0; h + 1 < first.size(); ++h) {
    hulls.emplace_back();
    for (auto p = static_cast<std::size_t>(first[h]); p < static_cast<std::size_t>(first[h + 1]);
         ++p) {
      hulls.back().emplace_back(values[3 * p], values[3 * p + 1], values[3 * p + 2]);
    }
  }
  return hulls;
}

std::vector<synth::surface::RegionMoments> read_moments(const core::Hdf5Group& file) {
  if (!file.has("moments")) return {};
  const auto volumes = file.read<double>("moments/volume");
  const auto centroids = file.read<double>("moments/centroid");
  const auto spreads = file.read<double>("moments/spread");
  std::vector<synth::surface::RegionMoments> moments;
  for (std::size_t r = 0; r < volumes.size(); ++r) {
    moments.push_back({volumes[r], Eigen::Map<const Vec3>(centroids.data() + 3 * r),
                       Eigen::Map<const Eigen::Matrix3d>(spreads.data() + 9 * r)});
  }
  return moments;
}

ShapeLooks read_looks(const core::Hdf5Group& file) {
  ShapeLooks looks;
  if (file.has("colours")) {
    const auto values = file.read<double>("colours");
    for (std::size_t i = 0; i + 2 < values.size(); i += 3)
      looks.colours.emplace_back(values[i], values[i + 1], values[i + 2]);
  }
  if (file.has("face_regions")) looks.face_regions = file.read<std::int32_t>("face_regions");
  return looks;
}

}  // namespace

DrawnLooks looks_of(const plan::Shape& shape,
                    const std::vector<synth::material::Material>& materials,
                    const ShapeLooks& looks, const solvers::modes::ModeSurface& surface) {
  std::vector<render::looks::Appearance> regions;
  for (const synth::material::Material& material : materials) {
    regions.push_back(synth::material::appearance_of(material));
    regions.back().piece = core::stable_hash(shape.id);
    regions.back().colours = looks.colours;
  }
  DrawnLooks drawn{regions.front(), {{regions.begin() + 1, regions.end()}}};
  if (materials.size() == 1) return drawn;
  const auto faces =
      surface.faces.size() / std::size_t(solvers::elements::nodes_per_face(surface.order));
  if (!looks.face_regions.empty() && looks.face_regions.size() != faces) {
    throw core::InputError(fmt::format("{}: regions of {} faces, and its surface has {}", shape.id,
                                       looks.face_regions.size(), faces));
  }
  // Curved faces are drawn as several triangles.
  const auto pieces = static_cast<std::size_t>(surface.order) * std::size_t(surface.order);
  for (const std::int32_t region : looks.face_regions)
    drawn.faces.of_faces.insert(drawn.faces.of_faces.end(), pieces, region);
  return drawn;
}

void write_looks(const core::Hdf5Group& file, const ShapeLooks& looks) {
  if (!looks.colours.empty()) {
    std::vector<double> values;
    for (const Vec3& colour : looks.colours)
      values.insert(values.end(), colour.begin(), colour.end());
    file.write<double>("colours", values, {looks.colours.size(), 3});
    file.write_attribute("unit", "1", "colours");
  }
  if (!looks.face_regions.empty())
    file.write<std::int32_t>("face_regions", looks.face_regions, {looks.face_regions.size()});
}

void write_moments(const core::Hdf5Group& file,
                   const std::vector<synth::surface::RegionMoments>& moments) {
  std::vector<double> volumes, centroids, spreads;
  for (const synth::surface::RegionMoments& region : moments) {
    volumes.push_back(region.volume);
    centroids.insert(centroids.end(), region.centroid.begin(), region.centroid.end());
    const auto spread = region.spread.reshaped();  // symmetric
    spreads.insert(spreads.end(), spread.begin(), spread.end());
  }
  const std::uint64_t count = moments.size();
  file.write<double>("moments/volume", volumes, {count});
  file.write<double>("moments/centroid", centroids, {count, 3});
  file.write<double>("moments/spread", spreads, {count, 3, 3});
  file.write_attribute("unit", "m^3", "moments/volume");
  file.write_attribute("unit", "m", "moments/centroid");
  file.write_attribute("unit", "m^2", "moments/spread");
}

std::vector<double> read_pitch_errors(const core::Hdf5Group& file) {
  std::vector<double> errors;
  for (const std::string& name : file.names()) {
    if (!name.starts_with("set-") || !file.open_group(name).has("pitch_errors")) continue;
    const auto set = file.open_group(name).read<double>("pitch_errors");
    errors.insert(errors.end(), set.begin(), set.end());
  }
  return errors;
}

void write_hulls(const core::Hdf5Group& file, const std::vector<std::vector<Vec3>>& hulls) {
  std::vector<double> values;
  std::vector<std::int64_t> first = {0};
  for (const auto& hull : hulls) {
    for (const Vec3& p : hull) values.insert(values.end(), p.begin(), p.end());
    first.push_back(static_cast<std::int64_t>(values.size() / 3));
  }
  file.write<double>("hulls/points", values, {values.size() / 3, 3});
  file.write<std::int64_t>("hulls/first", first, {first.size()});
  file.write_attribute("unit", "m", "hulls/points");
}

PlacedVariants placed_variants(const configuration::BuildConfig& config, const plan::Shape& shape,
                               const core::Hdf5Group& file) {
  const auto regions = file.read<std::string>("regions");
  PlacedVariants placed;
  for (const plan::Variant& variant : shape.variants) {
    placed.materials.push_back(plan::variant_materials(config, shape, variant, regions));
  }
  placed.sets = group_variants(placed.materials, sized_variants(shape, file), config.band);
  return placed;
}

ShapeModes::ShapeModes(const configuration::BuildConfig& config, const plan::Shape& shape,
                       const BuildFolders& folders)
    : band_(config.band) {
  const core::Hdf5Group file = core::Hdf5Group::open_file(folders.modes_file(shape));
  placed_ = placed_variants(config, shape, file);
  for (std::size_t s = 0; s < placed_.sets.requests.size(); ++s) {
    solved_.push_back(solvers::modes::read_modes(file.open_group(fmt::format("set-{:03}", s))));
  }
  hulls_ = read_hulls(file);
  moments_ = read_moments(file);
  looks_ = read_looks(file);
}

std::size_t ShapeModes::modes_below(std::size_t variant) const {
  const double factor = frequency_factor(placed_.sets.variants[variant]);
  const solvers::modes::Modes& modes = solved_[set_of(variant)];
  std::size_t below = 0;
  while (below < modes.size() && factor * modes.frequency(below) < band_.min_frequency) ++below;
  return below;
}

solvers::modes::Modes ShapeModes::of(std::size_t variant) const {
  const VariantModes& scale = placed_.sets.variants[variant];
  return solvers::modes::restrict_to(
      solvers::modes::rescale(solved_[scale.set], scale.length, scale.modulus, scale.density),
      band_);
}

}  // namespace carillon::dataset::samples
