#include <fmt/format.h>

#include <memory>

#include "cli/command_line.hpp"
#include "cli/commands.hpp"
#include "core/files.hpp"
#include "mpi/made_by.hpp"
#include "report/report.hpp"

namespace carillon::cli {

using nlohmann::ordered_json;

namespace {

struct ReportOptions {
  report::PageRequest page;
  std::string output = "report.html";
};

void write_report(const ReportOptions& options, const Context& context) {
  report::PageRequest request = options.page;
  request.made = mpi::made_by(context.command, context.world);
  const report::Page page = report::make_page(request);
  core::write_text_durably(options.output, page.html);
  if (context.json) {
    fmt::print("{}\n", ordered_json{{"output", options.output},
                                    {"bytes", page.html.size()},
                                    {"datasets", page.datasets},
                                    {"studies", page.studies},
                                    {"objects", page.objects},
                                    {"notes", page.notes}}
                           .dump(1));
    return;
  }
  fmt::print("{}: {:.1f} MB\n", options.output, static_cast<double>(page.html.size()) / 1e6);
  for (const std::string& note : page.notes) fmt::print("  {}\n", note);
}

void run_report(const ReportOptions& options, const Context& context) {
  require_output_file(context, options.output);
  on_one_rank(context, [&] { write_report(options, context); });
}

}  // namespace

void add_report(Program& program, Context& context) {
  Command& command = program.add(
      "report", "one page that shows datasets, what accuracy costs and what can be learnt",
      Needs::ranks);
  auto options = std::make_shared<ReportOptions>();
  command
      .option("folders", options->page.folders,
              "folders that build, accuracy, evaluate or scripts/nightly made, or that hold such")
      .required();
  command.option("-o,--output", options->output, "HTML file").show_default();
  command.option("--sounds", options->page.sounds, "samples to hear, of all datasets together")
      .show_default();
  command.option("--objects", options->page.objects, "objects to strike, of all datasets together")
      .show_default();
  command.footer(
      "The page needs no network: open it in a browser, send it, print it.\n"
      "Examples:\n"
      "  carillon report carillon-smoke -o report.html\n"
      "  carillon report carillon-smoke carillon-accuracy carillon-learning-smoke\n"
      "docs/report.md");
  command.does([&context, options] { run_report(*options, context); });
}

}  // namespace carillon::cli
