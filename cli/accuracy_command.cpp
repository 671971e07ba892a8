#include <fmt/format.h>

#include <algorithm>
#include <memory>

#include "cli/command_line.hpp"
#include "core/config.hpp"
#include "core/error.hpp"
#include "eval/accuracy/accuracy.hpp"
#include "eval/accuracy/findings.hpp"
#include "eval/studies/picture.hpp"
#include "mpi/comm.hpp"

namespace carillon::cli {

namespace {

/// Whether the sounds or the features could not be measured.
bool part_failed(const nlohmann::json& document) {
  return document.value("sound", nlohmann::json::object()).contains("failure") ||
         document.value("features", nlohmann::json::object()).contains("failure");
}

void print_sounds(const nlohmann::json& sound) {
  if (sound.contains("failure")) {
    fmt::print("\nsound: {}\n", sound.at("failure").get<std::string>());
  } else if (sound.contains("levels")) {
    fmt::print("\nsound of {}, {} modes\n{:<14}{:>8}{:>12}{:>10}\n",
               sound.at("body").get<std::string>(), sound.at("modes").get<int>(), "", "", "s",
               "dB");
    for (const nlohmann::json& level : sound.at("levels")) {
      const nlohmann::json& error = level.at("error_db");
      fmt::print("{:<14}{:>8}{:>12.2g}{:>10}\n", level.at("key").get<std::string>(),
                 level.at("value").get<int>(), level.at("seconds").get<double>(),
                 error.is_null() ? "silent" : fmt::format("{:.3g}", error.get<double>()));
    }
  }
}

void print_features(const nlohmann::json& features) {
  if (features.contains("failure")) {
    fmt::print("\nfeatures: {}\n", features.at("failure").get<std::string>());
  } else if (features.contains("levels")) {
    const auto bounds = [](const nlohmann::json& value) {
      return value.is_null() ? "-" : fmt::format("{:.3g}", value.get<double>());
    };
    fmt::print(
        "\nfeatures, errors over the Cramer-Rao bound\n{:<8}{:>7}{:>8}{:>10}{:>8}{:>12}{:>12}\n",
        "method", "modes", "dB", "s", "found", "frequency", "decay rate");
    for (const nlohmann::json& level : features.at("levels")) {
      fmt::print("{:<8}{:>7}{:>8}{:>10.2g}{:>7.0f}%{:>12}{:>12}\n",
                 level.at("method").get<std::string>(), level.at("modes").get<int>(),
                 level.at("snr_db").get<double>(), level.at("seconds").get<double>(),
                 100 * level.at("found").get<double>(), bounds(level.at("bounds_frequency")),
                 bounds(level.at("bounds_decay_rate")));
    }
  }
}

/// @return the exit code, the same on every rank
int run_accuracy(const eval::accuracy::AccuracyOptions& options, const mpi::Context& context) {
  std::string text;
  mpi::agreed(context.world, [&] {
    if (context.speaks()) text = core::read_text_file(options.config);
  });
  text = mpi::broadcast(text, 0, context.world);
  eval::accuracy::AccuracyConfig config;
  mpi::agreed(context.world, [&] {
    config = eval::accuracy::read_accuracy_config(text, options.config, options.overrides);
  });

  const std::filesystem::path output = options.output.empty() ? config.name : options.output;
  mpi::agreed(context.world, [&] {
    if (!context.speaks()) return;
    std::error_code error;
    std::filesystem::create_directories(output, error);
    if (error) throw core::FileError(fmt::format("{}: {}", output.string(), error.message()));
  });
  const nlohmann::json document = eval::accuracy::measure_accuracy(config, output, context);
  bool failed = false;
  if (context.speaks()) {
    const nlohmann::json& objects = document.at("objects");
    failed = std::any_of(objects.begin(), objects.end(), eval::accuracy::has_failed) ||
             part_failed(document);
  }
  failed = mpi::broadcast(failed ? "failed" : "", 0, context.world) == "failed";
  const int exit_code = failed ? mpi::exit_failures : mpi::exit_done;
  if (!context.speaks()) return exit_code;

  const std::string no_picture =
      eval::studies::draw_picture("plot_accuracy", output / "accuracy.json");
  if (context.json) {
    fmt::print("{}\n", document.dump(1));
  } else {
    for (const nlohmann::json& object : document.at("objects"))
      eval::accuracy::print_findings(object);
    print_sounds(document.value("sound", nlohmann::json::object()));
    print_features(document.value("features", nlohmann::json::object()));
    fmt::print("\n{}: accuracy.json{}\n", output.string(),
               no_picture.empty() ? ", accuracy.svg, accuracy.png" : "");
  }
  if (!no_picture.empty()) fmt::print(stderr, "carillon: {}\n", no_picture);
  return exit_code;
}

}  // namespace

void add_accuracy(Program& program, mpi::Context& context) {
  Command& command =
      program.add("accuracy", "the convergence study: seconds against pitch errors", Needs::solver);
  auto options = std::make_shared<eval::accuracy::AccuracyOptions>();
  command.option("config", options->config, "YAML configuration").required();
  command.option("-o,--output", options->output,
                 "folder of the findings (default: the configuration's name)");
  command
      .option("--set", options->overrides,
              "key=value instead of the configuration's, e.g. modes=60")
      .one_value_each();
  command.footer(
      "Examples:\n"
      "  carillon accuracy configs/accuracy.yaml\n"
      "  carillon accuracy configs/accuracy.yaml --set objects[6].mesh=scan.ply -o study\n"
      "Exit code 3: a body or a target could not be measured; the others are in accuracy.json.");
  command.does([&context, options] { context.exit_code = run_accuracy(*options, context); });
}

}  // namespace carillon::cli
