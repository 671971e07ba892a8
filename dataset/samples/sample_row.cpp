#include "dataset/samples/sample_row.hpp"

#include "core/audio.hpp"
#include "dataset/samples/damping_columns.hpp"
#include "dataset/samples/simulation_rows.hpp"

namespace carillon::dataset::samples {

namespace {

void add_vector(core::Columns& columns, const std::string& name, const Vec3& v) {
  columns.add<double>(name, std::span(v.data(), 3), {3});
}

void add_labels(const configuration::BuildConfig& config, const plan::Shape& shape,
                const plan::Sample& sample, const std::vector<synth::material::Material>& materials,
                const std::vector<std::string>& damping_units, double size,
                core::Columns& columns) {
  const plan::Variant& variant = shape.variants[sample.variant];
  columns.add("key", sample.key);
  columns.add("id", sample.id);
  columns.add("shape", shape.id);
  columns.add("family", shape.family);
  for (const std::string& name : configuration::named_labels(config)) {
    const auto label = shape.labels.find(name);
    columns.add("label_" + name, label == shape.labels.end() ? std::string() : label->second);
  }
  columns.add("material", variant.material);
  columns.add("size", size);
  columns.add("strike", static_cast<std::int64_t>(sample.strike));
  columns.add("split_shape", shape.split_shape);
  columns.add("split_strike", plan::split_strike(config, shape, sample.strike));
  // Of the first region where an object has several; dataset.json lists them all.
  const synth::material::Material& material = materials.front();
  columns.add("youngs_modulus", material.elastic.youngs_modulus);
  columns.add("poisson_ratio", material.elastic.poisson_ratio);
  columns.add("density", material.elastic.density);
  add_damping_columns(material.damping, damping_units, columns);
}

void add_strike_columns(const SampleResult& result, core::Columns& columns) {
  add_vector(columns, "position", result.frame.position);
  add_vector(columns, "normal", result.frame.normal);
  add_vector(columns, "direction", result.sound.strike.direction);
  columns.add("impulse", result.sound.strike.impulse);
  columns.add("contact_time", result.sound.strike.force.duration);
  columns.add("modes", static_cast<std::int64_t>(result.sound.modes));
  columns.add("modes_above_nyquist", static_cast<std::int64_t>(result.sound.modes_above_nyquist));
  columns.add("complete_to", result.complete_to_hz);
  columns.add("pitch_error", result.pitch_error);
}

void add_audio(const configuration::BuildConfig& config, const SampleResult& result,
               core::Columns& columns) {
  const auto samples = static_cast<std::uint64_t>(config.scene.audio.samples());
  const auto listeners = static_cast<std::uint64_t>(config.scene.rows());
  const core::Extent inner =
      listeners > 1 ? core::Extent{listeners, samples} : core::Extent{samples};
  std::int64_t clipped = 0;
  if (config.scene.audio.dtype == core::SampleFormat::int16) {
    columns.add<std::int16_t>("audio", core::to_int16(result.sound.audio, &clipped), inner,
                              result.sound.rings.readout.unit);
  } else {
    columns.add<float>("audio", result.sound.audio, inner, result.sound.rings.readout.unit);
  }
  columns.add("gain", config.scene.audio.gain,
              result.sound.rings.readout.unit == "Pa" ? "1/Pa" : "s/m");
  columns.add("peak", result.peak);
  columns.add("clipped", clipped);
}

void add_mel(const configuration::BuildConfig& config, const synth::signal::MelSpectrogram& mel,
             const SampleResult& result, core::Columns& columns) {
  const std::size_t samples = config.scene.audio.samples();
  std::vector<float> all;
  for (std::size_t from = 0; from < result.sound.audio.size(); from += samples) {
    const std::vector<float> one = mel(std::span(result.sound.audio).subspan(from, samples));
    all.insert(all.end(), one.begin(), one.end());
  }
  const synth::signal::MelExtent extent = synth::signal::mel_extent(samples, *config.mel);
  const auto bands = static_cast<std::uint64_t>(extent.bands);
  const auto frames = static_cast<std::uint64_t>(extent.frames);
  const auto listeners = static_cast<std::uint64_t>(config.scene.rows());
  columns.add<float>(
      "mel", all,
      listeners > 1 ? core::Extent{listeners, bands, frames} : core::Extent{bands, frames});
}

}  // namespace

SampleRows::SampleRows(const configuration::BuildConfig& config, const plan::Shape& shape,
                       const BuildFolders& folders, core::Trace& trace)
    : config_(config),
      shape_(shape),
      trace_(trace),
      maker_(config, shape, folders, trace),
      damping_units_(damping_column_units(configuration::named_materials(config))) {
  if (config.mel) mel_ = std::make_unique<synth::signal::MelSpectrogram>(*config.mel);
}

void add_sound_columns(const configuration::BuildConfig& config, const SampleResult& result,
                       const synth::signal::MelSpectrogram* mel, core::Trace& trace,
                       core::Columns& columns) {
  add_audio(config, result, columns);
  if (mel == nullptr) return;
  const core::ScopedTimer timer(trace.effects["mel"]);
  add_mel(config, *mel, result, columns);
}

SampleResult SampleRows::add(const plan::Sample& sample, core::Columns& columns) {
  SampleResult result = maker_.make(sample, &columns);
  add_labels(config_, shape_, sample, maker_.materials(sample.variant), damping_units_,
             maker_.size(sample.variant), columns);
  add_strike_columns(result, columns);
  add_sound_columns(config_, result, mel_.get(), trace_, columns);
  return result;
}

AddRow row_maker(const configuration::BuildConfig& config, const plan::BuildPlan& plan,
                 std::size_t shape, const BuildFolders& folders, core::Trace& trace) {
  if (config.motion) {
    auto simulations = std::make_shared<SimulationRows>(config, plan, folders, trace);
    return [simulations](const plan::Sample& sample, core::Columns& columns) {
      return simulations->add(sample, columns);
    };
  }
  auto rows = std::make_shared<SampleRows>(config, plan.shapes[shape], folders, trace);
  return [rows](const plan::Sample& sample, core::Columns& columns) {
    return rows->add(sample, columns);
  };
}

}  // namespace carillon::dataset::samples
