#include <fmt/format.h>
#include <fmt/ranges.h>
#include <spdlog/spdlog.h>

#include <cmath>
#include <limits>
#include <memory>

#include "scene/effects/detail/list.hpp"
#include "scene/scene.hpp"
#include "synth/recording/noise_generators.hpp"
#include "synth/recording/noise_recordings.hpp"
#include "synth/recording/recording_file.hpp"
#include "synth/recording/signal_to_noise.hpp"

namespace carillon::scene {

namespace {

// Measured by scripts/bench noise: the dearest kind, or a draw of recordings that stay in memory,
// with the active part and the sum; 1 s at 44.1 kHz.
constexpr double seconds_per_sample_generated = 0.85e-3 / 44100;
constexpr double seconds_per_sample_recorded = 0.3e-3 / 44100;
/// Draws until one is not too weak where the sound is.
constexpr int tries = 32;

struct NoiseSource {
  std::vector<synth::recording::NoiseKind> kinds;  ///< one is drawn for each sound; or else
  std::filesystem::path folder;
  synth::recording::RecordingOptions recordings;
  core::Range ratio;  ///< [dB]
};

/// Noise for every row of a clip, independent in each (hum: of one mains).
struct DrawnNoise {
  std::vector<double> samples;
  std::string description;  ///< kind, or stretches of recordings
};

std::string describe(const std::vector<synth::recording::NoiseSegment>& segments) {
  std::string text;
  for (const synth::recording::NoiseSegment& segment : segments) {
    text += fmt::format("{}{} {:.6f}+{:.6f}", text.empty() ? "" : "; ", segment.name, segment.start,
                        segment.duration);
  }
  return text;
}

DrawnNoise draw(const NoiseSource& source, synth::recording::NoiseFolder* folder,
                const Sound& sound, core::RandomStream& random) {
  DrawnNoise noise;
  const std::size_t count = sound.audio.size() / sound.rows;
  if (folder != nullptr) {
    // One long stretch for all rows: drawn row by row, two of them could be the same.
    synth::recording::NoiseDraw drawn =
        folder->draw(sound.audio.size(), sound.part, sound.parts, random);
    return {std::move(drawn.samples), describe(drawn.segments)};
  }
  const std::size_t kind = random.index(source.kinds.size());
  noise.description =
      synth::recording::noise_kind_names()[static_cast<std::size_t>(source.kinds[kind])];
  noise.samples = synth::recording::generate_rows(source.kinds[kind], count, sound.rows,
                                                  sound.sample_rate, random);
  return noise;
}

/// A noise that is not too weak where the sound is: of `tries`, the first that will do or else the
/// best.
DrawnNoise draw_audible(const NoiseSource& source, synth::recording::NoiseFolder* folder,
                        const Sound& sound, const synth::recording::ActivePart& active) {
  core::RandomStream random(sound.seed, sound.id, "noise.samples");
  const synth::recording::ActivePart whole{0, sound.audio.size() / sound.rows};
  DrawnNoise best;
  double best_fraction = -1;
  for (int i = 0; i < tries && best_fraction < synth::recording::min_noise_fraction; ++i) {
    DrawnNoise noise = draw(source, folder, sound, random);
    const std::span<const double> samples = noise.samples;
    const double all = synth::recording::mean_power(samples, sound.rows, whole);
    const double fraction =
        all > 0 ? synth::recording::mean_power(samples, sound.rows, active) / all : 0;
    if (fraction <= best_fraction) continue;
    best_fraction = fraction;
    best = std::move(noise);
  }
  return best;
}

void add_noise(const NoiseSource& source, synth::recording::NoiseFolder* folder, Sound& sound) {
  core::RandomStream random(sound.seed, sound.id, "noise.ratio");
  double ratio = random.uniform(source.ratio.low, source.ratio.high);
  const synth::recording::ActivePart active =
      synth::recording::active_part(sound.audio, sound.rows, sound.sample_rate);
  DrawnNoise noise;
  double level = 0;
  if (active.empty()) {
    // Nothing to measure a ratio by: the clip stays silent, and the record says so.
    ratio = std::numeric_limits<double>::quiet_NaN();
  } else {
    noise = draw_audible(source, folder, sound, active);
    const double factor =
        synth::recording::add_noise(sound.audio, noise.samples, sound.rows, active, ratio);
    level = factor * std::sqrt(synth::recording::mean_power(std::span<const double>(noise.samples),
                                                            sound.rows, active));
  }
  if (sound.record == nullptr) return;
  sound.record->add("noise_ratio", ratio);
  sound.record->add("noise_level", level, sound.rings.readout.unit);
  sound.record->add("noise_source", noise.description);
  const auto in_clip = [&](std::size_t sample) {
    return (static_cast<double>(sample) - static_cast<double>(sound.before)) / sound.sample_rate;
  };
  sound.record->add("active_begin", in_clip(active.begin));
  sound.record->add("active_end", in_clip(active.end));
}

NoiseSource read_source(core::ConfigNode& node, const Scene& scene) {
  NoiseSource source;
  source.ratio = node.range("snr", core::Dimension::level, core::Range{10, 40});
  if (source.ratio.low < -100 || source.ratio.high > 200) {
    node.fail("snr",
              fmt::format("{} to {} dB are no noise that single precision holds", source.ratio.low,
                          source.ratio.high),
              "ratios from -100 to 200 dB are possible");
  }
  const auto& names = synth::recording::noise_kind_names();
  if (node.has("folder") == node.has("kind")) {
    node.fail(node.has("kind") ? "kind" : "",
              node.has("kind") ? "either `folder` or `kind`, not both"
                               : "noise needs `folder`, with recordings, or `kind`",
              fmt::format("kinds: {}", fmt::join(names, ", ")));
  }
  if (node.has("folder")) {
    source.folder = core::path_beside(scene.file_name, node.text("folder"));
    source.recordings.sample_rate = scene.audio.sample_rate;
    source.recordings.channel = static_cast<int>(node.integer("channel", 0, 1024, 0));
    source.recordings.memory = static_cast<std::size_t>(
        node.quantity("memory", core::Dimension::memory, 256.0 * 1024 * 1024));
    return source;
  }
  for (const std::string& name : node.texts("kind")) {
    source.kinds.push_back(
        core::at_key(node, "kind", [&] { return synth::recording::noise_kind(name); }));
  }
  if (source.kinds.empty()) {
    node.fail("kind", "an empty list", fmt::format("kinds: {}", fmt::join(names, ", ")));
  }
  return source;
}

std::shared_ptr<synth::recording::NoiseFolder> open_folder(const NoiseSource& source) {
  auto folder = std::make_shared<synth::recording::NoiseFolder>(source.folder, source.recordings);
  const auto& left_out = folder->left_out();
  if (!left_out.empty()) {
    spdlog::warn("noise: {} of {} files in {} are not used; the first: {}", left_out.size(),
                 left_out.size() + folder->recordings().size(), source.folder.string(),
                 left_out.front());
  }
  return folder;
}

SceneEffect read(core::ConfigNode& root, const Scene& scene) {
  SceneEffect effect;
  if (!root.has("noise")) {
    effect.reason_off = "no noise:";
    return effect;
  }
  core::ConfigNode node = root.child("noise");
  const NoiseSource source = read_source(node, scene);
  effect.asked_by = "noise: (" + root.where("noise") + ")";
  effect.seconds_per_sound =
      static_cast<double>(scene.rendered_samples()) *
      (source.kinds.empty() ? seconds_per_sample_recorded : seconds_per_sample_generated);
  if (source.kinds.empty()) {
    effect.check = [node, folder = source.folder, parts = scene.parts] {
      core::at_key(node, "folder", [&] { synth::recording::check_noise_folder(folder, parts); });
    };
    effect.memory = static_cast<double>(source.recordings.memory);
    effect.content = [folder = source.folder] {
      return synth::recording::content_of_files(folder);
    };
  }
  effect.start = [source](const std::filesystem::path&) {
    const auto folder = source.kinds.empty() ? open_folder(source) : nullptr;
    EffectParts parts;
    parts.audio = [source, folder](Sound& sound) { add_noise(source, folder.get(), sound); };
    return parts;
  };
  return effect;
}

}  // namespace

const Effect noise_effect = {
    .name = "noise",
    .description = "recorded or generated noise at a ratio to the active part of the sound",
    .key = "noise",
    .stage = "audio",
    .read = read};

}  // namespace carillon::scene
