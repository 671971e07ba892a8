#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <nlohmann/json.hpp>

#include "cli/command_line.hpp"
#include "cli/context.hpp"
#include "core/audio.hpp"
#include "core/error.hpp"
#include "core/image.hpp"
#include "core/numbers.hpp"
#include "dataset/run/build.hpp"
#include "dataset/samples/sample_row.hpp"
#include "dataset/samples/simulation_rows.hpp"
#include "mpi/comm.hpp"
#include "mpi/running_task.hpp"
#include "scene/chain.hpp"
#include "scene/columns.hpp"

namespace carillon::cli {

namespace {

/// A sample by its number in the plan, its id or its key.
const dataset::plan::Sample& find_sample(const dataset::plan::BuildPlan& plan,
                                         const std::string& name) {
  std::uint64_t number = 0;
  const auto [end, error] = std::from_chars(name.data(), name.data() + name.size(), number);
  const bool numeric = error == std::errc() && end == name.data() + name.size();
  if (numeric && number < plan.samples.size()) return plan.samples[number];
  std::vector<std::string> keys;
  for (const dataset::plan::Sample& sample : plan.samples) {
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
core::Image spectrogram_picture(const std::vector<float>& mel, int bands, int frames) {
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

}  // namespace

void add_preview(Program& program, Context& context) {
  struct Options {
    dataset::run::BuildOptions build;
    std::string sample = "0";
    std::string output = "preview";
  };
  Command& command = program.add(
      "preview", "one sample of a configuration as WAV, spectrogram and picture, before any build",
      Needs::solver);
  auto options = std::make_shared<Options>();
  command.option("config", options->build.config, "YAML configuration").required();
  command.option("--sample", options->sample, "number, id or key of the sample").show_default();
  command.option("-o,--output", options->output, "folder for the files").show_default();
  command.option("--set", options->build.overrides, "key=value instead of the configuration's")
      .one_value_each();
  command.footer("Example:\n  carillon preview configs/smoke.yaml --sample 3");
  command.does([&context, options] {
    dataset::run::LoadedBuild build = dataset::run::load_build(options->build, context.world);
    if (std::filesystem::exists(std::filesystem::path(options->output) / "journal.jsonl")) {
      throw core::InputError(fmt::format("{} holds a dataset", options->output),
                             "choose another folder with --output");
    }
    if (!build.config.mel) {
      build.config.mel =
          synth::signal::MelOptions{.sample_rate = build.config.scene.audio.sample_rate};
    }
    if (!build.config.camera) build.config.camera = render::Camera{};
    if (build.config.motion && build.config.motion->camera) {
      build.config.motion->camera->movie = true;
    }
    build.config.png = true;
    const dataset::plan::Sample& sample = find_sample(build.plan, options->sample);
    const dataset::samples::BuildFolders folders{options->output, context.cache};
    core::Trace trace;
    // Nobody reads what it would write, but it ends what hangs, as in a build.
    mpi::RunningTask running("", mpi::exit_input);
    for (const std::size_t s : dataset::plan::shapes_of(build.plan, sample)) {
      dataset::configuration::watch_task(
          running, build.config.limits, sample.key, trace, context.world, [&] {
            dataset::samples::run_modes_task(build.config, build.plan.shapes[s], folders,
                                             context.world, trace);
          });
    }
    if (!context.speaks()) return;

    core::Columns record(scene::columns());
    dataset::samples::SampleResult result;
    dataset::configuration::watch_task(
        running, build.config.limits, sample.key, trace, MPI_COMM_SELF, [&] {
          trace.enter("sound", sample.key);
          result = dataset::samples::row_maker(build.config, build.plan, sample.shape, folders,
                                               trace)(sample, record);
          if (build.config.scene.runs("movie")) {
            dataset::samples::write_movie(build.config, sample, result, folders);
          }
        });
    const std::size_t count = build.config.scene.audio.samples();
    core::write_wav(folders.output / "sound.wav", scene::clip_of(result.sound),
                    core::SampleFormat::float32);
    const std::vector<float> mel = synth::signal::MelSpectrogram(*build.config.mel)(
        std::span(result.sound.audio).first(count));
    core::write_png(folders.output / "spectrogram.png",
                    spectrogram_picture(mel, build.config.mel->bands,
                                        synth::signal::mel_frames(count, *build.config.mel)));
    nlohmann::json summary = {{"sample", sample.key},
                              {"id", sample.id},
                              {"peak", result.peak},
                              {"unit", result.sound.rings.readout.unit},
                              {"record", record.last_row(core::longest_shown)},
                              {"folder", options->output}};
    if (!build.config.motion) summary["modes"] = result.sound.modes;
    if (context.json) {
      fmt::print("{}\n", summary.dump(2));
      return;
    }
    const std::string what =
        build.config.motion
            ? fmt::format("{} strikes", summary["record"]["strikes"].get<std::int64_t>())
            : fmt::format("{} modes", result.sound.modes);
    fmt::print("{}: {}, peak {:.3g} {}; sound.wav, spectrogram.png{} pictures/ in {}\n", sample.key,
               what, result.peak, result.sound.rings.readout.unit,
               build.config.scene.runs("movie") ? ", movies/ and" : " and", options->output);
  });
}

}  // namespace carillon::cli
