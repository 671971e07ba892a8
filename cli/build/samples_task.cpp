#include "cli/build/samples_task.hpp"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "cli/build/damping_columns.hpp"
#include "cli/columns.hpp"
#include "cli/sound/chain.hpp"
#include "cli/text.hpp"
#include "core/audio.hpp"
#include "core/files.hpp"
#include "synth/recording_chain.hpp"

namespace carillon::cli {

namespace {

constexpr double int16_full_scale = 32768;  // as in WAV files

std::vector<std::int16_t> to_int16(std::span<const float> audio, std::int64_t& clipped) {
  std::vector<std::int16_t> out;
  out.reserve(audio.size());
  for (const float value : audio) {
    const double scaled = std::nearbyint(static_cast<double>(value) * int16_full_scale);
    const double held = std::clamp(scaled, -int16_full_scale, int16_full_scale - 1);
    if (held != scaled) ++clipped;
    out.push_back(static_cast<std::int16_t>(held));
  }
  return out;
}

void add_vector(Columns& columns, const std::string& name, const solvers::Vec3& v,
                const std::string& unit) {
  columns.add<double>(name, std::span(v.data(), 3), {3}, unit);
}

void add_labels(const BuildConfig& config, const Shape& shape, const Sample& sample,
                const std::vector<synth::Material>& materials,
                const std::vector<std::string>& damping_units, Columns& columns) {
  const Variant& variant = shape.variants[sample.variant];
  columns.add("key", sample.key);
  columns.add("id", sample.id);
  columns.add("shape", shape.id);
  columns.add("family", shape.family);
  columns.add("material", variant.material);
  columns.add("size", variant.size);
  columns.add("strike", static_cast<std::int64_t>(sample.strike));
  columns.add("split_shape", shape.split_shape);
  columns.add("split_strike", split_strike(config, shape, sample.strike));
  // Of the first region where a body has several; dataset.json lists them all.
  const synth::Material& material = materials.front();
  columns.add("youngs_modulus", material.elastic.youngs_modulus, "Pa");
  columns.add("poisson_ratio", material.elastic.poisson_ratio);
  columns.add("density", material.elastic.density, "kg/m^3");
  add_damping_columns(material.damping, damping_units, columns);
}

void add_strike_columns(const SampleResult& result, Columns& columns) {
  add_vector(columns, "position", result.frame.position, "m");
  add_vector(columns, "normal", result.frame.normal, "1");
  add_vector(columns, "direction", result.sound.strike.direction, "1");
  columns.add("impulse", result.sound.strike.impulse, "N s");
  columns.add("contact_time", result.sound.strike.force.duration, "s");
  columns.add("modes", static_cast<std::int64_t>(result.sound.modes));
  columns.add("complete_to", result.complete_to_hz, "Hz");
  columns.add("pitch_error", result.pitch_error, "cent");
}

void add_audio(const BuildConfig& config, const SampleResult& result, Columns& columns) {
  const auto samples = static_cast<std::uint64_t>(config.scene.audio.samples());
  const auto listeners = static_cast<std::uint64_t>(config.scene.rows());
  const core::Extent inner =
      listeners > 1 ? core::Extent{listeners, samples} : core::Extent{samples};
  std::int64_t clipped = 0;
  if (config.scene.audio.dtype == core::SampleFormat::int16) {
    columns.add<std::int16_t>("audio", to_int16(result.sound.audio, clipped), inner,
                              result.sound.rings.readout.unit);
  } else {
    columns.add<float>("audio", result.sound.audio, inner, result.sound.rings.readout.unit);
  }
  columns.add("gain", config.scene.audio.gain,
              result.sound.rings.readout.unit == "Pa" ? "1/Pa" : "s/m");
  columns.add("peak", result.peak);
  columns.add("clipped", clipped);
}

void add_mel(const BuildConfig& config, const synth::MelSpectrogram& mel,
             const SampleResult& result, Columns& columns) {
  const std::size_t samples = config.scene.audio.samples();
  std::vector<float> all;
  for (std::size_t from = 0; from < result.sound.audio.size(); from += samples) {
    const std::vector<float> one = mel(std::span(result.sound.audio).subspan(from, samples));
    all.insert(all.end(), one.begin(), one.end());
  }
  const auto bands = static_cast<std::uint64_t>(config.mel->bands);
  const auto frames = static_cast<std::uint64_t>(synth::mel_frames(samples, *config.mel));
  const auto listeners = static_cast<std::uint64_t>(config.scene.rows());
  columns.add<float>(
      "mel", all,
      listeners > 1 ? core::Extent{listeners, bands, frames} : core::Extent{bands, frames},
      "power");
}

}  // namespace

void write_mel_attributes(const synth::MelOptions& mel, const core::Hdf5Group& file) {
  file.write_attribute("scale", "slaney", "mel");
  file.write_attribute("norm", "slaney (area)", "mel");
  file.write_attribute("power", 2.0, "mel");
  file.write_attribute("window", "hann, periodic", "mel");
  file.write_attribute("padding", "centred, zeros", "mel");
  file.write_attribute("fft_size", static_cast<std::int64_t>(mel.fft_size), "mel");
  file.write_attribute("hop", static_cast<std::int64_t>(mel.hop), "mel");
  file.write_attribute("min_frequency_hz", mel.min_frequency, "mel");
  file.write_attribute("max_frequency_hz", mel.max_frequency, "mel");
}

namespace {

/// sounds/cup-001/glass-1-strike-0003.wav
std::filesystem::path sound_path(const Shape& shape, const Sample& sample) {
  const Variant& variant = shape.variants[sample.variant];
  return std::filesystem::path("sounds") / shape.id /
         fmt::format("{}-{}-strike-{:04}.wav", file_safe(variant.material), variant.size,
                     sample.strike);
}

/// One channel per listener.
void write_sound(const BuildConfig& config, const std::filesystem::path& path,
                 const SampleResult& result, const BuildFolders& folders) {
  core::write_durably(folders.output / path, [&](const std::filesystem::path& temporary) {
    core::write_wav(temporary, clip_of(result.sound), config.scene.audio.dtype);
  });
}

}  // namespace

std::vector<std::string> run_samples_task(const BuildConfig& config, const BuildPlan& plan,
                                          const BuildTask& task, const BuildFolders& folders,
                                          core::Trace& trace, std::size_t kept) {
  const Shape& shape = plan.shapes[task.shape];
  SampleMaker maker(config, shape, folders, trace);
  std::unique_ptr<synth::MelSpectrogram> mel;
  if (config.mel) mel = std::make_unique<synth::MelSpectrogram>(*config.mel);
  const std::vector<std::string> damping_units = damping_column_units(named_materials(config));
  Columns columns;
  std::vector<std::string> written;
  std::size_t silent = 0;
  for (std::size_t i = task.first; i < task.first + task.count; ++i) {
    const Sample& sample = plan.samples[i];
    if (config.wav) written.push_back(sound_path(shape, sample).string());
    if (i < task.first + kept) continue;
    const SampleResult result = maker.make(sample, &columns);
    add_labels(config, shape, sample, maker.materials(sample.variant), damping_units, columns);
    add_strike_columns(result, columns);
    add_audio(config, result, columns);
    if (config.scene.audio.dtype == core::SampleFormat::int16 && result.peak > 0 &&
        synth::silent_after_rounding(result.sound.audio, 16)) {
      ++silent;
    }
    if (mel) {
      const core::ScopedTimer timer(trace.effects["mel"]);
      add_mel(config, *mel, result, columns);
    }
    if (config.wav) write_sound(config, written.back(), result, folders);
  }
  if (silent > 0) {
    spdlog::warn("{}: {} of {} sounds are nothing but zeros in 16 bits; raise audio.gain", task.key,
                 silent, task.count);
  }
  const core::ScopedTimer timer(trace.stages["write shard"]);
  if (kept > 0) {
    columns.put_before(core::Hdf5Group::open_file(folders.shard_file(task)), kept);
  }
  core::write_durably(folders.shard_file(task), [&](const std::filesystem::path& path) {
    const core::Hdf5Group file = core::Hdf5Group::create_file(path);
    file.write_attribute("sample_rate_hz", config.scene.audio.sample_rate);
    columns.write(file);
    if (config.mel) write_mel_attributes(*config.mel, file);
    file.flush();
  });
  written.push_back(std::filesystem::relative(folders.shard_file(task), folders.output).string());
  return written;
}

}  // namespace carillon::cli
