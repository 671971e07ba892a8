#include "synth/thrift.hpp"

#include <fmt/format.h>

#include <cmath>

#include "cli/sound/effect.hpp"
#include "cli/sound/scene.hpp"

namespace carillon::cli {

extern const Effect thrift_effect;

namespace {

SceneEffect read(core::ConfigNode& root, const Scene& scene) {
  core::ConfigNode node = root.child("thrift");
  synth::ThriftOptions options;
  options.margin = node.quantity("margin", core::Dimension::none, options.margin);
  options.range = node.quantity("range", core::Dimension::none, options.range);
  for (const char* key : {"margin", "range"}) {
    const double value = key[0] == 'm' ? options.margin : options.range;
    if (!(value >= 0) || !std::isfinite(value)) {
      node.fail(key, fmt::format("must be a number of decibels from 0 on, not {}", value));
    }
  }
  SceneEffect effect;
  if (root.has("thrift")) {
    effect.asked_by = fmt::format("thrift ({})", root.where("thrift"));
  } else {
    effect.reason_off = "runs on demand only (effects.thrift: on)";
  }
  effect.seconds_per_sound = 2e-4;
  effect.start = [options, count = scene.audio.samples()] {
    EffectParts parts;
    parts.rings = [options, count](Sound& sound) {
      const synth::ThriftReport report = synth::leave_out_inaudible(
          sound.rings, sound.strike.force, sound.sample_rate, count, options);
      if (sound.record == nullptr) return;
      sound.record->add("thrift_modes_left_out", static_cast<std::int64_t>(report.left_out));
      sound.record->add("thrift_error_bound", synth::decibels(report.error_bound), "dB");
    };
    return parts;
  };
  return effect;
}

}  // namespace

const Effect thrift_effect = {"thrift", "leaves out modes that cannot be heard", true, read};

}  // namespace carillon::cli
