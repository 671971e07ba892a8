#include "dataset/sweep/detail/results.hpp"

#include <algorithm>
#include <cmath>

#include "core/hdf5.hpp"
#include "core/json.hpp"
#include "core/numbers.hpp"
#include "dataset/run/trace_json.hpp"
#include "dataset/sweep/detail/sound_measures.hpp"

namespace carillon::dataset::sweep {

using core::Hdf5Group;
using nlohmann::json;
using nlohmann::ordered_json;

namespace {

/// Null of none. What is not a number does not count.
ordered_json median_of(std::vector<double> values) {
  std::erase_if(values, [](double value) { return std::isnan(value); });
  return core::number_or_null(core::median(std::move(values)));
}

/// Measures of sounds, before `audio.gain`, heard by the first listener.
struct Heard {
  std::vector<double> level_db, peak_db, centroid_hz, decay_s;
};

Heard listen(const configuration::BuildConfig& config, const Hdf5Group& index) {
  const std::size_t rows = index.extent("audio").front();
  const std::size_t measured = std::min(rows, max_measured_sounds);
  const std::size_t samples = config.scene.audio.samples();
  const double full_scale =
      config.scene.audio.dtype == core::SampleFormat::int16 ? core::int16_full_scale : 1;
  const double gain_db = core::amplitude_decibels(full_scale * std::abs(config.scene.audio.gain));
  Heard heard;
  for (std::size_t i = 0; i < measured; ++i) {
    const std::vector<float> row = index.read_rows<float>("audio", i * rows / measured, 1);
    const auto sound = measure_sound(std::span(row).first(samples), config.scene.audio.sample_rate);
    if (!sound) continue;
    heard.level_db.push_back(sound->level_db - gain_db);
    heard.peak_db.push_back(sound->peak_db - gain_db);
    heard.centroid_hz.push_back(sound->centroid_hz);
    if (sound->decay_s) heard.decay_s.push_back(*sound->decay_s);
  }
  return heard;
}

template <class T>
std::vector<double> column(const Hdf5Group& index, const char* name) {
  const std::vector<T> values = index.read<T>(name);
  return {values.begin(), values.end()};
}

}  // namespace

ordered_json variant_results(const run::BuildRun& run, const run::Results& results) {
  ordered_json row = {{"samples", results.samples},
                      {"failed_tasks", results.failed},
                      {"warnings", results.warnings},
                      {"missed_pitch_targets", results.missed.size()},
                      {"pitch_error_worst_cents", nullptr},
                      {"pitch_error_median_cents", nullptr},
                      {"modes_median", nullptr},
                      {"decay_s_median", nullptr},
                      {"level_db_median", nullptr},
                      {"peak_db_median", nullptr},
                      {"centroid_hz_median", nullptr},
                      {"snr_db_median", nullptr},
                      {"audio_unit", nullptr}};
  if (results.samples == 0) return row;
  const Hdf5Group index = Hdf5Group::open_file(run.folders.output / "index.h5");
  if (index.has(
          "pitch_error")) {  // a simulation is of several objects, each with errors of its own
    const std::vector<double> errors = index.read<double>("pitch_error");
    row["pitch_error_worst_cents"] = *std::max_element(errors.begin(), errors.end());
    row["pitch_error_median_cents"] = median_of(errors);
    row["modes_median"] = median_of(column<std::int64_t>(index, "modes"));
  }
  const Heard heard = listen(run.build.config, index);
  const bool noisy = index.has("noise_ratio");
  // The level of a noise does not fall; what would be measured is where the sound drowns.
  if (!noisy) row["decay_s_median"] = median_of(heard.decay_s);
  row["level_db_median"] = median_of(heard.level_db);
  row["peak_db_median"] = median_of(heard.peak_db);
  row["centroid_hz_median"] = median_of(heard.centroid_hz);
  if (noisy) row["snr_db_median"] = median_of(index.read<double>("noise_ratio"));
  row["audio_unit"] = index.text_attribute("unit", "audio");
  return row;
}

ordered_json variant_timing(const std::map<std::string, json>& finished) {
  double modes = 0, samples = 0;
  for (const auto& [task, entry] : finished) {
    (task.starts_with("modes/") ? modes : samples) += entry.value("seconds", 0.0);
  }
  core::Trace trace = run::total_trace(finished);
  const auto stage = [&](const char* name) { return trace.stages[name]; };
  return {{"seconds", modes + samples},
          {"modes_s", modes},
          {"samples_s", samples},
          {"mesh_s", stage("mesh").seconds},
          {"solve_s", stage("solve").seconds},
          {"meshes_made", stage("mesh").calls},
          {"meshes_from_cache", stage("mesh from cache").calls},
          {"solves", stage("solve").calls},
          {"mode_sets_from_cache", stage("modes from cache").calls}};
}

}  // namespace carillon::dataset::sweep
