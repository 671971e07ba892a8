#include "dataset/plan/disk.hpp"

namespace carillon::dataset::plan {

namespace {

/// Of what a simulation has beside its sound.
double simulation_bytes(const configuration::BuildConfig& config) {
  const scene::motion::MotionConfig& motion = *config.motion;
  const double seconds = config.scene.audio.seconds;
  constexpr double pose = 7 * 8, strike = 15 * 8, tick = 9 * 8;
  double bytes = pose * seconds * motion.state_rate * static_cast<double>(motion.bodies.size() + 1);
  bytes += strike * motion.kept_strikes;
  if (motion.stylus) bytes += tick * seconds / motion.options.time_step;
  if (motion.camera) {
    const int values = 3 + (motion.camera->depth ? 4 : 0) + (motion.camera->masks ? 1 : 0);
    bytes += motion.camera->pixels(seconds) * values;
  }
  return bytes;
}

}  // namespace

double sample_bytes(const configuration::BuildConfig& config) {
  const double rows = static_cast<double>(config.scene.rows());
  const double audio = static_cast<double>(config.scene.audio.samples()) *
                       (config.scene.audio.dtype == core::SampleFormat::int16 ? 2 : 4);
  const double mel = config.mel
                         ? 4.0 * config.mel->bands *
                               synth::signal::mel_frames(config.scene.audio.samples(), *config.mel)
                         : 0;
  return rows * (audio * (config.wav ? 2 : 1) + mel) +
         (config.motion ? simulation_bytes(config) : 0);
}

}  // namespace carillon::dataset::plan
