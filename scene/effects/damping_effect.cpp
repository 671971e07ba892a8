#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <memory>

#include "core/error.hpp"
#include "scene/effects/detail/list.hpp"
#include "scene/scene.hpp"
#include "scene/solved_object.hpp"
#include "synth/damping/damping.hpp"

namespace carillon::scene {

namespace {

/// What becomes of modes that a model would let grow.
enum class Negative { error, clamp, drop };

/// Modes with negative damping of the objects that have some, by the object's id.
struct Negatives {
  struct Object {
    std::vector<std::size_t> modes;
    double low, high;  ///< [Hz] of those modes
  };
  std::map<std::string, Object> objects;
};

void set_decay_rates(RingingObject& object, Negative choice, Negatives& negatives) {
  const std::vector<synth::damping::DampingModel> models = damping_of(*object.materials);
  const solvers::modes::Modes& modes = *object.modes;
  try {
    if (choice == Negative::error) {
      object.decay_rates = synth::damping::decay_rates(modes, models);
      return;
    }
    synth::damping::DecayRates rates = synth::damping::clamped_decay_rates(modes, models);
    object.decay_rates = std::move(rates.values);
    negatives.objects.erase(object.id);
    if (rates.negative.empty()) return;
    const double low = modes.frequency(rates.negative.front());
    const double high = modes.frequency(rates.negative.back());
    negatives.objects[object.id] = {std::move(rates.negative), low, high};
  } catch (const core::InputError& error) {
    throw core::InputError(fmt::format("{}: {}", object.id, error.message()), error.hint());
  }
}

/// Leaves modes out where that was chosen, and records how many there were and where.
void treat_negatives(Sound& sound, Negative choice, const Negatives& negatives) {
  const auto found = negatives.objects.find(sound.object->id);
  const bool any = found != negatives.objects.end();
  // On springs these are parts of other modes, which they leave undamped as clamping does.
  if (any && choice == Negative::drop && !sound.object->held) {
    synth::modal::leave_out(sound.rings, found->second.modes);
  }
  if (sound.record == nullptr) return;
  constexpr double none = std::numeric_limits<double>::quiet_NaN();
  sound.record->add("negative_damping_modes",
                    static_cast<std::int64_t>(any ? found->second.modes.size() : 0));
  sound.record->add("negative_damping_low", any ? found->second.low : none);
  sound.record->add("negative_damping_high", any ? found->second.high : none);
}

EffectParts start_damping(Negative choice) {
  auto negatives = std::make_shared<Negatives>();
  EffectParts parts;
  parts.object = [choice, negatives](RingingObject& object) {
    set_decay_rates(object, choice, *negatives);
  };
  // As an error there is nothing left to treat.
  if (choice != Negative::error) {
    parts.rings = [choice, negatives](Sound& sound) { treat_negatives(sound, choice, *negatives); };
  }
  return parts;
}

SceneEffect read_damping(core::ConfigNode& root, const Scene& scene) {
  const std::string word = root.choice("negative_damping", {"error", "clamp", "drop"}, "error");
  const Negative choice = word == "clamp"  ? Negative::clamp
                          : word == "drop" ? Negative::drop
                                           : Negative::error;
  SceneEffect effect;
  const auto undamped = [](const synth::material::Material& m) {
    return synth::damping::is_undamped(m.damping);
  };
  const auto& materials = scene.materials;
  if (!materials.empty() && std::all_of(materials.begin(), materials.end(), undamped)) {
    effect.reason_off = "no material has damping";
  } else {
    const auto without = std::count_if(materials.begin(), materials.end(), undamped);
    effect.asked_by = without == 0
                          ? "every material has damping"
                          : fmt::format("{} of {} materials have damping",
                                        materials.size() - std::size_t(without), materials.size());
    if (!scene.materials_place.empty()) {
      effect.asked_by = fmt::format("{}, {}", scene.materials_place, effect.asked_by);
    }
  }
  // Found once for an object: nothing that counts is left to a sound.
  effect.seconds_per_sound = 0;
  effect.start = [choice](const std::filesystem::path&) { return start_damping(choice); };
  return effect;
}

}  // namespace

const Effect damping_effect = {.name = "damping",
                               .description = "decay rate of every mode from its materials' models",
                               .key = "damping",
                               .stage = "object",
                               .read = read_damping};

}  // namespace carillon::scene
