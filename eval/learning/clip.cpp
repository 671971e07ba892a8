#include "eval/learning/clip.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/error.hpp"
#include "eval/features/segment.hpp"
#include "synth/signal/resample.hpp"

namespace carillon::eval::learning {

ClipFormat paper_format(std::size_t samples, double sample_rate) {
  ClipFormat format;
  format.samples = samples;
  format.mel.sample_rate = sample_rate;
  format.mel.bands = 64;
  format.mel.max_frequency = sample_rate / 2;
  constexpr std::size_t frames = 25;
  format.mel.hop = static_cast<int>(std::max<std::size_t>(1, samples / (frames - 1)));
  return format;
}

nlohmann::json to_json(const ClipFormat& format) {
  return {{"samples", format.samples},
          {"sample_rate", format.mel.sample_rate},
          {"fft_size", format.mel.fft_size},
          {"hop", format.mel.hop},
          {"bands", format.mel.bands},
          {"resized", {format.mel.resized_bands, format.mel.resized_frames}},
          {"min_frequency", format.mel.min_frequency},
          {"max_frequency", format.mel.max_frequency}};
}

ClipFormat clip_format_from(const nlohmann::json& json) {
  ClipFormat format;
  format.samples = json.at("samples");
  format.mel = {.sample_rate = json.at("sample_rate"),
                .fft_size = json.at("fft_size"),
                .hop = json.at("hop"),
                .bands = json.at("bands"),
                .min_frequency = json.at("min_frequency"),
                .max_frequency = json.at("max_frequency"),
                .resized_bands = json.at("resized").at(0),
                .resized_frames = json.at("resized").at(1)};
  return format;
}

ClipPreparer::ClipPreparer(const ClipFormat& format)
    : format_(format), mel_(std::make_unique<synth::signal::MelSpectrogram>(format.mel)) {
  if (format.samples == 0) throw core::InputError("clips have no samples");
}

ModalityExtent ClipPreparer::extent(Modality modality) const {
  if (modality == Modality::spectrogram) {
    const synth::signal::MelExtent mel = synth::signal::mel_extent(format_.samples, format_.mel);
    return {1, mel.bands, mel.frames};
  }
  return {1, std::llround(static_cast<double>(format_.samples) * prepare::waveform_rate /
                          format_.sample_rate())};
}

bool ClipPreparer::prepare(Modality modality, std::span<const float> clip,
                           std::span<float> values) const {
  if (modality == Modality::spectrogram) {
    const std::vector<float> power = (*mel_)(clip);
    std::copy_n(power.begin(), values.size(), values.begin());
    return prepare::spectrogram(values);
  }
  const std::vector<float> prepared = prepare::waveform(clip, format_.sample_rate());
  std::copy_n(prepared.begin(), std::min(prepared.size(), values.size()), values.begin());
  return std::any_of(prepared.begin(), prepared.end(), [](float value) { return value != 0; });
}

namespace {

/// Sample of the loudest strike; 0 where none is found.
std::size_t onset_in(std::span<const double> signal, double sample_rate) {
  const features::Segment segment = features::find_segment(signal, sample_rate, {}, 0);
  return segment.nothing.empty() ? segment.onset : 0;
}

}  // namespace

std::vector<float> strike_clip(const core::AudioClip& recording, const ClipFormat& format) {
  const auto channels = static_cast<std::size_t>(recording.channels);
  std::vector<double> mono(recording.samples.size() / channels, 0.0);
  for (std::size_t i = 0; i < recording.samples.size(); ++i) {
    const double value = recording.samples[i];
    if (!std::isfinite(value)) {
      throw core::InputError(fmt::format("sample {} is {}", i / channels, value));
    }
    mono[i / channels] += value / static_cast<double>(channels);
  }
  if (mono.empty()) throw core::InputError("it has no samples");
  const std::vector<double> rest =
      synth::signal::resample(std::span(mono).subspan(onset_in(mono, recording.sample_rate)),
                              recording.sample_rate, format.sample_rate());
  std::vector<float> clip(format.samples, 0.0F);
  std::transform(rest.begin(),
                 rest.begin() + static_cast<std::ptrdiff_t>(std::min(rest.size(), clip.size())),
                 clip.begin(), [](double value) { return static_cast<float>(value); });
  return clip;
}

std::vector<float> noise_clip(std::span<const double> noise, const ClipFormat& format) {
  const std::size_t count = format.samples;
  if (noise.size() != noise_lengths * count) {
    throw core::InputError(fmt::format("{} samples of noise for clips of {}", noise.size(), count));
  }
  const auto cut = noise.subspan(onset_in(noise.first(2 * count), format.sample_rate()), count);
  std::vector<float> clip;
  for (const double value : cut) clip.push_back(static_cast<float>(value));
  return clip;
}

}  // namespace carillon::eval::learning
