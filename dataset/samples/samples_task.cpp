#include "dataset/samples/samples_task.hpp"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include "core/audio.hpp"
#include "core/columns.hpp"
#include "core/files.hpp"
#include "core/text.hpp"
#include "dataset/samples/sample_row.hpp"
#include "dataset/samples/simulation_rows.hpp"
#include "scene/chain.hpp"
#include "scene/columns.hpp"
#include "synth/recording/recording_chain.hpp"

namespace carillon::dataset::samples {

void write_mel_attributes(const synth::signal::MelOptions& mel, const core::Hdf5Group& file) {
  file.write_attribute("scale", "slaney", "mel");
  file.write_attribute("norm", "slaney (area)", "mel");
  file.write_attribute("power", 2.0, "mel");
  file.write_attribute("window", "hann, periodic", "mel");
  file.write_attribute("padding", "centred, zeros", "mel");
  file.write_attribute("fft_size", static_cast<std::int64_t>(mel.fft_size), "mel");
  file.write_attribute("hop", static_cast<std::int64_t>(mel.hop), "mel");
  file.write_attribute("computed_bands", static_cast<std::int64_t>(mel.bands), "mel");
  file.write_attribute("min_frequency_hz", mel.min_frequency, "mel");
  file.write_attribute("max_frequency_hz", mel.max_frequency, "mel");
}

namespace {

/// sounds/cup-001/glass-1-strike-0003.wav, sounds/simulation-0003.wav
std::filesystem::path sound_path(const configuration::BuildConfig& config, const plan::Shape& shape,
                                 const plan::Sample& sample) {
  if (config.motion) return std::filesystem::path("sounds") / (sample.key + ".wav");
  const plan::Variant& variant = shape.variants[sample.variant];
  return std::filesystem::path("sounds") / shape.id /
         fmt::format("{}-{}-strike-{:04}.wav", core::file_safe(variant.material),
                     plan::size_name(variant), sample.strike);
}

/// One channel per listener.
void write_sound(const configuration::BuildConfig& config, const std::filesystem::path& path,
                 const SampleResult& result, const BuildFolders& folders) {
  core::write_durably(folders.output / path, [&](const std::filesystem::path& temporary) {
    core::write_wav(temporary, scene::clip_of(result.sound), config.scene.audio.dtype);
  });
}

/// Files beside a task's shard; they go with it where the task fails.
class SideFiles {
 public:
  explicit SideFiles(const BuildFolders& folders) : folders_(folders) {}
  SideFiles(const SideFiles&) = delete;
  SideFiles& operator=(const SideFiles&) = delete;
  ~SideFiles() {
    std::error_code ignored;
    for (const std::string& file : fresh_) std::filesystem::remove(folders_.output / file, ignored);
  }
  void add(const std::string& file) { fresh_.push_back(file); }
  void keep() { fresh_.clear(); }

 private:
  const BuildFolders& folders_;
  std::vector<std::string> fresh_;
};

}  // namespace

std::vector<std::string> run_samples_task(const configuration::BuildConfig& config,
                                          const plan::BuildPlan& plan, const plan::BuildTask& task,
                                          const BuildFolders& folders, core::Trace& trace,
                                          std::size_t kept) {
  const plan::Shape& shape = plan.shapes[task.shape];
  trace.enter("sound", plan.samples[task.first].key);
  const AddRow add_row = row_maker(config, plan, task.shape, folders, trace);
  const bool movies = config.scene.runs("movie") && config.motion->camera->movie;
  core::Columns columns(scene::columns());
  std::vector<std::string> written;
  SideFiles side(folders);
  std::size_t silent = 0;
  for (std::size_t i = task.first; i < task.first + task.count; ++i) {
    const plan::Sample& sample = plan.samples[i];
    const std::string sound = sound_path(config, shape, sample).string();
    if (config.wav) written.push_back(sound);
    if (i < task.first + kept) {
      if (movies) {
        const std::vector<std::string> files = movie_files(sample, folders);
        written.insert(written.end(), files.begin(), files.end());
      }
      continue;
    }
    trace.enter("sound", sample.key);
    const SampleResult result = add_row(sample, columns);
    if (config.scene.audio.dtype == core::SampleFormat::int16 && result.peak > 0 &&
        synth::recording::silent_after_rounding(result.sound.audio, 16)) {
      ++silent;
    }
    if (config.wav) {
      trace.enter("write", sample.key);
      write_sound(config, sound, result, folders);
      side.add(sound);
    }
    if (movies) {
      trace.enter("write", sample.key);
      const core::ScopedTimer timer(trace.stages["write movie"]);
      for (const std::string& file : write_movie(config, sample, result, folders)) {
        side.add(file);
        written.push_back(file);
      }
    }
  }
  if (silent > 0) {
    spdlog::warn("{}: {} of {} sounds are nothing but zeros in 16 bits; raise audio.gain", task.key,
                 silent, task.count);
  }
  trace.enter("write");
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
  side.keep();
  written.push_back(std::filesystem::relative(folders.shard_file(task), folders.output).string());
  return written;
}

}  // namespace carillon::dataset::samples
