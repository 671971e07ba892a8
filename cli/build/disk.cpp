#include "cli/build/disk.hpp"

namespace carillon::cli {

double sample_bytes(const BuildConfig& config) {
  const double rows = static_cast<double>(config.scene.rows());
  const double audio = static_cast<double>(config.scene.audio.samples()) *
                       (config.scene.audio.dtype == core::SampleFormat::int16 ? 2 : 4);
  const double mel = config.mel ? 4.0 * config.mel->bands *
                                      synth::mel_frames(config.scene.audio.samples(), *config.mel)
                                : 0;
  return rows * (audio * (config.wav ? 2 : 1) + mel);
}

}  // namespace carillon::cli
