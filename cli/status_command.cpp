#include <fmt/format.h>
#include <unistd.h>

#include <chrono>
#include <thread>

#include "cli/command_line.hpp"
#include "cli/commands.hpp"
#include "core/log.hpp"
#include "dataset/run/status.hpp"
#include "mpi/exit_code.hpp"

namespace carillon::cli {

namespace {

using nlohmann::ordered_json;

/// Looks until the build has ended.
ordered_json watch(const std::string& folder, bool json) {
  constexpr std::chrono::seconds between_looks(1);
  constexpr int looks_between_lines = 10;
  const bool terminal = isatty(STDERR_FILENO) == 1;
  ordered_json status = dataset::run::read_status(folder);
  for (int look = 0; status.at("state") == "running"; ++look) {
    const std::string line = dataset::run::status_line(status);
    if (json) {
      fmt::print("{}\n", status.dump());
      std::fflush(stdout);
    } else if (terminal) {
      core::draw_status_line(line, false);
    } else if (look % looks_between_lines == 0) {
      fmt::print("{} {}\n", core::date_and_time(), line);
      std::fflush(stdout);
    }
    std::this_thread::sleep_for(between_looks);
    status = dataset::run::read_status(folder);
  }
  if (terminal && !json) core::leave_status_line();
  return status;
}

}  // namespace

void add_status(Program& program, Context& context) {
  struct Options {
    std::string folder;
    bool watch = false;
  };
  Command& command = program.add("status", "how far a build is, or how it ended", Needs::nothing);
  auto options = std::make_shared<Options>();
  command.option("folder", options->folder, "of the dataset or the sweep").required();
  command.flag("--watch", options->watch,
               "look every second until the build has ended, and end with its exit code");
  command.footer(
      "Example:\n"
      "  carillon status carillon-smoke --watch && carillon check carillon-smoke\n"
      "Reads status.json (docs/format.md); with --json that, and with --watch a line each second.");
  command.does([&context, options] {
    if (!context.speaks()) return;
    const ordered_json status = options->watch ? watch(options->folder, context.json)
                                               : dataset::run::read_status(options->folder);
    teller(context)(dataset::run::status_text(status), status);
    if (!options->watch) return;
    const ordered_json& code = status.at("exit_code");
    context.exit_code = code.is_number_integer() ? code.get<int>() : mpi::exit_internal;
  });
}

}  // namespace carillon::cli
