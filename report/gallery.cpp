#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

#include "core/base64.hpp"
#include "core/error.hpp"
#include "dataset/samples/shape_modes.hpp"
#include "render/frame.hpp"
#include "render/shading_mesh.hpp"
#include "report/detail/gallery_skin.hpp"
#include "report/report.hpp"
#include "scene/solved_object.hpp"
#include "solvers/elements/lagrange.hpp"
#include "synth/damping/damping.hpp"

namespace carillon::report {

using nlohmann::ordered_json;

namespace {

/// Of them a listener hears no more: without a limit, plates of a soft material have thousands.
constexpr std::size_t max_modes = 256;
/// Fewer are no object to strike.
constexpr std::size_t min_modes = 12;
/// Factors between which damping is tabulated: those of the page's sliders (stiffness 20, density
/// 1/10, size 1/4) at their ends.
constexpr double widest_factor = 3200;

bool is_rayleigh(const synth::damping::DampingModel& damping) {
  return damping.kind == synth::damping::DampingKind::rayleigh && damping.parameters.size() == 2;
}

/// Displacement along the normal at every vertex, mode by mode, as shares of each mode's largest.
void add_gains(const solvers::modes::Modes& modes, const render::ShadingMesh& mesh,
               std::size_t count, ordered_json& object) {
  const std::size_t vertices = mesh.sources.size();
  std::vector<std::int16_t> shares(count * vertices);
  std::vector<double> scales(count);
  std::vector<double> gains(vertices);
  for (std::size_t mode = 0; mode < count; ++mode) {
    const Eigen::VectorXd shape = modes.shapes.of(static_cast<Eigen::Index>(mode));
    for (std::size_t v = 0; v < vertices; ++v) {
      const auto node = 3 * static_cast<Eigen::Index>(mesh.sources[v]);
      gains[v] = 0;
      for (std::size_t k = 0; k < 3; ++k) {
        gains[v] += shape[node + static_cast<Eigen::Index>(k)] *
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

/// Displacements of the lowest modes in the room, x y z at every vertex, mode by mode as shares of
/// each mode's largest: for the eye, which 8 bits are enough for.
void add_shapes(const solvers::modes::Modes& modes, const GallerySkin& skin, ordered_json& object) {
  std::vector<std::int8_t> shares;
  std::vector<double> scales;
  for (std::size_t mode = 0; mode < skin.moving(); ++mode) {
    const Eigen::VectorXd shape = modes.shapes.of(static_cast<Eigen::Index>(mode));
    double largest = 0;
    for (const std::int32_t node : skin.mesh.sources) {
      largest = std::max(largest, shape.segment<3>(3 * Eigen::Index{node}).norm());
    }
    for (const std::int32_t node : skin.mesh.sources) {
      for (Eigen::Index k = 0; k < 3; ++k) {
        const double share = largest > 0 ? shape[3 * Eigen::Index{node} + k] / largest : 0;
        shares.push_back(static_cast<std::int8_t>(std::lround(127 * share)));
      }
    }
    scales.push_back(largest);
  }
  object["shapes"] = core::base64(std::span<const std::int8_t>(shares));
  object["shape_scales"] = scales;
}

/// Decay rates d [1/s] of each mode when its eigenvalue is multiplied by factors from
/// 1 / widest_factor to widest_factor, evenly spaced in their logarithm: n x damping_factors,
/// whatever the law is and of how many regions.
std::string tabulated_damping(const solvers::modes::Modes& modes, std::size_t count,
                              std::span<const synth::damping::DampingModel> regions) {
  solvers::modes::Modes scaled;
  scaled.kinetic_fraction = modes.kinetic_fraction;
  scaled.strain_fraction = modes.strain_fraction;
  std::vector<float> table(count * damping_factors);
  for (std::size_t k = 0; k < damping_factors; ++k) {
    const double factor =
        std::pow(widest_factor, 2.0 * static_cast<double>(k) / (damping_factors - 1) - 1);
    scaled.eigenvalues.clear();
    for (const double lambda : modes.eigenvalues) scaled.eigenvalues.push_back(factor * lambda);
    const std::vector<double> rates = synth::damping::clamped_decay_rates(scaled, regions).values;
    for (std::size_t i = 0; i < count; ++i) {
      table[i * damping_factors + k] = static_cast<float>(rates[i]);
    }
  }
  return core::base64(std::span<const float>(table));
}

/// What the page may change: Rayleigh's parameters of one material, else all rates by a factor.
void add_damping(const solvers::modes::Modes& modes, std::size_t count,
                 const std::vector<synth::material::Material>& materials, ordered_json& object) {
  std::vector<synth::damping::DampingModel> regions;
  for (const synth::material::Material& material : materials) regions.push_back(material.damping);
  object["regions"] = materials.size();
  object["rayleigh"] = nullptr;
  object["damping"] = nullptr;
  if (materials.size() == 1 && is_rayleigh(regions.front())) {
    object["rayleigh"] = regions.front().parameters;
  } else {
    object["damping"] = {{"law", materials.size() == 1 ? synth::damping::formula_of(regions.front())
                                                       : "of several materials"},
                         {"widest_factor", widest_factor},
                         {"rates", tabulated_damping(modes, count, regions)}};
  }
}

void add_material(const std::vector<synth::material::Material>& materials, const std::string& name,
                  ordered_json& object) {
  const synth::material::Material& first = materials.front();
  object["material"] = name;
  object["youngs_modulus"] = first.elastic.youngs_modulus;
  object["density"] = first.elastic.density;
}

/// What its parts look like, each with how many of the faces are its own, and the colours of its
/// file at the vertices as square roots of linear reflectances: 8 bits tell dark ones apart so.
void add_looks(const dataset::samples::DrawnLooks& drawn, const GallerySkin& skin,
               ordered_json& object) {
  ordered_json& looks = object["looks"] = ordered_json::array();
  for (std::size_t part = 0; part < skin.parts.size(); ++part) {
    const render::Appearance& look = part == 0 ? drawn.body : drawn.faces.others[part - 1];
    looks.push_back({{"color", std::array{look.color.x(), look.color.y(), look.color.z()}},
                     {"roughness", look.roughness},
                     {"metallic", look.metallic},
                     {"transmission", look.transmission},
                     {"faces", skin.parts[part]}});
  }
  if (drawn.body.colours.empty()) return;
  std::vector<std::uint8_t> colours;
  for (const std::int32_t node : skin.mesh.sources) {
    for (const double linear : drawn.body.colours[static_cast<std::size_t>(node)]) {
      colours.push_back(static_cast<std::uint8_t>(std::lround(255 * std::sqrt(linear))));
    }
  }
  object["colours"] = core::base64(std::span<const std::uint8_t>(colours));
}

/// Looks of the surface's faces, of which each is drawn as several triangles.
std::vector<std::int32_t> looks_of_faces(const dataset::samples::DrawnLooks& drawn, int order) {
  const auto pieces = static_cast<std::size_t>(order * order);
  std::vector<std::int32_t> looks;
  for (std::size_t i = 0; i < drawn.faces.of_faces.size(); i += pieces) {
    looks.push_back(drawn.faces.of_faces[i]);
  }
  return looks;
}

void add_surface(const solvers::modes::ModeSurface& surface, const GallerySkin& skin,
                 ordered_json& object) {
  const render::ShadingMesh& mesh = skin.mesh;
  std::vector<float> positions;
  std::vector<std::int8_t> normals;
  for (std::size_t v = 0; v < mesh.sources.size(); ++v) {
    const Vec3& node = surface.nodes[static_cast<std::size_t>(mesh.sources[v])];
    for (Eigen::Index k = 0; k < 3; ++k) {
      positions.push_back(static_cast<float>(node[k]));
      normals.push_back(static_cast<std::int8_t>(
          std::lround(127 * mesh.normals[3 * v + static_cast<std::size_t>(k)])));
    }
  }
  object["vertices_count"] = mesh.sources.size();
  object["vertices"] = core::base64(std::span<const float>(positions));
  object["normals"] = core::base64(std::span<const std::int8_t>(normals));
  object["order"] = skin.order;
  object["lattice"] = solvers::elements::triangle_lattice(skin.order);
  object["faces"] = core::base64(std::span<const std::uint32_t>(skin.faces));
}

/// @return null where its surface and some modes take more than `bytes`
ordered_json object_of(const dataset::plan::Shape& shape,
                       const dataset::samples::ShapeModes& solved, std::size_t variant,
                       const solvers::modes::Modes& modes, std::size_t bytes) {
  const std::vector<synth::material::Material>& materials = solved.materials(variant);
  const auto drawn = dataset::samples::looks_of(shape, materials, solved.looks(), modes.surface);
  const std::size_t wanted = std::min(modes.size(), max_modes);
  const GallerySkin skin = skin_that_fits(
      modes.surface, {wanted, bytes, materials.size(), looks_of_faces(drawn, modes.surface.order),
                      !drawn.body.colours.empty()});
  const std::size_t count = skin.modes;
  if (count < std::min(wanted, min_modes)) return nullptr;

  const dataset::plan::Variant& planned = shape.variants[variant];
  const double size = solved.size(variant);
  ordered_json object = {{"name", fmt::format("{}, {}", shape.id, planned.material)},
                         {"object", shape.id},
                         {"size", size}};
  if (planned.tune > 0 || size != 1) {
    object["name"] =
        fmt::format("{}, {} {}", object["name"].get<std::string>(),
                    planned.tune > 0 ? "tuned to" : "size", dataset::plan::size_name(planned));
  }
  add_material(materials, planned.material, object);
  add_damping(modes, count, materials, object);
  add_looks(drawn, skin, object);
  object["modes_left_out"] = modes.size() - count;
  object["complete_to_hz"] =
      count < modes.size() ? modes.frequency(count) : modes.certificate.complete_to_hz;
  object["set"] = solved.set_of(variant);
  object["modes_below"] = solved.modes_below(variant);
  object["eigenvalues"] = core::base64(std::span(modes.eigenvalues).first(count));
  object["pitch_errors"] = nullptr;
  if (!modes.pitch_errors.empty()) {
    const std::vector<float> errors(
        modes.pitch_errors.begin(),
        modes.pitch_errors.begin() + static_cast<std::ptrdiff_t>(count));
    object["pitch_errors"] = core::base64(std::span<const float>(errors));
  }
  add_surface(modes.surface, skin, object);
  add_gains(modes, skin.mesh, count, object);
  add_shapes(modes, skin, object);
  return object;
}

}  // namespace

ordered_json gallery_objects(const dataset::stored::StoredDataset& dataset, ReportShare share,
                             ordered_json& notes) {
  const dataset::samples::BuildFolders folders{dataset.folder, {}};
  const std::vector<dataset::plan::Shape>& all = dataset.build.plan.shapes;
  std::vector<const dataset::plan::Shape*> there;
  for (const dataset::plan::Shape& shape : all) {
    if (std::filesystem::is_regular_file(folders.modes_file(shape))) there.push_back(&shape);
  }
  ordered_json objects = ordered_json::array();
  const std::size_t count = std::min(share.count, there.size());
  const std::size_t given = share.bytes;
  std::size_t large = 0, silent = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const dataset::plan::Shape& shape = *there[(2 * i + 1) * there.size() / (2 * count)];
    try {
      const dataset::samples::ShapeModes solved(dataset.build.config, shape, folders);
      // One variant after the other, so that different materials are heard; what one leaves of
      // its share is the others'.
      const std::size_t v = i % shape.variants.size();
      const solvers::modes::Modes modes = solved.of(v);
      if (modes.size() == 0) {
        ++silent;
        continue;
      }
      ordered_json object = object_of(shape, solved, v, modes, share.bytes / (count - i));
      if (object.is_null()) {
        ++large;
        continue;
      }
      share.bytes -= std::min(share.bytes, object.dump().size());
      objects.push_back(std::move(object));
    } catch (const core::Error& error) {
      notes.push_back(fmt::format("{} cannot be struck: {}", shape.id, error.message()));
    }
  }
  return {{"objects", std::move(objects)},
          {"bytes", given - share.bytes},
          {"left_out",
           {{"without modes (yet)", all.size() - there.size()},
            {"beyond --objects", there.size() - count},
            {"with no mode in the band", silent},
            {"of more triangles than this page can hold for each", large}}}};
}

ordered_json gallery_materials() {
  ordered_json list = ordered_json::array();
  for (const synth::material::Material& material : synth::material::preset_materials()) {
    // Other isotropic solids have the modes of an object, rescaled; anisotropic ones have others.
    if (material.elastic.anisotropy) continue;
    if (!is_rayleigh(material.damping)) continue;
    list.push_back({{"name", material.name},
                    {"youngs_modulus", material.elastic.youngs_modulus},
                    {"density", material.elastic.density},
                    {"alphas", material.damping.parameters}});
  }
  return list;
}

}  // namespace carillon::report
