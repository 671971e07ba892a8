#include "dataset/samples/simulation_maker.hpp"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <cmath>

#include "dataset/samples/detail/simulation_parts.hpp"
#include "synth/motion/motion_sound.hpp"
#include "synth/motion/simulate.hpp"

namespace carillon::dataset::samples {

SimulationMaker::SimulationMaker(const configuration::BuildConfig& config,
                                 const plan::BuildPlan& plan, const BuildFolders& folders,
                                 core::Trace& trace)
    : config_(config),
      plan_(plan),
      trace_(trace),
      chain_(config.scene, folders.cache, trace),
      actors_(config, plan, folders, chain_),
      textures_(config.seed) {
  scene_.id = scene_.shape = config.name;
  scene_.listeners = config.scene.listeners;
}

Simulation SimulationMaker::make(const plan::Sample& sample, core::Columns* record) {
  const core::TimeLimit clock = configuration::sample_clock(config_.limits);
  const std::string part = split_of_simulation(config_, sample);
  Simulation simulation;
  simulation.roles = draw_roles(config_, plan_, sample.id, part);
  simulation.stage = set_stage(config_, simulation.roles, actors_, textures_);
  {
    const core::ScopedTimer timer(trace_.effects["motion"]);
    synth::motion::MotionOptions options = config_.motion->options;
    options.seconds = config_.scene.audio.seconds;
    options.limit = clock;
    simulation.motion =
        synth::motion::simulate_motion(simulation.stage.moving, simulation.stage.strings, options);
  }
  if (simulation.motion.too_fast) {
    spdlog::warn(
        "{}: at {:.3f} s a body moves so fast for its thickness that {} parts of a step are too "
        "few: bodies may pass through one another; shorten motion.time_step",
        sample.key, *simulation.motion.too_fast, synth::motion::max_substep_count);
  }
  for (const synth::motion::Overlap& overlap : simulation.motion.overlaps) {
    spdlog::warn(
        "{}: at the start {} and {} are in one another by {:.2g} mm: they are pushed apart",
        sample.key, simulation.stage.names[overlap.bodies[0]],
        simulation.stage.names[overlap.bodies[1]], 1e3 * overlap.depth);
  }
  if (config_.scene.runs("touch")) {
    const core::ScopedTimer timer(trace_.effects["touch"]);
    simulation.touch =
        draw_stylus(config_, sample.id, simulation.stage, simulation.motion, traced_);
  }
  scene::Sound& sound = simulation.sound;
  sound.object = &scene_;
  sound.seed = config_.seed;
  sound.id = sample.id;
  sound.parts = config_.scene.parts;
  sound.part = part_index(config_, part) * config_.split.names().size() + part_index(config_, part);
  sound.record = record;
  hear(simulation, clock);
  if (clock.passed()) clock.refuse();
  draw(simulation);
  if (clock.passed()) clock.refuse();
  return simulation;
}

void SimulationMaker::hear(Simulation& simulation, const core::TimeLimit& clock) {
  const scene::Scene& scene = config_.scene;
  synth::motion::MotionSoundOptions options;
  options.sample_rate = scene.audio.sample_rate;
  options.seconds = scene.audio.seconds;
  options.lasting_contacts = scene.runs("lasting_contacts");
  options.contact_damping = scene.runs("contact_damping");
  options.clicks = scene.runs("click");
  options.limit = clock;
  options.hertz_pulses = config_.motion->hertz_pulses;
  options.contacts = config_.motion->contacts;
  options.contacts.seed = config_.seed;
  options.contacts.traced = traced_;
  const auto listeners = scene.runs("radiation") ? std::span(scene.listeners)
                                                 : std::span<const synth::modal::Listener>();
  synth::motion::MotionSound heard = synth::motion::motion_sound(
      simulation.motion, simulation.stage.moving, simulation.stage.sounding, listeners, options);
  const auto add = [](core::Trace::Entry& entry, const synth::motion::EffectUse& use) {
    entry.calls += static_cast<std::int64_t>(use.calls);
    entry.seconds += use.seconds;
  };
  add(trace_.stages["ring"], heard.ringing);
  add(trace_.stages["impacts"], heard.impacts);
  if (options.lasting_contacts) add(trace_.effects["lasting_contacts"], heard.lasting_contacts);
  if (options.contact_damping) add(trace_.effects["contact_damping"], heard.contact_damping);
  if (options.clicks) add(trace_.effects["click"], heard.clicks);
  if (!listeners.empty()) add(trace_.effects["radiation"], heard.moving_radiation);

  scene::Sound& sound = simulation.sound;
  sound.sample_rate = options.sample_rate;
  sound.rows = heard.rows;
  sound.audio = std::move(heard.samples);
  sound.rings.readout.unit = heard.unit;
  sound.rings.readout.delays.assign(heard.rows, 0.0);
  chain_.finish(sound);
}

void SimulationMaker::draw(Simulation& simulation) {
  if (!config_.scene.runs("movie")) return;
  const core::ScopedTimer timer(trace_.effects["movie"]);
  const scene::motion::MotionCamera& camera = *config_.motion->camera;
  render::SceneRenderer renderer(picture_of(simulation.stage, config_));
  const double step = simulation.motion.step;
  const std::size_t first = config_.motion->ground ? 1 : 0;
  for (std::size_t f = 0; f < camera.frames(config_.scene.audio.seconds); ++f) {
    const double time = static_cast<double>(f) / camera.rate;
    const auto k = std::min(static_cast<std::size_t>(std::lround(time / step)),
                            simulation.motion.states.size() - 1);
    std::vector<render::ScenePose> poses;
    for (std::size_t b = first; b < simulation.stage.actors.size(); ++b) {
      const synth::motion::Pose& pose = simulation.motion.states[k][b].pose;
      poses.push_back({pose.turn, pose.origin});
    }
    simulation.frames.push_back(renderer.draw(poses));
  }
}

}  // namespace carillon::dataset::samples
