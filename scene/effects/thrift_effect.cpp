#include "synth/modal/thrift.hpp"

#include <fmt/format.h>

#include <cmath>
#include <vector>

#include "core/error.hpp"
#include "scene/effects/detail/list.hpp"
#include "scene/scene.hpp"

namespace carillon::scene {

namespace {

SceneEffect read(core::ConfigNode& root, const Scene& scene) {
  core::ConfigNode node = root.child("thrift");
  synth::modal::ThriftOptions options;
  options.margin = node.quantity("margin", core::Dimension::level, options.margin);
  options.range = node.quantity("range", core::Dimension::level, options.range);
  for (const char* key : {"margin", "range"}) {
    const double value = key[0] == 'm' ? options.margin : options.range;
    if (!(value >= 0) || !std::isfinite(value)) {
      node.fail(key, fmt::format("must be a number of decibels from 0 on, not {}", value));
    }
  }
  SceneEffect effect;
  effect.asked_by =
      root.has("thrift") ? fmt::format("thrift: ({})", root.where("thrift")) : "effects.thrift: on";
  effect.seconds_per_sound = 7e-5;
  effect.start = [options, count = scene.audio.samples()](const std::filesystem::path&) {
    EffectParts parts;
    parts.rings = [options, count](Sound& sound) {
      if (sound.blows != std::vector<double>{0}) {
        // Blows can cancel each other: the bound, relative to the sound of one, would not hold.
        throw core::InputError(
            fmt::format("thrift knows the sound of one blow at time 0, not of {} blows",
                        sound.blows.size()),
            "write effects: {thrift: off}, or strike once");
      }
      const synth::modal::ThriftReport report = synth::modal::leave_out_inaudible(
          sound.rings, sound.strike.force, sound.sample_rate, count, options);
      if (sound.record == nullptr) return;
      sound.record->add("thrift_modes_left_out", static_cast<std::int64_t>(report.left_out));
      sound.record->add("thrift_error_bound", synth::modal::decibels(report.error_bound), "dB");
    };
    return parts;
  };
  return effect;
}

}  // namespace

const Effect thrift_effect = {.name = "thrift",
                              .description = "leaves out modes that cannot be heard",
                              .key = "thrift",
                              .stage = "rings",
                              .only_on_demand = true,
                              .read = read};

}  // namespace carillon::scene
