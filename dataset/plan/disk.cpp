#include "dataset/plan/disk.hpp"

namespace carillon::dataset::plan {

namespace {

/// What a simulation has beside its sound.
void add_simulation(const configuration::BuildConfig& config, SampleBytes& bytes) {
  const scene::motion::MotionConfig& motion = *config.motion;
  const double seconds = config.scene.audio.seconds;
  constexpr double pose = 7 * 8, strike = 15 * 8, tick = 9 * 8;
  bytes.motion = pose * seconds * motion.state_rate * static_cast<double>(motion.bodies.size() + 1);
  bytes.motion += strike * motion.kept_strikes;
  if (motion.stylus) bytes.motion += tick * seconds / motion.options.time_step;
  if (motion.camera) {
    const int values = 3 + (motion.camera->depth ? 4 : 0) + (motion.camera->masks ? 1 : 0);
    bytes.pixels = motion.camera->pixels(seconds) * values;
  }
}

}  // namespace

SampleBytes sample_bytes(const configuration::BuildConfig& config) {
  const scene::AudioConfig& audio = config.scene.audio;
  const double rows = static_cast<double>(config.scene.rows());
  SampleBytes bytes;
  bytes.audio = rows * static_cast<double>(audio.samples()) *
                (audio.dtype == core::SampleFormat::int16 ? 2 : 4);
  if (config.wav) bytes.wav = bytes.audio;
  if (config.mel) {
    const synth::signal::MelExtent mel = synth::signal::mel_extent(audio.samples(), *config.mel);
    bytes.mel = rows * 4.0 * mel.bands * mel.frames;
  }
  if (config.motion) add_simulation(config, bytes);
  return bytes;
}

}  // namespace carillon::dataset::plan
