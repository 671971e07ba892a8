#include <fmt/format.h>

#include <memory>
#include <nlohmann/json.hpp>

#include "cli/command_line.hpp"
#include "cli/commands.hpp"
#include "dataset/check/check_dataset.hpp"

namespace carillon::cli {

using nlohmann::json;

namespace {

struct CheckOptions {
  std::string dataset;
  std::string inputs;
};

/// A dataset's findings, to a person or a program.
void tell(const dataset::check::CheckedDataset& checked, const core::Tell& tell) {
  json checks = json::array();
  for (const dataset::check::Finding& finding : checked.findings) {
    checks.push_back(dataset::check::to_json(finding));
  }
  tell(fmt::format("{}: {} samples of {} shapes{}\n{}", checked.name, checked.samples,
                   checked.shapes, checked.building ? "; a build is writing to it" : "",
                   dataset::check::findings_text(checked.findings)),
       json{{"dataset", checked.name},
            {"samples", checked.samples},
            {"shapes", checked.shapes},
            {"building", checked.building},
            {"passed", checked.passed},
            {"checks", checks}});
}

void run_check(const CheckOptions& options, Context& context) {
  const dataset::check::CheckedDataset checked =
      dataset::check::check_dataset(options.dataset, options.inputs, context.world);
  if (context.speaks()) tell(checked, teller(context));
  context.exit_code = checked.passed ? mpi::exit_done : mpi::exit_failures;
}

}  // namespace

void add_check(Program& program, Context& context) {
  Command& command = program.add(
      "check", "a dataset: checksums, columns, index, counts, values, leaks between parts",
      Needs::ranks);
  auto options = std::make_shared<CheckOptions>();
  command.option("dataset", options->dataset, "folder of a dataset").required();
  command.option("--inputs", options->inputs,
                 "folder that paths in the configuration (recordings of noise) are meant from");
  command.footer(
      "Ends with 0 when every check passes, with 3 when one fails, with 2 when it is no dataset.\n"
      "Ranks share the reading.\n"
      "Example:\n  carillon check kitchen");
  command.does([&context, options] { run_check(*options, context); });
}

}  // namespace carillon::cli
