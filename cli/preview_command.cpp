#include <fmt/format.h>

#include <memory>
#include <nlohmann/json.hpp>

#include "cli/command_line.hpp"
#include "cli/commands.hpp"
#include "dataset/run/preview.hpp"

namespace carillon::cli {

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
    require_output_folder(context, options->output);
    dataset::run::LoadedBuild build = dataset::run::load_build(options->build, context.world);
    const dataset::run::Preview preview = dataset::run::preview_sample(
        build, options->sample, options->output, context.cache, context.world);
    if (!context.speaks()) return;
    const dataset::plan::Sample& sample = *preview.sample;
    const dataset::samples::SampleResult& result = preview.result;
    nlohmann::json summary = {{"sample", sample.key},     {"id", sample.id},
                              {"peak", result.peak},      {"unit", result.sound.rings.readout.unit},
                              {"record", preview.record}, {"folder", options->output}};
    if (!preview.moving) summary["modes"] = result.sound.modes;
    if (context.json) {
      fmt::print("{}\n", summary.dump(2));
      return;
    }
    const std::string what =
        preview.moving ? fmt::format("{} strikes", preview.record["strikes"].get<std::int64_t>())
                       : fmt::format("{} modes", result.sound.modes);
    fmt::print("{}: {}, peak {:.3g} {}; sound.wav, spectrogram.png{} pictures/ in {}\n", sample.key,
               what, result.peak, result.sound.rings.readout.unit,
               preview.movie ? ", movies/ and" : " and", options->output);
  });
}

}  // namespace carillon::cli
