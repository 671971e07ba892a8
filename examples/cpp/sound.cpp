// A sound from modes that were stored before:
//   carillon modes bowl -m ceramic -o bowl.h5 && ./sound bowl.h5 ceramic bowl.wav
#include <carillon/core/audio.hpp>
#include <carillon/core/hdf5.hpp>
#include <carillon/core/random.hpp>
#include <carillon/solvers/modes/modes_file.hpp>
#include <carillon/synth/damping/damping.hpp>
#include <carillon/synth/material/material.hpp>
#include <carillon/synth/modal/ring_down.hpp>
#include <cstdio>
#include <exception>

using namespace carillon;

int main(int argc, char** argv) try {
  if (argc != 4) {
    std::fprintf(stderr, "usage: sound MODES.h5 MATERIAL OUT.wav\n");
    return 2;
  }
  const solvers::modes::Modes modes =
      solvers::modes::read_modes(core::Hdf5Group::open_file(argv[1]));
  const synth::material::Material material = synth::material::parse_material(argv[2]);

  core::RandomStream random(0, 0, "strike.position");
  synth::modal::Strike strike;
  strike.point = synth::modal::SurfaceSampler(modes.surface).sample(random);
  strike.direction = -synth::modal::frame_at(modes.surface, strike.point).normal;
  strike.impulse = 0.01;           // [N s]
  strike.force.duration = 0.5e-3;  // [s]

  const std::vector<double> rates =
      synth::damping::decay_rates(modes, std::vector{material.damping});
  const synth::modal::RingDown rings = synth::modal::ring_down(
      modes, rates, strike, synth::modal::point_velocity(modes, strike.point));
  core::AudioClip clip;
  clip.sample_rate = 44100;
  clip.samples = synth::modal::synthesize(rings, strike.force, clip.sample_rate, 44100);
  core::write_wav(argv[3], clip, core::SampleFormat::float32);
  std::printf("%s: %zu of %zu modes sound\n", argv[3],
              synth::modal::sounding_modes(rings, clip.sample_rate), modes.size());
  return 0;
} catch (const std::exception& error) {
  std::fprintf(stderr, "sound: %s\n", error.what());
  return 1;
}
