#include <spdlog/spdlog.h>

#include "cli/command_line.hpp"
#include "cli/context.hpp"
#include "dataset/regenerate/regenerate.hpp"
#include "mpi/comm.hpp"

namespace carillon::cli {

void add_regenerate(Program& program, Context& context) {
  auto options = std::make_shared<dataset::regenerate::RegenerateOptions>();
  Command& command = program.add(
      "regenerate", "samples of a dataset again, compared with what is stored", Needs::solver);
  command.option("dataset", options->dataset, "folder of a dataset").required();
  command
      .option(
          "--sample", options->samples,
          "row of index.h5, key (shape/material/size/strike-NNNN, simulation-NNNN) or id; may be "
          "repeated")
      .required()
      .one_value_each();
  command
      .option("--set", options->overrides,
              "key=value: the same sample with one thing changed; what is drawn for "
              "everything else stays")
      .one_value_each();
  command.option("-o,--output", options->output, "WAV file; for several samples a folder of them");
  command.option("--inputs", options->inputs,
                 "folder that paths in the configuration (recordings of noise) are meant from");
  command.footer(
      "Ends with 0 when every sample is identical to what is stored (with --set: was made), with "
      "3\n"
      "when one differs or is not stored.\n"
      "Examples:\n"
      "  carillon regenerate kitchen --sample 12 -o again.wav\n"
      "  carillon regenerate kitchen --sample 12 --set noise.snr=0 -o louder-noise.wav");
  command.does([&context, options] {
    options->samples.size() == 1 ? require_output_file(context, options->output)
                                 : require_output_folder(context, options->output);
    int exit_code = mpi::exit_done;
    mpi::agreed(context.world, [&] {
      if (!context.speaks()) return;
      options->cache = context.cache;
      const dataset::regenerate::Regenerated made = dataset::regenerate::regenerate(*options);
      for (const std::string& doubt : made.doubts) spdlog::warn("{}", doubt);
      for (const auto& [shape, why] : made.modes) {
        spdlog::warn("{}: modes solved again: {}", shape, why);
      }
      teller(context)(dataset::regenerate::regenerated_text(made),
                      dataset::regenerate::to_json(made));
      exit_code = made.as_expected() ? mpi::exit_done : mpi::exit_failures;
    });
    context.exit_code = std::stoi(mpi::broadcast(std::to_string(exit_code), 0, context.world));
  });
}

}  // namespace carillon::cli
