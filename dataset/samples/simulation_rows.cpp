#include "dataset/samples/simulation_rows.hpp"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <cmath>

#include "core/files.hpp"
#include "core/numbers.hpp"
#include "core/temporary_folder.hpp"
#include "dataset/samples/detail/simulation_columns.hpp"
#include "dataset/samples/sample_row.hpp"
#include "render/movie.hpp"

namespace carillon::dataset::samples {

SimulationRows::SimulationRows(const configuration::BuildConfig& config,
                               const plan::BuildPlan& plan, const BuildFolders& folders,
                               core::Trace& trace)
    : config_(config), plan_(plan), trace_(trace), maker_(config, plan, folders, trace) {
  if (config.mel) mel_ = std::make_unique<synth::signal::MelSpectrogram>(*config.mel);
}

SampleResult SimulationRows::add(const plan::Sample& sample, core::Columns& columns) {
  Simulation simulation = maker_.make(sample, &columns);
  add_simulation_columns(config_, plan_, sample, simulation, columns);
  SampleResult result;
  result.sound = std::move(simulation.sound);
  result.frames = std::move(simulation.frames);
  result.peak = core::peak(result.sound.audio);
  add_sound_columns(config_, result, mel_.get(), trace_, columns);
  return result;
}

std::vector<std::string> movie_files(const plan::Sample& sample, const BuildFolders& folders) {
  namespace fs = std::filesystem;
  const fs::path movie = fs::path("movies") / (sample.key + ".mp4");
  if (fs::exists(folders.output / movie)) return {movie.string()};
  std::vector<std::string> files;
  const fs::path folder = fs::path("movies") / sample.key;
  if (!fs::is_directory(folders.output / folder)) return files;
  for (const auto& entry : fs::directory_iterator(folders.output / folder)) {
    files.push_back((folder / entry.path().filename()).string());
  }
  std::sort(files.begin(), files.end());
  return files;
}

std::vector<std::string> write_movie(const configuration::BuildConfig& config,
                                     const plan::Sample& sample, const SampleResult& result,
                                     const BuildFolders& folders) {
  namespace fs = std::filesystem;
  const core::TemporaryFolder temporary;
  std::vector<fs::path> frames;
  for (std::size_t f = 0; f < result.frames.size(); ++f) {
    frames.push_back(render::frame_path(temporary.path(), static_cast<int>(f)));
    core::write_png(frames.back(), result.frames[f].color);
  }
  const fs::path sound = temporary.path() / "sound.wav";
  core::write_wav(sound, scene::clip_of(result.sound), config.scene.audio.dtype);
  const fs::path movie = temporary.path() / "movie.mp4";
  const render::MovieResult made =
      render::make_movie(movie, temporary.path(), config.motion->camera->rate, sound);
  std::vector<std::string> written;
  const auto keep = [&](const fs::path& from, const fs::path& to) {
    core::write_durably(folders.output / to, [&](const fs::path& path) {
      fs::copy_file(from, path, fs::copy_options::overwrite_existing);
    });
    written.push_back(to.string());
  };
  if (made.made) {
    keep(movie, fs::path("movies") / (sample.key + ".mp4"));
    return written;
  }
  spdlog::warn("{}: no movie, but its frames and sound in {}: {}", sample.key,
               (fs::path("movies") / sample.key).string(), made.message);
  for (const fs::path& frame : frames)
    keep(frame, fs::path("movies") / sample.key / frame.filename());
  keep(sound, fs::path("movies") / sample.key / "sound.wav");
  return written;
}

}  // namespace carillon::dataset::samples
