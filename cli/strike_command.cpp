#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "cli/body.hpp"
#include "cli/pitch.hpp"
#include "cli/text.hpp"
#include "core/audio.hpp"
#include "core/error.hpp"
#include "core/units.hpp"
#include "synth/ring_down.hpp"

namespace carillon::cli {

namespace {

struct StrikeOptions {
  BodyOptions body;
  std::string at, direction, listener;
  std::string impulse = "0.02 N s", contact_time = "0.2 ms", seconds = "1 s";
  double sample_rate = 44100;
  double gain = 1;
  std::uint64_t seed = 1;
  std::string output;
};

synth::Strike make_strike(const StrikeOptions& options, const solvers::Modes& modes) {
  const synth::SurfaceSampler sampler(modes.surface);
  core::RandomStream random(options.seed, 0, "strike.position");
  synth::Strike strike;
  strike.point =
      options.at.empty() ? sampler.sample(random) : sampler.nearest(parse_position(options.at));
  const synth::PointFrame frame = synth::frame_at(modes.surface, strike.point);
  strike.direction = options.direction.empty() ? solvers::Vec3(-frame.normal)
                                               : parse_position(options.direction).normalized();
  strike.impulse = core::parse_quantity(options.impulse, core::Dimension::impulse);
  strike.force.duration = core::parse_quantity(options.contact_time, core::Dimension::time);
  return strike;
}

/// Everything that is wrong without knowing the body, before it is solved.
void check_options(const StrikeOptions& options) {
  const double seconds = core::parse_quantity(options.seconds, core::Dimension::time);
  if (!(seconds > 0 && seconds <= 600)) {
    throw core::InputError("--seconds must be above 0 and at most 600 s");
  }
  if (!(core::parse_quantity(options.impulse, core::Dimension::impulse) > 0)) {
    throw core::InputError("--impulse must be positive");
  }
  if (!(core::parse_quantity(options.contact_time, core::Dimension::time) >= 0)) {
    throw core::InputError("--contact-time must not be negative");
  }
  if (options.sample_rate != std::floor(options.sample_rate)) {
    throw core::InputError("--sample-rate must be whole, as WAV files store it");
  }
  for (const std::string& position : {options.at, options.listener}) {
    if (!position.empty()) parse_position(position);
  }
  if (!options.direction.empty() && !(parse_position(options.direction).norm() > 0)) {
    throw core::InputError("--direction has no length");
  }
}

void run_strike(const StrikeOptions& options, Context& context) {
  check_options(options);
  const Body body = solve_body(options.body, context);
  settle(body.pitch_target, context);
  if (!context.speaks()) return;
  const synth::Strike strike = make_strike(options, body.modes);
  std::vector<synth::Listener> listeners;
  if (!options.listener.empty()) listeners.push_back({parse_position(options.listener)});
  const synth::RingDown rings =
      synth::ring_down(body.modes, body.decay_rates, strike,
                       listeners.empty() ? synth::point_velocity(body.modes, strike.point)
                                         : synth::monopole(body.modes, listeners));
  const double seconds = core::parse_quantity(options.seconds, core::Dimension::time);
  core::AudioClip clip;
  clip.sample_rate = static_cast<int>(options.sample_rate);
  clip.samples =
      synth::synthesize(rings, strike.force, options.sample_rate,
                        static_cast<std::size_t>(std::lround(seconds * options.sample_rate)));
  double peak = 0;
  for (float& sample : clip.samples) {
    sample = static_cast<float>(sample * options.gain);
    peak = std::max(peak, std::abs(static_cast<double>(sample)));
  }
  core::write_wav(options.output, clip, core::SampleFormat::float32);

  const solvers::Vec3 position = synth::frame_at(body.modes.surface, strike.point).position;
  const std::string& unit = rings.readout.unit;
  if (context.json) {
    nlohmann::json json = {{"file", options.output},
                           {"modes", body.modes.size()},
                           {"unit", unit},
                           {"peak", peak},
                           {"position_m", {position.x(), position.y(), position.z()}}};
    if (body.pitch_target) json["pitch_target"] = solvers::to_json(*body.pitch_target, true);
    fmt::print("{}\n", json.dump(2));
  } else {
    fmt::print("{}: {} modes, struck at ({:.4f}, {:.4f}, {:.4f}) m, peak {:.3g} {}\n",
               options.output, body.modes.size(), position.x(), position.y(), position.z(), peak,
               unit);
    if (body.pitch_target) print_report(*body.pitch_target);
  }
}

}  // namespace

void add_strike(CLI::App& program, Context& context) {
  CLI::App* command = program.add_subcommand("strike", "one sound of one shape");
  auto options = std::make_shared<StrikeOptions>();
  add_body_options(*command, options->body);
  command->add_option("-o,--output", options->output, "WAV file (32-bit float)")->required();
  command->add_option("--at", options->at, "point struck, x,y,z [m] (default: drawn by --seed)");
  command->add_option("--direction", options->direction,
                      "way the force points, x,y,z (default: inward along the normal)");
  command->add_option("--impulse", options->impulse, "integral of the force")
      ->capture_default_str();
  command->add_option("--contact-time", options->contact_time, "duration of the contact")
      ->capture_default_str();
  command->add_option("--listener", options->listener,
                      "x,y,z [m]: pressure there (monopole) instead of the velocity at the point");
  command->add_option("--seconds", options->seconds, "length of the clip")->capture_default_str();
  command->add_option("--sample-rate", options->sample_rate, "[Hz]")
      ->check(CLI::Range(1000.0, 384000.0))
      ->capture_default_str();
  command->add_option("--gain", options->gain, "full scale per m/s or Pa")->capture_default_str();
  command->add_option("--seed", options->seed, "of the random point")->capture_default_str();
  command->footer("Example:\n  carillon strike bell --material iron -o bell.wav");
  command->callback([&context, options] { run_strike(*options, context); });
}

}  // namespace carillon::cli
