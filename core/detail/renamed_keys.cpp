#include "core/detail/renamed_keys.hpp"

#include <algorithm>
#include <string_view>

namespace carillon::core {

namespace {

struct RenamedKey {
  std::string_view before;  ///< the end of its path, without numbers of elements; * is any name
  std::string_view now;     ///< from the same mapping on
};

constexpr RenamedKey renamed_keys[] = {
    // Studies of accuracy.
    {"orders", "levels.orders"},
    {"sizes", "levels.element_size_factors"},
    {"tolerances", "levels.tolerances"},
    {"pitch_cents", "pitch_targets"},
    {"min_frequency", "modes.min_frequency"},
    {"max_frequency", "modes.max_frequency"},
    {"max_elements", "modes.max_elements"},
    {"material", "materials"},
    {"ranks", "all_ranks"},
    {"repeats.most", "max_runs"},
    {"reference.solver", "kind"},
    {"reference.size", "element_size_factor"},
    {"objects.reference_size", "reference.element_size_factor"},
    {"objects.stand_in.noise", "deviation"},
    {"sound.body", "object"},
    {"sound.material", "object.materials"},
    {"sound.strikes", "strike_count"},
    {"sound.modes", "mode_counts"},
    {"features.methods", "extractors"},
    {"features.modes", "mode_counts"},
    {"features.snr", "snr_levels"},
    // Objects.
    {"objects.height", "svg_height"},
    {"variants.materials", "material_choice"},
    {"variants.sizes", "size_choice"},
    {"*.source", "citation"},
    // Scenes.
    {"damping", "negative_damping"},
    {"radiation.damping", "damps_modes"},
    {"room.size", "dimensions"},
    {"room.order", "image_order"},
    {"striker.size", "burst_size"},
    {"contacts.points", "count"},
    {"contacts.height", "contact_height"},
    {"voxels.pitch", "cell_size"},
    {"radiation.least_sources", "min_sources"},
    {"radiation.most_sources", "max_sources"},
    {"motion.takes", "simulations"},
    {"motion.least_speed", "min_speed"},
    {"motion.step", "time_step"},
    {"motion.contacts", "lasting_contacts"},
    {"bodies.material", "materials"},
    {"repeat.step", "offset"},
    {"ground.size", "side"},
    {"texture.width", "image_width"},
    {"texture.repeats", "periodic"},
    {"camera.depth", "depth_maps"},
    {"stylus.hold", "hold_stiffness"},
    {"stylus.stiffness", "face_stiffness"},
    {"stylus.damping", "face_damping"},
    {"stylus.largest_force", "max_force"},
    {"lasting_contacts.map", "use_textures"},
    {"lasting_contacts.longest", "max_wavelength"},
    // Learning and evaluation.
    {"tasks.*.split", "split_column"},
    {"tasks.*.classes", "label_groups"},
    {"methods.*.width", "units"},
    {"methods.*.pool", "pooling"},
    {"methods.*.senses", "modalities"},
    {"recordings.body", "object_column"},
    {"recordings.strike", "strike_column"},
    {"transfer.target", "target_dataset"},
    {"mixes.with", "mixed_with"},
    {"mixes.shares", "fractions"},
    {"spectrograms.sounds", "max_sounds"},
    {"damping.sounds", "sound_counts"},
    {"damping.from", "draws_from"},
    {"features.method", "extractors"},
};

/// `objects[0].sizes` without its numbers: `objects.sizes`.
std::vector<std::string> names_of(std::string_view path) {
  std::vector<std::string> names(1);
  bool in_number = false;
  for (const char c : path) {
    if (c == '[' || c == ']') {
      in_number = c == '[';
    } else if (c == '.') {
      names.emplace_back();
    } else if (!in_number) {
      names.back() += c;
    }
  }
  return names;
}

bool ends_with(const std::vector<std::string>& path, const std::vector<std::string>& end) {
  return path.size() >= end.size() && std::equal(end.rbegin(), end.rend(), path.rbegin(),
                                                 [](const auto& wanted, const auto& name) {
                                                   return wanted == "*" || wanted == name;
                                                 });
}

}  // namespace

std::string renamed_key(const std::string& path, const std::vector<std::string>& known) {
  const std::vector<std::string> names = names_of(path);
  for (const RenamedKey& key : renamed_keys) {
    const std::string first(key.now.substr(0, key.now.find('.')));
    if (ends_with(names, names_of(key.before)) &&
        std::find(known.begin(), known.end(), first) != known.end()) {
      return std::string(key.now);
    }
  }
  return "";
}

}  // namespace carillon::core
