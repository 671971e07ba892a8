#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "cli/command_line.hpp"
#include "cli/object_options.hpp"
#include "cli/option_values.hpp"
#include "cli/pitch_report.hpp"
#include "core/audio.hpp"
#include "core/error.hpp"
#include "core/files.hpp"
#include "core/numbers.hpp"
#include "core/units.hpp"
#include "scene/chain.hpp"
#include "scene/single_strike.hpp"
#include "synth/contact/recorded_force.hpp"

namespace carillon::cli {

namespace {

struct StrikeOptions {
  ObjectOptions object;
  std::string scene;                   ///< configuration whose scene is taken; "": none
  std::vector<std::string> overrides;  ///< --set
  std::string at, direction;
  // Shorter to write than --set; "" leaves the scene's value.
  std::string listener, impulse, contact_time, seconds, sample_rate, gain;
  std::string force, force_peak;  ///< a file, and what its largest magnitude is scaled to; "": none
  std::uint64_t seed = 1;
  std::size_t repeat = 1;
  std::string interval = "0.2 s";
  std::string output;
};

/// The options that stand for keys of a scene, as overrides; --set comes last and wins.
std::vector<std::string> scene_overrides(const StrikeOptions& options) {
  std::vector<std::string> all;
  const auto put = [&](const char* key, const std::string& value) {
    if (!value.empty()) all.push_back(fmt::format("{}={}", key, value));
  };
  const bool bare = options.scene.empty();
  put("strikes.impulse",
      bare && options.impulse.empty() ? scene::default_impulse : options.impulse);
  const std::string contact =
      bare && options.contact_time.empty() ? scene::default_contact_time : options.contact_time;
  if (!contact.empty() && option_quantity(contact, core::Dimension::time, "--contact-time") == 0) {
    put("effects.contact", "off");  // an ideal impulse
  } else {
    put("strikes.contact_time", contact);
  }
  put("audio.seconds", options.seconds);
  put("audio.sample_rate", options.sample_rate);
  put("audio.gain", options.gain);
  if (!options.listener.empty()) {
    const Vec3 ear = parse_position(options.listener, "--listener");
    put("listeners", fmt::format("[{{position: [{}, {}, {}]}}]", ear.x(), ear.y(), ear.z()));
  }
  all.insert(all.end(), options.overrides.begin(), options.overrides.end());
  return all;
}

/// @param materials  of the object, which decide whether there is damping
scene::Scene scene_of(const StrikeOptions& options,
                      const std::vector<synth::material::Material>& materials) {
  const bool bare = options.scene.empty();
  scene::Scene scene = scene::read_strike_scene(bare ? "{}" : core::read_text_file(options.scene),
                                                bare ? "strike" : options.scene,
                                                scene_overrides(options), materials, "--material");
  if (scene.runs("striker") && !(options.impulse.empty() && options.contact_time.empty())) {
    throw core::InputError("--impulse and --contact-time have no effect: the striker gives them",
                           "leave them out, or set effects.striker=off");
  }
  return scene;
}

/// The band ends at half the sample rate unless another end is asked for: modes above it would not
/// sound.
ObjectOptions sounding_band(ObjectOptions object, const scene::Scene& scene) {
  if (!object.max_frequency) {
    object.max_frequency = fmt::format("{} Hz", std::min(20000.0, scene.audio.sample_rate / 2));
  }
  return object;
}

/// Everything that is wrong without knowing the object, before it is solved.
void check_options(const StrikeOptions& options) {
  if (!options.direction.empty() &&
      !(parse_position(options.direction, "--direction").norm() > 0)) {
    throw core::InputError("--direction has no length");
  }
  if (!(option_quantity(options.interval, core::Dimension::time, "--interval") >= 0)) {
    throw core::InputError("--interval must not be negative");
  }
}

/// The force of a file, in place of a hammer.
std::optional<synth::modal::ContactForce> known_force(const StrikeOptions& options) {
  if (options.force.empty()) {
    if (options.force_peak.empty()) return std::nullopt;
    throw core::InputError("--force-peak scales the file of --force, and there is none",
                           "--impulse is the strength of the usual pulse");
  }
  for (const auto& [name, value] : {std::pair{"--impulse", &options.impulse},
                                    std::pair{"--contact-time", &options.contact_time}}) {
    if (value->empty()) continue;
    throw core::InputError(fmt::format("--force and {} both say how hard is struck", name),
                           "keep one of them; --force-peak scales the file");
  }
  std::optional<double> peak;
  if (!options.force_peak.empty()) {
    peak = core::parse_quantity(options.force_peak, core::Dimension::force);
  }
  return synth::contact::read_force(options.force, peak);
}

scene::KnownStrike known_strike(const StrikeOptions& options) {
  scene::KnownStrike known;
  if (!options.at.empty()) known.position = parse_position(options.at, "--at");
  if (!options.direction.empty()) {
    known.direction = parse_position(options.direction, "--direction").normalized();
  }
  known.force = known_force(options);
  return known;
}

void run_strike(StrikeOptions options, Context& context) {
  check_options(options);
  name_material(options.object, context);
  const scene::Scene scene = scene_of(options, scene::listed(region_materials(options.object)));
  const scene::KnownStrike known = known_strike(options);
  require_output_file(context, options.output);
  const scene::SolvedObject object =
      solve_object(sounding_band(options.object, scene), context, known.position);
  settle(options.object, object.pitch_target, context);
  if (!context.speaks()) return;

  const scene::StruckSound struck = scene::strike_once(
      scene, options.object.mesh, object,
      {.known = known,
       .seed = options.seed,
       .repeat = options.repeat,
       .interval = core::parse_quantity(options.interval, core::Dimension::time)},
      context.cache);
  const scene::Sound& sound = struck.sound;
  core::write_durably(options.output, [&](const std::filesystem::path& path) {
    core::write_wav(path, scene::clip_of(sound), scene.audio.dtype);
  });
  if (context.json) {
    nlohmann::json json = to_json(struck, scene);
    json["file"] = options.output;
    for (const synth::material::Material& material : object.materials)
      json["materials"].push_back(material.name);
    if (object.size != 1) json["size"] = object.size;
    if (object.pitch_target)
      json["pitch_target"] = solvers::pitch::to_json(*object.pitch_target, true);
    fmt::print("{}\n", json.dump(2));
    return;
  }
  const Vec3& position = struck.struck.position;
  fmt::print("{}: {} modes, struck at ({:.4f}, {:.4f}, {:.4f}) m, peak {:.3g} {}\n", options.output,
             sound.modes, position.x(), position.y(), position.z(), core::peak(sound.audio),
             struck.unit);
  if (sound.modes_above_nyquist > 0) {
    fmt::print("{} modes above half the sample rate left out\n", sound.modes_above_nyquist);
  }
  std::vector<std::string> effects;
  for (const auto& [name, entry] : struck.trace.effects) effects.push_back(name);
  fmt::print("{:.4g} N s over {:.4g} ms; effects: {}\n", struck.impulse,
             1000 * sound.strike.force.duration, fmt::join(effects, ", "));
  // What was asked for and cannot be: a room without a listener.
  for (const scene::EffectDecision& effect : scene.effects) {
    if (!effect.enabled && !effect.in_scene.asked_by.empty()) {
      fmt::print("  {:<24} off: {}\n", effect.effect->name, effect.reason);
    }
  }
  for (const auto& [name, value] : struck.drawn.items()) {
    fmt::print("  {:<24} {}\n", name, value.dump());
  }
  if (object.pitch_target) print_report(*object.pitch_target);
}

}  // namespace

void add_strike(Program& program, Context& context) {
  Command& command = program.add("strike", "one sound of one shape", Needs::solver);
  auto options = std::make_shared<StrikeOptions>();
  add_object_options(command, options->object);
  add_tuning_options(command, options->object);
  command.option_named("--max-frequency").show_default("20 kHz or half the sample rate");
  command.option("-o,--output", options->output, "WAV file, one channel per listener").required();
  command.option("--at", options->at, "point struck, x,y,z [m] (default: drawn by --seed)");
  command.option("--direction", options->direction,
                 "way the force points, x,y,z (default: inward along the normal)");
  command.option("--scene", options->scene,
                 "YAML file with the keys of a scene (strikes, listeners, supports, room, "
                 "noise, ...); a build's configuration will do");
  command.option("--set", options->overrides, "key=value instead of the scene's").one_value_each();
  command.option("--impulse", options->impulse, "integral of the force")
      .show_default(scene::default_impulse);
  command
      .option("--contact-time", options->contact_time,
              "duration of the contact; 0: an ideal impulse")
      .show_default(scene::default_contact_time);
  command.option("--force", options->force,
                 "sound file of one channel: the force over time, 1 N at full scale, in place of "
                 "impulse and contact time");
  command.option("--force-peak", options->force_peak,
                 "largest magnitude that the file is scaled to, e.g. 20 N");
  command.option("--listener", options->listener,
                 "x,y,z [m] from the centre of the object's box: pressure there instead of the "
                 "velocity at the point");
  command.option("--seconds", options->seconds, "length of the clip").show_default("1 s");
  command.option("--sample-rate", options->sample_rate, "[Hz]").show_default("44100");
  command.option("--gain", options->gain, "full scale per m/s or Pa").show_default("1");
  command.option("--seed", options->seed, "of everything that is drawn").show_default();
  command.option("--repeat", options->repeat, "strikes one after the other on the same point")
      .range(1, 10000)
      .show_default();
  command.option("--interval", options->interval, "from one strike to the next").show_default();
  command.footer(
      "Examples:\n  carillon strike bell -o bell.wav\n"
      "  carillon strike bowl -m ceramic --listener 0,0,1 --set 'room.dimensions=[5, 4, 3]' "
      "--set room.rt60=0.6 -o room.wav\n"
      "  carillon strike bell -m iron --force hammer.wav --force-peak '80 N' -o bell.wav");
  command.does([&context, options] { run_strike(*options, context); });
}

}  // namespace carillon::cli
