#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>

#include "cli/body.hpp"
#include "cli/build/shape_modes.hpp"
#include "cli/report/report.hpp"
#include "core/base64.hpp"
#include "core/error.hpp"
#include "render/frame.hpp"
#include "render/shading_mesh.hpp"
#include "synth/damping.hpp"

namespace carillon::cli {

using nlohmann::ordered_json;

namespace {

/// Modes of an object in the page: a blow's contact time leaves little of higher ones.
constexpr std::size_t most_modes = 64;
/// Faces that meet at more than this have an edge between them.
constexpr double crease = 40 * std::numbers::pi / 180;

bool is_rayleigh(const synth::DampingModel& damping) {
  return damping.kind == synth::DampingKind::rayleigh && damping.parameters.size() == 2;
}

/// Displacement along the normal at every vertex, mode by mode, as shares of each mode's largest.
void add_gains(const solvers::Modes& modes, const render::ShadingMesh& mesh, std::size_t count,
               ordered_json& object) {
  const std::size_t vertices = mesh.sources.size();
  std::vector<std::int16_t> shares(count * vertices);
  std::vector<double> scales(count);
  std::vector<double> gains(vertices);
  for (std::size_t mode = 0; mode < count; ++mode) {
    for (std::size_t v = 0; v < vertices; ++v) {
      const auto node = 3 * static_cast<Eigen::Index>(mesh.sources[v]);
      gains[v] = 0;
      for (std::size_t k = 0; k < 3; ++k) {
        gains[v] += static_cast<double>(modes.shapes(static_cast<Eigen::Index>(mode),
                                                     node + static_cast<Eigen::Index>(k))) *
                    static_cast<double>(mesh.normals[3 * v + k]);
      }
      scales[mode] = std::max(scales[mode], std::abs(gains[v]));
    }
    for (std::size_t v = 0; v < vertices && scales[mode] > 0; ++v) {
      shares[mode * vertices + v] =
          static_cast<std::int16_t>(std::lround(32767 * gains[v] / scales[mode]));
    }
  }
  object["gains"] = core::base64(std::span<const std::int16_t>(shares));
  object["gain_scales"] = scales;
}

void add_surface(const solvers::ModeSurface& surface, const render::ShadingMesh& mesh,
                 ordered_json& object) {
  std::vector<float> positions;
  std::vector<std::int8_t> normals;
  for (std::size_t v = 0; v < mesh.sources.size(); ++v) {
    const solvers::Vec3& node = surface.nodes[static_cast<std::size_t>(mesh.sources[v])];
    for (Eigen::Index k = 0; k < 3; ++k) {
      positions.push_back(static_cast<float>(node[k]));
      normals.push_back(static_cast<std::int8_t>(
          std::lround(127 * mesh.normals[3 * v + static_cast<std::size_t>(k)])));
    }
  }
  object["vertices_count"] = mesh.sources.size();
  object["vertices"] = core::base64(std::span<const float>(positions));
  object["normals"] = core::base64(std::span<const std::int8_t>(normals));
  object["triangles"] = core::base64(std::span<const std::uint32_t>(mesh.indices));
}

ordered_json describe_material(const std::vector<synth::Material>& materials,
                               const std::string& name) {
  const synth::Material& first = materials.front();
  const render::Appearance appearance = render::appearance_of(first.name);
  ordered_json object = {{"material", name},
                         {"youngs_modulus", first.elastic.youngs_modulus},
                         {"density", first.elastic.density},
                         {"rayleigh", nullptr},
                         {"appearance",
                          {{"color", appearance.color},
                           {"roughness", appearance.roughness},
                           {"metallic", appearance.metallic}}}};
  if (materials.size() == 1 && is_rayleigh(first.damping)) {
    object["rayleigh"] = first.damping.parameters;
  }
  return object;
}

ordered_json object_of(const Shape& shape, const ShapeModes& all, std::size_t v) {
  const Variant& variant = shape.variants[v];
  const solvers::Modes modes = all.of(v);
  const std::vector<synth::Material>& materials = all.materials(v);
  ordered_json object = describe_material(materials, variant.material);
  object["name"] = fmt::format("{}, {}", shape.id, variant.material);
  if (variant.size != 1) {
    object["name"] = fmt::format("{}, size {}", object["name"].get<std::string>(), variant.size);
  }
  object["body"] = shape.id;
  object["size"] = variant.size;
  const std::size_t count = std::min(modes.size(), most_modes);
  std::vector<synth::DampingModel> damping;
  for (const synth::Material& material : materials) damping.push_back(material.damping);
  const std::vector<double> decay_rates = synth::clamped_decay_rates(modes, damping).values;
  object["modes_left_out"] = modes.size() - count;
  object["eigenvalues"] = core::base64(std::span(modes.eigenvalues).first(count));
  object["decay_rates"] = core::base64(std::span(decay_rates).first(count));
  const solvers::SurfaceMesh mesh = solvers::flatten(modes.surface);
  const render::ShadingMesh shading =
      render::shading_mesh(mesh, render::bounding_ball(mesh), crease);
  add_surface(modes.surface, shading, object);
  add_gains(modes, shading, count, object);
  return object;
}

}  // namespace

ordered_json gallery_objects(const StoredDataset& dataset, ReportShare share, ordered_json& notes) {
  const BuildFolders folders{dataset.folder, {}};
  std::vector<const Shape*> there;
  for (const Shape& shape : dataset.build.plan.shapes) {
    if (std::filesystem::is_regular_file(folders.modes_file(shape))) there.push_back(&shape);
  }
  ordered_json objects = ordered_json::array();
  const std::size_t count = std::min(share.count, there.size());
  std::size_t bytes = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const Shape& shape = *there[(2 * i + 1) * there.size() / (2 * count)];
    try {
      const ShapeModes modes(dataset.build.config, shape, folders);
      // One variant after the other, so that different materials are heard.
      ordered_json object = object_of(shape, modes, i % shape.variants.size());
      const std::size_t size = object.dump().size();
      const bool silent = object.at("eigenvalues").get_ref<const std::string&>().empty();
      if (silent || bytes + size > share.bytes) continue;
      bytes += size;
      objects.push_back(std::move(object));
    } catch (const core::Error& error) {
      notes.push_back(fmt::format("{} cannot be struck: {}", shape.id, error.message()));
    }
  }
  return objects;
}

ordered_json gallery_materials() {
  ordered_json list = ordered_json::array();
  for (const synth::Material& material : synth::preset_materials()) {
    if (!is_rayleigh(material.damping)) continue;
    list.push_back({{"name", material.name},
                    {"youngs_modulus", material.elastic.youngs_modulus},
                    {"density", material.elastic.density},
                    {"alphas", material.damping.parameters}});
  }
  return list;
}

}  // namespace carillon::cli
