#pragma once

#include <cstddef>
#include <memory>
#include <nlohmann/json.hpp>
#include <span>
#include <vector>

#include "core/audio.hpp"
#include "eval/learning/modality.hpp"
#include "synth/signal/mel.hpp"

namespace carillon::eval::learning {

/// What the sounds of a source are: a classifier is to be given others in the same way.
struct ClipFormat {
  std::size_t samples = 44100;
  synth::signal::MelOptions mel;  ///< of spectrograms; its sample rate is that of the sounds

  double sample_rate() const { return mel.sample_rate; }
};

/// Spectrograms of the papers' size, 64 bands and 25 frames (Sterling 2019, section 6.3.1).
ClipFormat paper_format(std::size_t samples, double sample_rate);

nlohmann::json to_json(const ClipFormat& format);
ClipFormat clip_format_from(const nlohmann::json& json);

/// Turns sounds into the modalities of hearing. One object for each thread.
class ClipPreparer {
 public:
  /// @throws InputError  no samples, or impossible mel options
  explicit ClipPreparer(const ClipFormat& format);

  const ClipFormat& format() const { return format_; }
  /// @param modality  spectrogram (relative powers) or waveform
  ModalityExtent extent(Modality modality) const;
  /// @param clip    as many samples as the format has
  /// @param values  of the modality's extent
  /// @return whether anything sounds
  /// @throws InputError  a value is not finite
  bool prepare(Modality modality, std::span<const float> clip, std::span<float> values) const;

 private:
  ClipFormat format_;
  std::unique_ptr<synth::signal::MelSpectrogram> mel_;
};

/// A recording as a clip of this format: the mean of its channels, resampled, from its loudest
/// strike on (from its begin where none is found), silence after its end.
/// @throws InputError  no samples, or one that is not finite
std::vector<float> strike_clip(const core::AudioClip& recording, const ClipFormat& format);

/// Clips' lengths of noise that a clip is cut from.
inline constexpr std::size_t noise_lengths = 3;
/// The same of a noise that goes on: from its loudest onset within the first two clips' lengths.
/// @param noise  noise_lengths times as many samples as the format has, at its rate
/// @throws InputError  another length, or a sample that is not finite
std::vector<float> noise_clip(std::span<const double> noise, const ClipFormat& format);

}  // namespace carillon::eval::learning
