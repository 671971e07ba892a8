#include "dataset/exporters/gltf_document.hpp"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "core/revision.hpp"
#include "dataset/exporters/detail/glb_file.hpp"

namespace carillon::dataset::exporters {

using nlohmann::ordered_json;

namespace {

/// Straight lines between so many keyframes stay within half a percent of a sine.
constexpr int keys_of_swing = 32;

constexpr const char* transmission_extension = "KHR_materials_transmission";

ordered_json material_json(const GltfMaterial& material) {
  const Vec3& color = material.appearance.color;
  ordered_json json = {{"name", material.name},
                       {"pbrMetallicRoughness",
                        {{"baseColorFactor", {color[0], color[1], color[2], 1.0}},
                         {"metallicFactor", material.appearance.metallic},
                         {"roughnessFactor", material.appearance.roughness}}}};
  if (material.appearance.transmission > 0) {
    json["extensions"][transmission_extension] = {
        {"transmissionFactor", material.appearance.transmission}};
  }
  return json;
}

void add_materials(GlbFile& file, const std::vector<GltfMaterial>& materials) {
  bool clear = false;
  for (const GltfMaterial& material : materials) {
    file.document["materials"].push_back(material_json(material));
    clear = clear || material.appearance.transmission > 0;
  }
  if (clear) file.document["extensionsUsed"].push_back(transmission_extension);
}

ordered_json primitives(GlbFile& file, const GltfObject& object) {
  const GltfSurface& surface = object.surface;
  const ordered_json attributes = {{"POSITION", file.add_vertices(surface.positions, true)},
                                   {"NORMAL", file.add_vertices(surface.normals, false)}};
  ordered_json targets = ordered_json::array();
  for (const GltfMode& mode : object.modes) {
    targets.push_back({{"POSITION", file.add_vertices(mode.target.positions, true)},
                       {"NORMAL", file.add_vertices(mode.target.normals, false)}});
  }
  ordered_json list = ordered_json::array();
  for (std::size_t region = 0; region < surface.regions.size(); ++region) {
    if (surface.regions[region].empty()) continue;  // within others
    list.push_back({{"attributes", attributes},
                    {"indices", file.add_indices(surface.regions[region])},
                    {"material", region}});
    if (!targets.empty()) list.back()["targets"] = targets;
  }
  return list;
}

/// One swing of each mode: the sine of its weight, all others at rest.
ordered_json animations(GlbFile& file, const GltfObject& object) {
  std::vector<float> times;
  for (int key = 0; key <= keys_of_swing; ++key) {
    times.push_back(static_cast<float>(object.period * key / keys_of_swing));
  }
  const std::size_t input = file.add_times(times);
  ordered_json list = ordered_json::array();
  for (std::size_t mode = 0; mode < object.modes.size(); ++mode) {
    std::vector<float> weights(times.size() * object.modes.size(), 0.0F);
    for (std::size_t key = 0; key < times.size(); ++key) {
      const double turn = 2 * std::numbers::pi * static_cast<double>(key) / keys_of_swing;
      weights[key * object.modes.size() + mode] = static_cast<float>(std::sin(turn));
    }
    list.push_back(
        {{"name", object.modes[mode].name},
         {"channels", {{{"sampler", 0}, {"target", {{"node", 0}, {"path", "weights"}}}}}},
         {"samplers",
          {{{"input", input}, {"interpolation", "LINEAR"}, {"output", file.add_numbers(weights)}}}},
         {"extras", {{"slowed_by", object.modes[mode].frequency * object.period}}}});
  }
  return list;
}

constexpr const char* audio_extension = "KHR_audio_rigid_bodies";

/// The modal model, and the node that has it.
void add_audio(GlbFile& file, const GltfAudio& audio, const std::string& name) {
  ordered_json model = {{"name", name},
                        {"frequencies", file.add_numbers(audio.frequencies)},
                        {"decayRates", file.add_numbers(audio.decay_rates)},
                        {"positions", file.add_vectors(audio.positions)},
                        {"shapes", file.add_vectors(audio.shapes)},
                        {"indices", file.add_whole_numbers(audio.indices)},
                        {"massProperties", audio.mass_properties}};
  ordered_json extension;
  if (!audio.material.is_null()) {
    extension["acousticMaterials"] = ordered_json::array({audio.material});
    model["material"] = 0;
  }
  extension["modalModels"] = ordered_json::array({model});
  file.document["extensionsUsed"].push_back(audio_extension);
  file.document["extensions"][audio_extension] = extension;
  file.document["nodes"][0]["extensions"][audio_extension] = {{"modalModel", 0}};
}

}  // namespace

std::string gltf_bytes(const GltfObject& object) {
  GlbFile file;
  ordered_json mesh = {{"name", object.name}, {"primitives", primitives(file, object)}};
  mesh["extras"] = object.facts;
  ordered_json names = ordered_json::array(), facts = ordered_json::array();
  for (const GltfMode& mode : object.modes) {
    names.push_back(mode.name);
    facts.push_back(mode.facts);
  }
  if (!object.modes.empty()) {
    mesh["weights"] = std::vector<double>(object.modes.size(), 0.0);
    mesh["extras"]["targetNames"] = names;
    mesh["extras"]["modes"] = facts;
  }
  file.document = {
      {"asset",
       {{"version", "2.0"},
        {"generator", fmt::format("Carillon {}", core::version())},
        {"copyright",
         "its maker's own: the licence of Carillon does not extend to it; the shape may have an "
         "author of its own"}}},
      {"scene", 0},
      {"scenes", {{{"nodes", {0}}}}},
      {"nodes", {{{"mesh", 0}, {"name", object.name}}}},
      {"meshes", ordered_json::array({mesh})},
      {"materials", ordered_json::array()}};
  add_materials(file, object.materials);
  if (!object.modes.empty()) file.document["animations"] = animations(file, object);
  if (object.audio) add_audio(file, *object.audio, object.name);
  return file.bytes();
}

}  // namespace carillon::dataset::exporters
