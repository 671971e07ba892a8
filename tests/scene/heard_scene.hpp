#pragma once

#include <cmath>
#include <span>
#include <string>
#include <vector>

#include "core/random.hpp"
#include "scene/chain.hpp"
#include "scene/columns.hpp"
#include "tests/counted_memory.hpp"
#include "tests/synth/curved_bodies.hpp"

namespace carillon::scene {

/// A ball of 1.4 kg whose twelve modes, 300 Hz to 5.8 kHz, breathe and bend.
inline solvers::modes::Modes ringing_ball() {
  std::vector<double> eigenvalues;
  for (int i = 0; i < 12; ++i) eigenvalues.push_back(std::pow(6.28 * (300 + 500 * i), 2));
  solvers::modes::Modes modes =
      synth::modes_with(synth::curved_sphere(0.05, Vec3::Zero(), 4, 2), eigenvalues,
                        [](int mode, const Vec3& x) -> Vec3 {
                          const double wave = std::cos(40 * x.dot(Vec3(1, 0.3 * mode, -0.7)));
                          return 0.8 * (1 + wave) * x.normalized();
                        });
  modes.mass = 1.4;
  return modes;
}

/// What came of a scene.
struct Heard {
  std::vector<float> audio;  ///< of every strike, one after the other
  nlohmann::json record;     ///< of the last strike
  core::Trace trace;
  std::size_t allocated = 0;  ///< [byte] while it was made
};

/// The ball struck in a scene.
inline Heard hear(const std::string& text, std::span<const Effect> registry = effects(),
                  int strikes = 2, const std::string& material = "ceramic") {
  static const solvers::modes::Modes modes = ringing_ball();
  const std::vector<synth::material::Material> materials = {
      synth::material::parse_material(material)};
  static const synth::modal::SurfaceSampler sampler(modes.surface);
  core::ConfigNode root = core::ConfigNode::parse(text, "scene.yaml");
  const Scene scene = read_scene(root, "scene.yaml", registry);
  root.finish();
  Heard heard;
  core::Columns record{columns()};
  const std::size_t before = test::allocated().bytes;
  SoundChain chain(scene, "", heard.trace);
  const RingingObject object = chain.prepare("ball", "ball", modes, materials);
  for (int i = 0; i < strikes; ++i) {
    Sound sound;
    sound.object = &object;
    sound.seed = 3;
    sound.id = static_cast<std::uint64_t>(i);
    sound.record = &record;
    core::RandomStream place(3, sound.id, "strike.position");
    sound.strike.point = sampler.sample(place);
    sound.strike.direction = -synth::modal::frame_at(modes.surface, sound.strike.point).normal;
    sound.strike.impulse = 0.01;
    sound.contact_time = 2e-4;
    chain.make(sound);
    heard.audio.insert(heard.audio.end(), sound.audio.begin(), sound.audio.end());
  }
  heard.allocated = test::allocated().bytes - before;
  heard.record = record.last_row();
  return heard;
}

}  // namespace carillon::scene
