#include "dataset/run/preview.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <nlohmann/json.hpp>

#include "core/audio.hpp"
#include "core/error.hpp"
#include "core/image.hpp"
#include "core/numbers.hpp"
#include "dataset/samples/simulation_rows.hpp"
#include "mpi/comm.hpp"
#include "mpi/exit_code.hpp"
#include "mpi/running_task.hpp"
#include "scene/chain.hpp"
#include "scene/columns.hpp"

namespace carillon::dataset::run {

namespace {

/// A sample by its number in the plan, its id or its key.
const plan::Sample& find_sample(const plan::BuildPlan& plan, const std::string& name) {
  std::uint64_t number = 0;
  const auto [end, error] = std::from_chars(name.data(), name.data() + name.size(), number);
  const bool numeric = error == std::errc() && end == name.data() + name.size();
  if (numeric && number < plan.samples.size()) return plan.samples[number];
  std::vector<std::string> keys;
  for (const plan::Sample& sample : plan.samples) {
    if (sample.key == name || (numeric && sample.id == number)) return sample;
    keys.push_back(sample.key);
  }
  const std::string near = core::nearest_name(name, keys);
  throw core::InputError(fmt::format("no sample \"{}\"", name),
                         near.empty() ? fmt::format("numbers go from 0 to {}, keys look like {}",
                                                    plan.samples.size() - 1, keys.front())
                                      : fmt::format("did you mean {}?", near));
}

/// Grey picture of a spectrogram, 80 dB below its maximum black, low bands at the bottom.
core::Image spectrogram_picture(const std::vector<float>& mel, synth::signal::MelExtent extent) {
  const auto [bands, frames] = extent;
  constexpr int scale = 6;
  constexpr double floor_db = -80;
  const float top = std::max(1e-30f, *std::max_element(mel.begin(), mel.end()));
  core::Image image{frames * scale, bands * scale, 1, {}};
  image.pixels.resize(static_cast<std::size_t>(image.width * image.height));
  for (int y = 0; y < image.height; ++y) {
    const int band = bands - 1 - y / scale;
    for (int x = 0; x < image.width; ++x) {
      const double power = mel[static_cast<std::size_t>(band * frames + x / scale)];
      const double db = core::decibels(std::max(power / top, 1e-12));
      image.pixels[static_cast<std::size_t>(y * image.width + x)] =
          static_cast<std::uint8_t>(std::lround(255 * std::clamp(1 - db / floor_db, 0.0, 1.0)));
    }
  }
  return image;
}

/// What a preview shows besides what the configuration asks for.
void show_all(configuration::BuildConfig& config) {
  if (!config.mel) {
    config.mel = synth::signal::MelOptions{.sample_rate = config.scene.audio.sample_rate};
  }
  if (config.cameras.empty()) config.cameras = {render::Camera{}};
  if (config.motion && config.motion->camera) config.motion->camera->movie = true;
  config.png = true;
}

/// Of objects that are struck, the sample's own material is the one that is drawn.
void draw_only(const plan::Sample& sample, plan::Shape& shape) {
  const std::string material = shape.variants[sample.variant].material;
  for (plan::Variant& variant : shape.variants) variant.sounds = variant.material == material;
}

void write_sound(const configuration::BuildConfig& config, const samples::SampleResult& result,
                 const std::filesystem::path& folder) {
  core::write_wav(folder / "sound.wav", scene::clip_of(result.sound), core::SampleFormat::float32);
  const std::size_t count = config.scene.audio.samples();
  const std::vector<float> mel =
      synth::signal::MelSpectrogram(*config.mel)(std::span(result.sound.audio).first(count));
  core::write_png(folder / "spectrogram.png",
                  spectrogram_picture(mel, synth::signal::mel_extent(count, *config.mel)));
}

}  // namespace

Preview preview_sample(LoadedBuild& build, const std::string& name,
                       const std::filesystem::path& output, const std::filesystem::path& cache,
                       MPI_Comm comm) {
  if (std::filesystem::exists(output / "journal.jsonl")) {
    throw core::InputError(fmt::format("{} holds a dataset", output.string()),
                           "choose another folder with --output");
  }
  show_all(build.config);
  const plan::Sample& sample = find_sample(build.plan, name);
  if (!build.config.motion) draw_only(sample, build.plan.shapes[sample.shape]);
  const samples::BuildFolders folders{output, cache};
  core::Trace trace;
  // Nobody reads what it would write, but it ends what hangs, as in a build.
  mpi::RunningTask running("", mpi::exit_input);
  for (const std::size_t s : plan::shapes_of(build.plan, sample)) {
    configuration::watch_task(running, build.config.limits, sample.key, trace, comm, [&] {
      samples::run_modes_task(build.config, build.plan.shapes[s], folders, comm, trace);
    });
  }
  Preview preview;
  if (mpi::rank(comm) != 0) return preview;
  preview.sample = &sample;
  preview.moving = build.config.motion.has_value();
  preview.movie = build.config.scene.runs("movie");
  core::Columns record(scene::columns());
  configuration::watch_task(running, build.config.limits, sample.key, trace, MPI_COMM_SELF, [&] {
    trace.enter("sound", sample.key);
    preview.result =
        samples::row_maker(build.config, build.plan, sample.shape, folders, trace)(sample, record);
    if (preview.movie) samples::write_movie(build.config, sample, preview.result, folders);
  });
  write_sound(build.config, preview.result, output);
  preview.record = record.last_row(core::longest_shown);
  return preview;
}

}  // namespace carillon::dataset::run
