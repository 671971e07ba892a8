#include <fcntl.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "cli/command_line.hpp"
#include "cli/option_values.hpp"
#include "cli/play/devices.hpp"
#include "cli/play/interrupt.hpp"
#include "cli/play/keyboard.hpp"
#include "cli/play/output.hpp"
#include "cli/play_objects.hpp"
#include "core/error.hpp"
#include "mpi/comm.hpp"
#include "mpi/exit_code.hpp"
#include "scene/live/midi.hpp"
#include "scene/strikes.hpp"

namespace carillon::cli {

namespace {

struct PlayOptions {
  PlayedWhat what;
  std::string listener, impulse, contact_time, sample_rate, gain;
  std::string output, device, format = "float32", pace;
  std::size_t block = 256;
  std::string latency = "50 ms";
  std::string seconds;
  std::string events, midi, osc;
  double hand = 50;
};

/// Options that stand for keys of a scene.
std::vector<std::string> scene_keys(const PlayOptions& options, bool bare) {
  std::vector<std::string> keys;
  const auto put = [&](const char* key, const std::string& value) {
    if (!value.empty()) keys.push_back(fmt::format("{}={}", key, value));
  };
  const auto usual = [&](const std::string& given, const char* otherwise) {
    return given.empty() && bare ? std::string(otherwise) : given;
  };
  put("strikes.impulse", usual(options.impulse, scene::default_impulse));
  const std::string contact = usual(options.contact_time, scene::default_contact_time);
  if (!contact.empty() && option_quantity(contact, core::Dimension::time, "--contact-time") == 0) {
    put("effects.contact", "off");
  } else {
    put("strikes.contact_time", contact);
  }
  put("audio.sample_rate", options.sample_rate);
  put("audio.gain", options.gain);
  if (!options.listener.empty()) {
    const Vec3 ear = parse_position(options.listener, "--listener");
    keys.push_back(
        fmt::format("listeners=[{{position: [{}, {}, {}]}}]", ear.x(), ear.y(), ear.z()));
  }
  return keys;
}

/// The middle of a range that is drawn from uniformly in the logarithm.
double middle(const core::Range& range) {
  return std::sqrt(range.low * range.high);
}

play::Pace pace_of(const PlayOptions& options, bool to_device) {
  play::Pace pace;
  pace.block = options.block;
  pace.latency = option_quantity(options.latency, core::Dimension::time, "--latency");
  if (!(pace.latency >= 0 && pace.latency <= 10)) {
    throw core::InputError(fmt::format("--latency {}: it is from 0 to 10 s", options.latency));
  }
  if (!options.seconds.empty()) {
    pace.seconds = option_quantity(options.seconds, core::Dimension::time, "--seconds");
    if (!(pace.seconds > 0 && pace.seconds <= 1e6)) {
      throw core::InputError(
          fmt::format("--seconds {}: it is positive, at most 1e6", options.seconds));
    }
  }
  if (to_device && options.pace == "none") {
    throw core::InputError("--pace none does not apply: a sound device has its own pace",
                           "leave it out, or play to a pipe or a file with -o");
  }
  pace.clock = options.pace.empty() ? options.output == "-" : options.pace == "clock";
  pace.format = options.format == "s16" ? core::SampleFormat::int16 : core::SampleFormat::float32;
  return pace;
}

/// The inputs that are open while it plays.
struct Inputs {
  std::unique_ptr<play::EventReader> events;
  std::unique_ptr<play::Keyboard> keyboard;
  std::unique_ptr<play::Opened> midi, osc;
  int file = -1;
  Inputs() = default;
  Inputs(const Inputs&) = delete;
  Inputs& operator=(const Inputs&) = delete;
  ~Inputs() {
    events.reset();
    if (file >= 0) ::close(file);
  }
};

void open_inputs(const PlayOptions& options, scene::live::Instrument& instrument, Inputs& inputs) {
  const play::Apply apply = [&instrument](const scene::live::Request& request) {
    instrument.apply(request);
  };
  const std::size_t objects = instrument.objects().size();
  const bool terminal = ::isatty(STDIN_FILENO) != 0;
  if (!options.events.empty() && options.events != "-") {
    inputs.file = ::open(options.events.c_str(), O_RDONLY | O_CLOEXEC);
    if (inputs.file < 0) {
      throw core::FileError(fmt::format("--events {}: cannot be read", options.events));
    }
    inputs.events = std::make_unique<play::EventReader>(inputs.file, options.events, apply);
  } else if (options.events == "-" || !terminal) {
    inputs.events = std::make_unique<play::EventReader>(STDIN_FILENO, "events", apply);
  }
  if (!options.midi.empty()) {
    inputs.midi = play::open_midi_port(
        options.midi, [apply, objects, hand = options.hand](const auto& message) {
          try {
            if (const auto request = scene::live::midi_request(message, objects, hand))
              apply(*request);
          } catch (const core::Error& error) {
            spdlog::warn("MIDI: {}", error.message());
          }
        });
  }
  if (!options.osc.empty()) inputs.osc = play::open_osc(options.osc, apply);
  if (terminal && options.events != "-") {
    inputs.keyboard = std::make_unique<play::Keyboard>(objects, options.hand, apply);
  }
}

void tell_start(const PlayOptions& options, const scene::Scene& scene,
                const scene::live::Instrument& instrument, const play::Pace& pace,
                double device_latency) {
  const double block = static_cast<double>(pace.block) / scene.audio.sample_rate;
  const std::string place = options.output == "-"    ? "standard output"
                            : options.output.empty() ? "the device"
                                                     : options.output;
  fmt::print(stderr, "playing {} objects of {} modes to {}: {} channels, {} Hz, {}\n",
             instrument.objects().size(), instrument.modes(), place,
             instrument.objects().front().readout.delays.size(), scene.audio.sample_rate,
             options.format);
  if (pace.clock || options.output.empty()) {
    const double rest = options.output.empty() ? device_latency : pace.latency;
    fmt::print(stderr,
               "latency: {:.2f} ms, of them {:.2f} ms the block of {} samples and {:.2f} ms "
               "the {}\n",
               1000 * (block + rest), 1000 * block, pace.block, 1000 * rest,
               options.output.empty() ? "device" : "buffer of the output");
  }
  std::vector<std::string> heard, others;
  for (const scene::live::LiveEffect& effect : scene::live::live_effects(scene)) {
    if (effect.heard) heard.push_back(effect.name);
    if (!effect.heard) others.push_back(fmt::format("{} ({})", effect.name, effect.why));
  }
  fmt::print(stderr, "heard live: {}\n",
             heard.empty() ? "modes alone" : fmt::to_string(fmt::join(heard, ", ")));
  if (!others.empty()) fmt::print(stderr, "not heard live: {}\n", fmt::join(others, ", "));
}

void tell_end(const Context& context, const scene::live::Instrument& instrument,
              const play::Heard& heard, const synth::live::Played& played, const Inputs& inputs,
              double sample_rate) {
  const double seconds = static_cast<double>(played.samples) / sample_rate;
  const std::uint64_t refused = (inputs.events ? inputs.events->refused() : 0) +
                                (inputs.osc ? inputs.osc->refused.load() : 0);
  const double each =
      heard.voice_samples > 0 ? 1e9 * heard.processor_seconds / heard.voice_samples : 0;
  if (context.json) {
    const nlohmann::ordered_json json = {{"objects", instrument.objects().size()},
                                         {"samples", played.samples},
                                         {"seconds", seconds},
                                         {"events", played.events},
                                         {"refused", refused},
                                         {"late_events", played.late},
                                         {"latest_event_s", played.latest},
                                         {"dropouts", heard.dropouts},
                                         {"latest_block_s", heard.latest},
                                         {"behind_s", heard.behind},
                                         {"reader_closed", heard.reader_closed},
                                         {"processor_s", heard.processor_seconds},
                                         {"ns_per_voice_sample", each}};
    fmt::print("{}\n", json.dump());
    return;
  }
  fmt::print(stderr, "{:.3f} s played: {} events, {} refused, {} late{}; {} dropouts{}\n", seconds,
             played.events, refused, played.late,
             played.late > 0 ? fmt::format(" by up to {:.1f} ms", 1000 * played.latest) : "",
             heard.dropouts,
             heard.dropouts > 0
                 ? fmt::format(", by up to {:.1f} ms, {:.3f} s behind the clock in all",
                               1000 * heard.latest, heard.behind)
                 : "");
  if (heard.processor_seconds > 0) {
    fmt::print(stderr, "{:.3f} s of processor time, {:.1f} % of the sound's{}\n",
               heard.processor_seconds, 100 * heard.processor_seconds / std::max(seconds, 1e-9),
               each > 0 ? fmt::format(", {:.2f} ns for each sample of a partial", each) : "");
  }
}

void list_lines(const std::vector<std::string>& lines) {
  for (const std::string& line : lines) fmt::print("{}\n", line);
}

void run_play(PlayOptions options, Context& context) {
  if (options.device == "list") return list_lines(play::sound_devices());
  if (options.midi == "list") return list_lines(play::midi_ports());
  if (mpi::size(context.world) > 1) {
    throw core::InputError("play is one process, and mpirun started several",
                           "start it without mpirun");
  }
  if (options.what.what.empty()) {
    throw core::InputError("there is nothing to play", "name objects, or a configuration");
  }
  if (!options.output.empty() && !options.device.empty()) {
    throw core::InputError("-o and --device both say where the sound goes", "keep one of them");
  }
  const bool to_device = options.output.empty();
  const bool to_pipe = options.output == "-";
  if (to_device) options.device = options.device.empty() ? "default" : options.device;
  play::Pace pace = pace_of(options, to_device);
  int stream = -1;
  if (to_pipe) {
    // Samples have the stream to themselves: all that is printed goes where errors go.
    stream = ::dup(STDOUT_FILENO);
    if (stream < 0 || ::dup2(STDERR_FILENO, STDOUT_FILENO) < 0) {
      throw core::FileError("standard output cannot be written to");
    }
  } else if (!to_device) {
    require_output_file(context, options.output);
  }
  const bool bare = options.what.scene.empty() && !options.what.what.front().ends_with(".yaml") &&
                    !options.what.what.front().ends_with(".yml");
  PlayedObjects played = played_objects(options.what, scene_keys(options, bare), context);
  const scene::Scene& scene = played.scene;
  scene::live::UsualStrike usual;
  usual.impulse = middle(scene.strikes.impulse);
  usual.contact = scene.runs("contact") ? middle(scene.strikes.contact_time) : 0;
  scene::live::Instrument instrument(std::move(played.objects), usual, scene.audio.sample_rate,
                                     scene.audio.gain);
  play::Heard heard;
  {
    const play::Interrupts interrupts;
    Inputs inputs;
    open_inputs(options, instrument, inputs);
    pace.ends_silent =
        pace.seconds == 0 && inputs.events && !inputs.keyboard && !inputs.midi && !inputs.osc;
    if (!to_device && !to_pipe && pace.seconds == 0 && !pace.ends_silent) {
      throw core::InputError("a file has a length", "give --seconds, or events that end");
    }
    std::unique_ptr<play::Opened> device;
    if (to_device) device = play::open_sound_device(instrument.player(), options.device, pace);
    if (!context.quiet) {
      tell_start(options, scene, instrument, pace, device ? device->latency : 0);
      if (inputs.keyboard) {
        fmt::print(stderr, "{}\n", play::Keyboard::help(instrument.objects().size()));
      }
    }
    if (to_device) {
      play::follow(instrument.player(), pace, inputs.events.get());
      heard.dropouts = device->refused;
      device.reset();
    } else if (to_pipe) {
      heard = play::play_to_stream(instrument.player(), stream, pace, inputs.events.get());
      ::close(stream);
    } else {
      heard = play::play_to_file(instrument.player(), options.output, pace, inputs.events.get());
    }
    if (!context.quiet || context.json) {
      tell_end(context, instrument, heard, instrument.player().played(), inputs,
               scene.audio.sample_rate);
    }
    if (inputs.events && inputs.events->refused() > 0) context.exit_code = mpi::exit_failures;
    if (const int signal = play::Interrupts::signal(); signal != 0) {
      context.exit_code = 128 + signal;
    }
  }
}

}  // namespace

void add_play(Program& program, Context& context) {
  Command& command = program.add(
      "play",
      "objects that are struck while they sound: in real time, to a device, a pipe or a file",
      Needs::solver);
  auto options = std::make_shared<PlayOptions>();
  add_object_options(command, options->what.object);
  command.remove("mesh");
  command.option_named("--max-frequency").show_default("20 kHz or half the sample rate");
  command.option("what", options->what.what,
                 "objects, as carillon strike takes them, or a configuration, whose objects are "
                 "played in all of their materials and sizes");
  command.option("--scene", options->what.scene, "YAML file with the keys of a scene, for objects");
  command.option("--set", options->what.overrides, "key=value instead of the configuration's")
      .one_value_each();
  command.option("--max-objects", options->what.max_objects, "more is an error")
      .range(std::size_t{1}, std::size_t{100000})
      .show_default();
  command.option("--seed", options->what.seed, "of each object's own place, and of its supports")
      .show_default();
  command.option("-o,--output", options->output,
                 "- for raw samples on standard output, or a WAV file");
  command
      .option("--device", options->device,
              "sound device: its number or part of its name; list names them")
      .show_default("the system's own, where there is no -o");
  command.option("--format", options->format, "of samples, little endian")
      .one_of({"float32", "s16"})
      .show_default();
  command
      .option("--pace", options->pace,
              "clock: real time; none: as quickly as the samples are taken")
      .one_of({"clock", "none"})
      .show_default("clock for -o -, none for files");
  command.option("--block", options->block, "samples that are computed at a time")
      .range(std::size_t{16}, std::size_t{65536})
      .show_default();
  command
      .option("--latency", options->latency,
              "that the output holds back beside the block: what the device is asked for, or "
              "how late a block may be in the pipe")
      .show_default();
  command.option("--seconds", options->seconds,
                 "length (default: until it is stopped, or silent after the last event)");
  command.option("--events", options->events,
                 "file of events, or - for standard input (default: standard input where it is no "
                 "terminal)");
  command.option("--midi", options->midi,
                 "MIDI input: its number or part of its name; list names "
                 "them");
  command.option("--osc", options->osc,
                 "PORT (of this machine alone) or HOST:PORT for OSC messages by UDP");
  command
      .option("--hand", options->hand,
              "decay rate that the damping hand of keys and MIDI adds [1/s]")
      .range(0.0, 1e6)
      .show_default();
  command.option("--listener", options->listener,
                 "x,y,z [m] from the centre of each object's box: pressure there instead of the "
                 "velocity of its own place");
  command.option("--impulse", options->impulse, "of strikes that give none")
      .show_default(scene::default_impulse);
  command.option("--contact-time", options->contact_time, "of strikes that give none")
      .show_default(scene::default_contact_time);
  command.option("--sample-rate", options->sample_rate, "[Hz]").show_default("44100");
  command.option("--gain", options->gain, "full scale per m/s or Pa").show_default("1");
  command.footer(
      "Events are lines of text with their time in seconds, or - for at once (docs/play.md):\n"
      "  0.25 strike bell position 0 0 0.05 impulse 0.02 contact 1ms\n"
      "  1.5 support 0 0 off\n"
      "  2 damp * 30\n"
      "  4 stop\n"
      "\n"
      "Examples:\n"
      "  carillon play bell bowl bar -o - | aplay -f FLOAT_LE -r 44100\n"
      "  carillon play bell --device default\n"
      "  carillon play configs/smoke.yaml --events events.txt -o played.wav\n"
      "  carillon play cup -m ceramic --osc 9000 -o - | ffplay -f f32le -ar 44100 -nodisp -");
  command.does([&context, options] { run_play(*options, context); });
}

}  // namespace carillon::cli
