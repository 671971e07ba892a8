#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>

#include "cli/command_line.hpp"
#include "dataset/regenerate/regenerate.hpp"
#include "mpi/comm.hpp"

namespace carillon::cli {

using nlohmann::json;

namespace {

std::string in_words(const json& difference) {
  const auto text = [](const json& value) {
    return value.is_null() ? std::string("nothing") : value.dump();
  };
  const std::string column = difference.at("column").get<std::string>();
  if (difference.contains("difference_db")) {
    const json& level = difference.at("difference_db");
    return level.is_number() && level.get<double>() < 1e6
               ? fmt::format("{}: differs by {:.1f} dB of its energy", column, level.get<double>())
               : fmt::format("{}: is silent on one side", column);
  }
  return fmt::format("{}: stored {}, made {}", column, text(difference.at("stored")),
                     text(difference.at("made")));
}

void print(const json& report) {
  for (const json& sample : report.at("samples")) {
    const bool stored = sample.at("stored").get<bool>();
    const bool identical = stored && sample.at("identical").get<bool>();
    fmt::print("{}: {}\n", sample.at("key").get<std::string>(),
               identical ? "identical"
               : stored  ? fmt::format("{} columns differ", sample.at("differences").size())
                         : "made; the dataset does not hold it");
    if (stored) {
      for (const json& difference : sample.at("differences")) {
        fmt::print("  {}\n", in_words(difference));
      }
    }
    if (sample.contains("wav")) fmt::print("  {}\n", sample.at("wav").get<std::string>());
  }
  for (const auto& [name, version] : report.at("versions").items()) {
    fmt::print("{}: built with {}, here {}\n", name, version.at("stored").dump(),
               version.at("here").dump());
  }
}

/// Every sample is as it is stored; with --set, was made.
bool as_expected(const json& report) {
  if (!report.at("changed").empty()) return true;
  const json& samples = report.at("samples");
  return std::all_of(samples.begin(), samples.end(), [](const json& sample) {
    return sample.at("stored").get<bool>() && sample.at("identical").get<bool>();
  });
}

}  // namespace

void add_regenerate(Program& program, mpi::Context& context) {
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
    int exit_code = mpi::exit_done;
    mpi::agreed(context.world, [&] {
      if (!context.speaks()) return;
      const json report = dataset::regenerate::regenerate(*options, context);
      for (const json& doubt : report.at("doubts")) {
        spdlog::warn("{}", doubt.get<std::string>());
      }
      for (const json& solved : report.at("modes")) {
        spdlog::warn("{}: modes solved again: {}", solved.at("shape").get<std::string>(),
                     solved.at("why").get<std::string>());
      }
      if (context.json) {
        fmt::print("{}\n", report.dump(2));
      } else {
        print(report);
      }
      exit_code = as_expected(report) ? mpi::exit_done : mpi::exit_failures;
    });
    context.exit_code = std::stoi(mpi::broadcast(std::to_string(exit_code), 0, context.world));
  });
}

}  // namespace carillon::cli
